"""The eight experiments of the measured-log format: their names, their classes, and what one commands.

`blind` and the referee have their own list and their own numbers on purpose: they check this one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from evenspin.model import InputCurve

EXPERIMENTS = (
    "staircase",
    "staircase_load",
    "load_step",
    "reversal",
    "coast_down",
    "standstill_steps",
    "validation",
    "validation_steps",
)
VALIDATION = ("validation", "validation_steps")  # nothing is fitted to them
FITTED = tuple(name for name in EXPERIMENTS if name not in VALIDATION)
LOCKED = ("standstill_steps", "validation_steps")  # rotor held, current mode
LOADED = ("staircase_load", "load_step", "validation")  # cannot be simulated without their torque reading
ALWAYS_LOADED = ("staircase_load",)  # the load never goes to zero

LOG_HZ, LOCKED_HZ = 2000.0, 10_000.0  # rows per second with a free and with a locked rotor
CURVES = ("speed_ref_rad_s", "id_ref_a", "iq_ref_a", "load_torque_nm")  # what an experiment commands


@dataclass(frozen=True, slots=True)
class Experiment:
    """What is commanded during one record. Curves begin at 0 s; what has none is 0."""

    name: str
    mode: Literal["speed", "current"]
    duration_s: float
    log_rate_hz: float
    curves: Mapping[str, InputCurve] = field(default_factory=dict)
    rotor_locked: bool = False
    current_from_s: float | None = None  # current mode from then on
    what: str = field(default="", compare=False)  # for the person at the bench

    @property
    def needs_load_machine(self) -> bool:
        return "load_torque_nm" in self.curves

    def value(self, name: str, t_s: float) -> float:
        """A curve at a time."""
        curve = self.curves.get(name)
        if curve is None:
            return 0.0
        if curve.linear:
            return float(np.interp(t_s, curve.t_s, curve.value))
        at = int(np.searchsorted(curve.t_s, t_s + 1e-9, side="right")) - 1
        return curve.value[max(at, 0)]
