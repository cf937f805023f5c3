"""Time, angle and speed of one shaft: the integral of the speed is the travel of the angle, unless a unit is wrong.

Travel and integral are taken over the same stretches of the log. Where they are proportional, the factor shows the
unit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from evenspin.plausible.finding import Array, Finding, rms, share

TURN = 2.0 * math.pi
BLOCKS = 400
LEAST_ROWS = 50
LEAST_RAD = 0.5  # a shorter travel does not determine a unit
BAND = 0.07  # of the factor between travel and integral: the same unit
MATCH = 0.02  # of a factor to that of a known unit
LINEAR = 0.2  # share of one that the other, times a factor, may leave unexplained
LOOSE = 0.05  # share of the travel that a tracking filter leaves unexplained at most, about
STILL = 0.02  # of the other one: a channel that does not move
UNRELATED = 0.9  # share that is left unexplained where the two have nothing to do with each other
WRAP = 0.9  # of the range of an angle: a step back by so much is that of a whole turn
ALIASED = 0.35  # of a turn between two rows: whole turns are not counted for sure
GAP = 3.0  # times the median step in time

Unit = tuple[float, str, str]  # factor, column, what it looks like


@dataclass(frozen=True, slots=True)
class Travels:
    """The travel of the angle and the integral of the speed, stretch by stretch."""

    angle: Array
    speed: Array

    @property
    def factor(self) -> float:
        square = float(self.angle @ self.angle)
        return float(self.speed @ self.angle) / square if square > 0.0 else 0.0

    @property
    def left(self) -> float:
        return share(self.speed - self.factor * self.angle, self.speed)


def check_motion(t_s: Array, theta: Array, speed: Array, pole_pairs: int = 0, counts: float = 0.0) -> Finding | None:
    """What contradicts. None where the travel is too short, or the two are too loosely related to decide."""
    if len(t_s) < LEAST_ROWS or _is_aliased(t_s, theta, speed):
        return None
    travels = _travels(t_s, theta, speed, TURN)
    if abs(travels.factor - 1.0) < BAND or max(_length(travels.angle), _length(travels.speed)) < LEAST_RAD:
        return None
    periods = {"rad": (TURN, 1.0), "degrees": (360.0, TURN / 360.0), "turns": (1.0, TURN)}
    if counts > 1.0:
        periods["counts"] = (counts, TURN / counts)
    tried = {unit: _travels(t_s, theta, speed, period) for unit, (period, _) in periods.items()}
    unit = min(tried, key=lambda name: (round(tried[name].left, 3), name != "rad"))
    best = tried[unit]
    if best.left < LINEAR:
        plain = np.array_equal(best.angle, _travels(t_s, theta, speed, 0.0).angle)
        return _of_factor(best.factor, "rad" if plain else unit, periods, pole_pairs, t_s)
    swapped = _travels(t_s, speed, theta, TURN)
    if swapped.left < LINEAR and abs(swapped.factor - 1.0) < BAND:
        return Finding(
            "theta_m_rad",
            "the rate of speed_rad_s",
            "the rotor angle",
            "theta_m_rad and speed_rad_s look swapped: exchange the two names in the header",
        )
    return _dead(travels) or (_unrelated(travels) if travels.left > UNRELATED else None)


def check_wrap(theta: Array) -> Finding | None:
    """An angle alone shows its unit only where it jumps back by a whole turn."""
    steps, size = np.diff(theta), float(np.ptp(theta))
    jumps = np.abs(steps) > WRAP * size
    if not np.any(jumps) or np.mean(jumps) > 0.2 or np.mean(np.abs(steps[~jumps]) > 0.5 * size) > 0.005:
        return None
    for period, unit in ((360.0, "degrees"), (1.0, "turns")):
        if abs(size / period - 1.0) < MATCH:
            data = f"jumps back by {period:g} at every turn"
            return Finding("theta_m_rad", data, "in rad", f"it looks like {unit}: convert it to mechanical rad")
    if abs(size / TURN - 1.0) < BAND:
        return None
    return Finding(
        "theta_m_rad", f"jumps back by {size:.4g}", "in rad", "it looks like another unit: convert it to rad"
    )


def exchanged_speed(t_s: Array, theta: Array, speed: Array, others: Mapping[str, Array]) -> Finding | None:
    """Another column that is the rate of the angle, where speed_rad_s is not or much less so."""
    own = _travels(t_s, theta, speed, TURN)
    if _length(own.angle) < LEAST_RAD or _is_aliased(t_s, theta, speed):
        return None
    tried = {name: _travels(t_s, theta, column, TURN) for name, column in others.items()}
    likely = {name: travels.left for name, travels in tried.items() if abs(travels.factor - 1.0) < BAND}
    name = min(likely, key=lambda key: likely[key], default="")
    if own.left < LOOSE or not name or likely[name] > min(LINEAR, 0.5 * own.left):
        return None
    data = f"the rate of theta_m_rad is {name} ({100.0 * likely[name]:.0f} % left, {100.0 * own.left:.0f} % here)"
    return Finding("speed_rad_s", data, "the rate of the angle", f"exchange the names speed_rad_s and {name}")


def _of_factor(
    factor: float, angle_unit: str, periods: dict[str, tuple[float, float]], pole_pairs: int, t_s: Array
) -> Finding | None:
    """The unit, or the two units, that make this factor."""
    scale = periods[angle_unit][1]
    other = factor / scale
    if angle_unit != "rad" and abs(abs(other) - 1.0) < BAND:
        return _unit_finding([(scale, "theta_m_rad", angle_unit)], factor)
    units = list(_units(pole_pairs, periods))
    if angle_unit != "rad":
        found = [unit for unit in units if _fits(other, unit[0]) and unit[1] != "theta_m_rad"]
        return _unit_finding([(scale, "theta_m_rad", angle_unit), *found[:1]], factor)
    alone = [[unit] for unit in units if _fits(factor, unit[0])]
    pairs = [
        [one, other]
        for i, one in enumerate(units)
        for other in units[i + 1 :]
        if one[1] != other[1] and _fits(factor, one[0] * other[0])
    ]
    return _unit_finding((alone or pairs or [[]])[0], factor)


def _units(pole_pairs: int, periods: dict[str, tuple[float, float]]) -> Iterator[Unit]:
    """Units that columns are given in by mistake, the most frequent first."""
    yield 1.0, "speed_rad_s", ""
    yield 60.0 / TURN, "speed_rad_s", "r/min"
    yield 360.0 / TURN, "speed_rad_s", "degrees per second"
    yield 1.0 / TURN, "speed_rad_s", "turns per second"
    for name, (_, scale) in periods.items():
        if name != "rad":
            yield scale, "theta_m_rad", name
    yield 1e3, "t_s", "milliseconds"
    yield 1e6, "t_s", "microseconds"
    yield 1.0 / 60.0, "t_s", "minutes"
    for p in [pole_pairs] if pole_pairs > 0 else range(2, 31):
        if p > 1:
            name = f"electrical rad (of {p} pole pairs)"
            yield 1.0 / p, "theta_m_rad", name
            yield float(p), "speed_rad_s", name + " per second"


def _fits(factor: float, unit: float) -> bool:
    return abs(abs(factor) / unit - 1.0) < MATCH


def _unit_finding(units: list[Unit], factor: float) -> Finding:
    named = [(column, unit) for _, column, unit in units if unit]
    ratio = f"{factor:.4g} times d(theta_m_rad)/dt"
    if factor < 0.0 and not named:
        hint = "one of the two has the opposite sign: turn its sign"
    elif not named:
        hint = "one of t_s, theta_m_rad, speed_rad_s is in another unit: convert it"
    else:
        sign = " and the signs of angle and speed differ" if factor < 0.0 else ""
        hint = "it looks like " + " and ".join(f"{column} in {unit}" for column, unit in named) + sign
        hint += ": convert to " + " and ".join(dict.fromkeys(_si(column) for column, _ in named))
    return Finding("speed_rad_s", ratio, "the rate of the angle", hint)


def _si(column: str) -> str:
    return {"t_s": "seconds", "theta_m_rad": "mechanical rad"}.get(column, "mechanical rad/s")


def _dead(travels: Travels) -> Finding | None:
    angle, speed = _length(travels.angle), _length(travels.speed)
    if angle < STILL * speed:
        data = f"moved by {angle:.3g} rad where speed_rad_s says {speed:.3g} rad"
        return Finding("theta_m_rad", data, "the angle of a shaft that turns", "the angle channel is dead: repair it")
    if speed < STILL * angle:
        data = f"adds up to {speed:.3g} rad where theta_m_rad moved by {angle:.3g} rad"
        return Finding("speed_rad_s", data, "the speed of that shaft", "the speed channel is dead: repair it")
    return None


def _unrelated(travels: Travels) -> Finding:
    data = f"{100.0 * min(travels.left, 1.0):.0f} % of its integral is not in theta_m_rad"
    hint = "are both columns of the same shaft and in SI units?"
    return Finding("speed_rad_s", data, "the rate of theta_m_rad", hint)


def _length(travel: Array) -> float:
    return float(np.sum(np.abs(travel)))


def _travels(t_s: Array, theta: Array, speed: Array, period: float) -> Travels:
    step_s = np.diff(t_s)
    angle = np.concatenate(([0.0], np.cumsum(_steps(theta, period))))
    integral = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * step_s)))
    edges = np.unique(np.linspace(0, len(t_s) - 1, min(BLOCKS, len(t_s) // 8) + 1).astype(int))
    a, s = np.diff(angle[edges]), np.diff(integral[edges])
    gaps = np.concatenate(([0], np.cumsum(step_s > GAP * float(np.median(step_s)))))
    whole = np.diff(gaps[edges]) == 0
    return Travels(a[whole], s[whole]) if np.any(whole) else Travels(a, s)


def _steps(theta: Array, period: float) -> Array:
    """Of an angle that may be wrapped to this period."""
    steps = np.diff(theta)
    if period <= 0.0 or np.ptp(theta) > period * 1.001 or np.max(np.abs(steps)) <= 0.5 * period:
        return steps
    return steps - period * np.round(steps / period)


def _is_aliased(t_s: Array, theta: Array, speed: Array) -> bool:
    """Too fast, or logged too slowly, to count turns of a wrapped angle; the speed agrees where it can be checked."""
    raw = np.diff(theta)
    if np.array_equal(_steps(theta, TURN), raw):
        return False
    fast = np.abs(_steps(theta, TURN)) > ALIASED * TURN
    expected = 0.5 * (speed[1:] + speed[:-1]) * np.diff(t_s)
    off = (raw - expected + math.pi) % TURN - math.pi
    return bool(np.mean(fast) > 0.05) and rms(off) < 0.8
