"""Guo et al. 2024, Actuators 13, 73: fal-FORC against FORC, CRC and PI. See docs/reference/guo2024.md."""

from evenspin.reproduce.guo2024.result import METHODS, SETS, Result, reproduce

__all__ = ["METHODS", "SETS", "Result", "reproduce"]
