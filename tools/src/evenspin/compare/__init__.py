"""Hold a log against the simulator: the same drive re-simulated from the log's references alone."""

from evenspin.compare.gap import CaseGap, case_gap, record_gap
from evenspin.compare.resimulate import Replay, resimulate

__all__ = ["CaseGap", "Replay", "case_gap", "record_gap", "resimulate"]
