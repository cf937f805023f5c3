"""Hold a log against the simulator: the same drive re-simulated from the log's references alone."""

from evenspin.compare.gap import GAP_SIGNALS, CaseGap, RecordGap, case_gap, record_gap
from evenspin.compare.resimulate import VALIDATION, resimulate

__all__ = ["GAP_SIGNALS", "VALIDATION", "CaseGap", "RecordGap", "case_gap", "record_gap", "resimulate"]
