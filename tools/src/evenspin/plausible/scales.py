"""Scales against a model: which one wrong unit would explain several numbers of the machine at once?

The log gives flux, resistance, reactance and inertia, each as its columns have it. A fault of the machine changes one
of them; a wrong unit of a column changes all that contain the column, by powers of one known factor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from evenspin.plausible.finding import Finding

TURN = 2.0 * math.pi
SIGMA = {"flux": 0.03, "resistance": 0.12, "reactance": 0.12, "inertia": 0.06}  # of a logarithm, on a bench
FAULT = 6.0  # cost of a number that the machine itself has otherwise...
FAR, TOO_FAR = math.log(20.0), 20.0  # ...within this factor, and beyond it
UNIT = 5.0  # cost of a wrong unit
CLEAR = 3.0  # cost by which it has to be better
ALONE = 0.07  # of a factor that only one number shows: worth a remark...
NEAR = 0.3  # ...unless machines differ by as much
# What each number takes: powers of the scales of voltage, current and speed, and of time beside a column of speed.
POWERS = {
    "flux": (1.0, 0.0, -1.0, 0.0),
    "resistance": (1.0, -1.0, 0.0, 0.0),
    "reactance": (1.0, -1.0, -1.0, 0.0),
    "inertia": (0.0, 1.0, -1.0, 1.0),
}


@dataclass(frozen=True, slots=True)
class WrongUnit:
    column: str
    what: str
    scales: tuple[float, float, float, float]  # of voltage, current, speed, and time beside a column of speed


def wrong_units(pole_pairs: int, has_angle: bool, has_speed: bool) -> Iterator[WrongUnit]:
    """The likeliest first."""
    rpm, deg = 60.0 / TURN, 360.0 / TURN
    if has_speed and not has_angle:
        for factor, what in (
            (rpm, "r/min"),
            (1.0 / rpm, "rad/s divided by 9.55, as if it had been r/min"),
            (float(pole_pairs), "electrical rad/s"),
            (1.0 / TURN, "turns per second"),
            (deg, "degrees per second"),
            (pole_pairs * rpm, "electrical r/min"),
        ):
            yield WrongUnit("speed_rad_s", what, (1.0, 1.0, factor, 1.0))
    if has_angle and not has_speed:
        for factor, what in (
            (float(pole_pairs), "the electrical angle"),
            (deg, "degrees"),
            (1.0 / TURN, "turns"),
            (1.0 / deg, "rad divided by 57.3, as if it had been degrees"),
        ):
            yield WrongUnit("theta_m_rad", what, (1.0, 1.0, factor, 1.0))
    if not (has_angle and has_speed):
        for factor, what in ((1e3, "milliseconds"), (1e-3, "seconds divided by 1000"), (1e6, "microseconds")):
            speed = 1.0 if has_speed else 1.0 / factor
            yield WrongUnit("t_s", what, (1.0, 1.0, speed, factor))
    for factor, what in (
        (1e3, "mA"),
        (1e-3, "A divided by 1000, as if it had been mA"),
        (math.sqrt(0.5), "A rms"),
        (math.sqrt(1.5), "A of the power-invariant transform"),
        (math.sqrt(2.0), "A times sqrt(2)"),
    ):
        yield WrongUnit("iq_a", what, (1.0, factor, 1.0, 1.0))
    for factor, what in (
        (1e3, "mV"),
        (1e-3, "V divided by 1000"),
        (math.sqrt(0.5), "V rms"),
        (math.sqrt(3.0), "V from line to line"),
        (math.sqrt(1.5), "V of the power-invariant transform, or rms from line to line"),
    ):
        yield WrongUnit("vq_v", what, (factor, 1.0, 1.0, 1.0))


def check_scales(
    ratios: Mapping[str, float], sigmas: Mapping[str, float], pole_pairs: int, has_angle: bool, has_speed: bool
) -> Finding | None:
    """@p ratios: what the log gives over what the model says, of POWERS; @p sigmas: what adds to SIGMA."""
    logs = {name: math.log(value) for name, value in ratios.items() if value > 0.0}
    if len(logs) < 2:
        return None
    own = _cost(logs, sigmas, (1.0, 1.0, 1.0, 1.0))
    units = list(wrong_units(pole_pairs, has_angle, has_speed))
    costs = [UNIT + _cost(logs, sigmas, unit.scales) for unit in units]
    best = int(np.argmin(costs))
    if costs[best] > own - CLEAR:
        return None
    data = "with the model, " + ", ".join(f"{name} is {ratios[name]:.3g} times" for name in logs) + " its own"
    alike = [unit for unit, cost in zip(units, costs, strict=True) if cost < costs[best] + 1.0][:2]
    seen = " or ".join(f"{unit.column} in {unit.what}" for unit in alike)
    return Finding(units[best].column, data, "in SI units, peak, mechanical", f"it looks like {seen}: convert it")


def remark_on_inertia(ratio: float, pole_pairs: int, has_angle: bool, has_speed: bool) -> str | None:
    """Where only the inertia tells: a factor that a unit makes, too."""
    if not ratio > 0.0 or abs(math.log(ratio)) < NEAR:
        return None
    for unit in wrong_units(pole_pairs, has_angle, has_speed):
        _, current, speed, time = unit.scales
        if abs(math.log(ratio * speed / (current * time))) < ALONE:
            return (
                f"the inertia is {ratio:.3g} times that of the model, which is also what {unit.column} in {unit.what} "
                "makes: check the unit"
            )
    return None


def _cost(logs: Mapping[str, float], sigmas: Mapping[str, float], scales: tuple[float, ...]) -> float:
    total = 0.0
    for name, value in logs.items():
        off = value - sum(power * math.log(scale) for power, scale in zip(POWERS[name], scales, strict=True))
        square = (off / math.hypot(SIGMA[name], sigmas.get(name, 0.0))) ** 2
        total += TOO_FAR if abs(off) > FAR else min(square, FAULT)
    return total
