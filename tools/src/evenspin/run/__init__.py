"""`evenspin run`: a scenario from file to log, summary and pictures."""

from evenspin.run.output import run_signals, segment_table, summary_of, write_run

__all__ = ["run_signals", "segment_table", "summary_of", "write_run"]
