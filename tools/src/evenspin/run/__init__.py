"""`evenspin run`: a scenario from file to log, summary and pictures."""

from evenspin.run.output import assumed, run_signals, summary_of, write_run
from evenspin.run.tables import run_tables, steady_table

__all__ = ["assumed", "run_signals", "run_tables", "steady_table", "summary_of", "write_run"]
