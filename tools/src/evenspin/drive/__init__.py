"""The virtual drive: the firmware on the simulated plant behind the same link that a real drive has."""

from evenspin.drive.virtual import PERIODS_PER_MS, VirtualDrive

__all__ = ["PERIODS_PER_MS", "VirtualDrive"]
