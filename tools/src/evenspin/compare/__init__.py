"""Hold a log against the simulator: the same drive re-simulated from the log's references alone."""

from evenspin.compare.gap import GAP_SIGNALS, CaseGap, RecordGap, case_gap, record_gap
from evenspin.compare.resimulate import LOCKED, VALIDATION, Replay, Unit, resimulate

__all__ = [
    "GAP_SIGNALS",
    "LOCKED",
    "VALIDATION",
    "CaseGap",
    "RecordGap",
    "Replay",
    "Unit",
    "case_gap",
    "record_gap",
    "resimulate",
]
