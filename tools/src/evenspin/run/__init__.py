"""`evenspin run`: a scenario from file to log, summary and pictures."""

from evenspin.run.output import assumed, run_signals, segment_table, summary_of, write_run

__all__ = ["assumed", "run_signals", "segment_table", "summary_of", "write_run"]
