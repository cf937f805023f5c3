"""Run a scenario through the library: the firmware on the simulated plant."""

from evenspin.sim.record import Record
from evenspin.sim.run import TRUTH, prepare, simulate, truth_signals

__all__ = ["TRUTH", "Record", "prepare", "simulate", "truth_signals"]
