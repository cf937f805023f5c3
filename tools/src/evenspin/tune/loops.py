"""Current loop and speed loop as the drive samples them, and their margins. The margins are python-control's.

Current loop, each axis by itself, rotor at rest, T = 1 PWM period; the voltage of a sample acts in the next period:

    C(z) = k_p + k_i T / (z - 1),    P(z) = (1 - a) / (R z (z - a)),  a = exp(-R T / L)                       (1)

Speed loop: design/sampled.py gives M from an added speed error to the measured speed; the loop itself is M / (1 - M).
"""

from __future__ import annotations

import importlib
import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from evenspin.design.sampled import Sampled, sampled_loop

Numbers = Mapping[str, float]

POINTS = 160


@dataclass(frozen=True, slots=True)
class Margins:
    """`distance`: least distance from -1, 1 / max |S|; `delay_s`: what the loop takes in addition."""

    phase_deg: float
    gain: float
    distance: float
    crossover_hz: float

    @property
    def delay_s(self) -> float:
        return (
            math.radians(self.phase_deg) / (2.0 * math.pi * self.crossover_hz) if self.crossover_hz > 0.0 else math.inf
        )

    @property
    def gain_db(self) -> float:
        return 20.0 * math.log10(self.gain) if 0.0 < self.gain < math.inf else math.inf

    def as_json(self) -> dict[str, float | None]:
        numbers = {
            "phase_deg": self.phase_deg, "gain_db": self.gain_db, "delay_s": self.delay_s,
            "distance": self.distance, "crossover_hz": self.crossover_hz,
        }  # fmt: skip
        return {name: value if math.isfinite(value) else None for name, value in numbers.items()}


NONE = Margins(0.0, 0.0, 0.0, 0.0)


def current_margins(plant: Numbers, axis: str, kp: float, ki: float) -> Margins:
    """Of (1); all zero when the closed loop is unstable."""
    control = _python_control()

    ts_s = 1.0 / plant["pwm_hz"]
    resistance, inductance = plant["resistance_ohm"], plant[f"l{axis}_h"]
    a = math.exp(-resistance * ts_s / inductance)
    controller = control.tf([kp, ki * ts_s - kp], [1.0, -1.0], ts_s)
    motor = control.tf([(1.0 - a) / resistance], [1.0, -a, 0.0], ts_s)
    loop = controller * motor
    closed = np.roots(np.polyadd(loop.num[0][0], loop.den[0][0]))
    if not np.abs(closed).max() < 1.0:
        return NONE
    with warnings.catch_warnings():  # it looks at the pole z = 1, too
        warnings.simplefilter("ignore")
        gain, phase, distance, _, crossover, _ = control.stability_margins(loop)
    return _margins(gain, phase, distance, crossover)


def speed_loop(plant: Numbers, drive: Numbers, speed_rad_s: float) -> Sampled:
    return sampled_loop(plant, drive, speed_rad_s)


def speed_margins(loop: Sampled) -> Margins:
    """All zero when the closed loop is unstable."""
    control = _python_control()

    if not np.isfinite(loop.a).all() or not loop.radius < 1.0:
        return NONE
    f_hz = np.geomspace(1e-4, 0.4995, POINTS) / loop.ts_s
    closed = loop.closed(f_hz)
    opened = closed / (1.0 - closed)
    gain, phase, distance, _, crossover, _ = control.stability_margins(
        (np.abs(opened), np.degrees(np.unwrap(np.angle(opened))), 2.0 * np.pi * f_hz)
    )
    distance = min(float(distance), float(np.abs(1.0 + opened).min()))
    return _margins(gain, phase, distance, crossover)


def _python_control() -> Any:
    """By its name at run time: for a type checker `control` is the folder of this repository."""
    return importlib.import_module("control")


def _margins(gain: float, phase: float, distance: float, crossover: float) -> Margins:
    if not math.isfinite(crossover):  # it never reaches 1: any delay is borne
        return Margins(180.0, float(gain), float(distance), 0.0)
    return Margins(float(phase), float(gain), float(distance), float(crossover) / (2.0 * math.pi))
