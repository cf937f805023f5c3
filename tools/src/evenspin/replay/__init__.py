"""Replay of a recording: the fault in it with every signal around it, or the first difference (docs/replay.md)."""

from evenspin.replay.regression import write_test
from evenspin.replay.replayed import Fault, Replayed, Window, replay
from evenspin.replay.report import page_of, tables_of

__all__ = ["Fault", "Replayed", "Window", "page_of", "replay", "tables_of", "write_test"]
