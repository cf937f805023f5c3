"""A term that was found, with its numbers, how sure they are, and what it looks like."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from evenspin.empirical.library import Family, Shape

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LookAlike:
    """Another family that would take off nearly as much. `behind`: cost by which it is worse."""

    family: str
    behind: float


@dataclass(frozen=True, slots=True)
class Curve:
    """The term over what it depends on: its value with a band of 95 %, and what the log shows, averaged in bins."""

    over: str
    unit: str
    x: Array
    value: Array
    half: Array
    data_x: Array
    data: Array


@dataclass(frozen=True, slots=True)
class EmpiricalTerm:
    """`coefficients` belong to the columns of the family at `shape`; `covariance` is theirs. `t`: how many standard
    errors it takes off on stretches that no fit saw. `share`: of the squared gap, closed by it there."""

    name: str  # of the term in the fit
    family: Family
    shape: Shape
    coefficients: Array
    covariance: Array
    shape_half: tuple[float, ...]  # 95 %
    t: float
    share: float
    speeds_rad_s: tuple[float, float]  # at which the log shows it
    look_alikes: tuple[LookAlike, ...] = ()
    log: str = ""  # of this log alone
    facts: Mapping[str, float] = field(default_factory=dict)  # of the machine and the log, for words and sizes
    curve: Curve | None = None

    @property
    def size(self) -> float:
        """Amplitude of a line, else the first coefficient."""
        if self.family.name in LINES:
            return float(np.hypot(*self.coefficients[:2]))
        return float(self.coefficients[0])

    @property
    def size_half(self) -> float:
        own = self.coefficients[:2] if self.family.name in LINES else self.coefficients[:1]
        part = self.covariance[: len(own), : len(own)]
        along = own / max(float(np.linalg.norm(own)), 1e-300)
        return 1.96 * math.sqrt(max(float(along @ part @ along), 0.0))

    @property
    def phase_rad(self) -> float:
        """Of a line: amplitude times sin(order theta + phase)."""
        return float(np.arctan2(self.coefficients[1], self.coefficients[0]))

    def parameters(self) -> dict[str, float]:
        found = dict(zip(self.family.shape, self.shape, strict=True))
        found[size_name(self.family)] = self.size
        if self.family.name in LINES:
            found["phase_rad"] = self.phase_rad
        elif self.family.main:
            found[f"{size_name(self.family)}_at_start"] = float(self.coefficients[1])
        elif len(self.coefficients) > 1:
            found |= {f"{size_name(self.family)}_{k + 1}": float(z) for k, z in enumerate(self.coefficients)}
        return found

    def intervals(self) -> dict[str, dict[str, float]]:
        """95 %, with the 3 % by which two honest models of one cause differ."""
        found = {}
        for name, value, half in zip(self.family.shape, self.shape, self.shape_half, strict=True):
            if half > 0.0:
                found[name] = {"value": value, "low": value - half, "high": value + half}
        half = float(np.hypot(self.size_half, 0.03 * self.size))
        found[size_name(self.family)] = {"value": self.size, "low": self.size - half, "high": self.size + half}
        return found


LINES = ("angle_line", "torque_frequency", "supply_frequency", "voltage_offset")
SIZES = {"N m": "torque_nm", "V": "voltage_v", "ohm": "resistance_ohm", "1": "share"}


def size_name(family: Family) -> str:
    return SIZES[family.unit]
