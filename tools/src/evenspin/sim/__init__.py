"""Run a scenario through the library: the firmware on the simulated plant."""

from evenspin.sim.record import Record
from evenspin.sim.run import TRUTH, complete, prepare, simulate, truth_signals

__all__ = ["TRUTH", "Record", "complete", "prepare", "simulate", "truth_signals"]
