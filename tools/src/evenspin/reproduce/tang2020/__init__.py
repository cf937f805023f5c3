"""Tang et al. 2020: the angle-based repetitive observer (ARO), DOB and RO. See docs/reference/tang2020.md."""

from evenspin.reproduce.tang2020.conditions import METHODS
from evenspin.reproduce.tang2020.result import Result, reproduce

__all__ = ["METHODS", "Result", "reproduce"]
