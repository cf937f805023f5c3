"""What angle, speed and time say about each other's units: the change of an angle is the integral of the speed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.importer.units import TURN

Array = NDArray[np.float64]

WINDOWS = 400  # of which the ratio is taken
AGREE = 0.02  # a ratio is 1, or a whole number, within this share...
APART = 0.1  # ...and this much, so that a high number is not met by chance
MOST_POLE_PAIRS = 30  # of a motor whose pole pairs are taken from a ratio
CLEAR = 0.98  # correlation of both sides below which angle and speed do not belong together
# Of encoders that are sold; four counts a line.
LINES = (
    50, 60, 90, 100, 120, 125, 128, 180, 200, 250, 300, 360, 400, 500, 600, 720, 900, 1000, 1200, 1250, 1500, 1800,
    2000, 2500, 3000, 3600, 4000, 4500, 5000, 6000, 7200, 9000, 10000, 18000, 36000,
)  # fmt: skip
RATES_HZ = (20.0, 200_000.0)
FAR = 0.4  # of a turn from row to row: from there on the rows of an angle alone do not tell how often it went round
FORETOLD = 0.9  # of 1: how clearly the steps of an angle are those that the speed foretells...
CLOSER = 0.2  # of what any other number of pole pairs is short of 1: so much closer is the right one


@dataclass(frozen=True, slots=True)
class Reading:
    """A way to read three columns: a unit for each, and the number of electrical turns per mechanical one."""

    time_unit: str
    angle_unit: str
    speed_unit: str
    ratio: float  # angle over integral of the speed, both in SI
    pole_pairs: int  # 1: the angle is mechanical
    reversed: bool


def wrap_span(values: Array) -> float | None:
    """The number of units after which an angle starts again, or None when it never does."""
    good = values[np.isfinite(values)]
    span = float(np.ptp(good)) if len(good) else 0.0
    if span <= 0.0:
        return None
    step = np.diff(good)
    jumps = np.abs(step) > 0.6 * span
    if np.count_nonzero(jumps) < 1 or np.count_nonzero(jumps) > 0.45 * len(step):
        return None
    inside = float(np.median(np.abs(step[~jumps]))) if np.any(~jumps) else 0.0
    return span if inside < 0.25 * span else None


def is_whole(values: Array) -> bool:
    """Counts are whole numbers."""
    good = values[np.isfinite(values)]
    return bool(np.all(np.abs(good - np.round(good)) < 1e-6))


def wrap_period(values: Array, span: float) -> float:
    """After how much an angle starts again, whatever its unit: a jump less the step that was due."""
    step = np.diff(values)
    jumps = np.flatnonzero(np.abs(step) > 0.6 * span)
    jumps = jumps[jumps > 0]
    return float(np.median(np.abs(step[jumps] - step[jumps - 1]))) if len(jumps) else span


def turn_of(span: float, whole: bool = True) -> tuple[str, float] | None:
    """The unit of an angle that starts again after about @p span, and that turn in the unit. @p whole: is_whole."""
    for unit, turn in (("rad", TURN), ("deg", 360.0), ("turn", 1.0)):
        if 0.93 * turn <= span <= 1.001 * turn:
            return unit, turn
    if span >= 15.0 and whole:
        nice = [float(2**bits) for bits in range(4, 33)] + [4.0 * lines for lines in LINES]
        near = [turn for turn in nice if 0.97 * turn <= span + 1.0 <= 1.001 * turn]
        return "counts", min(near, key=lambda turn: turn - span) if near else 4.0 * math.ceil((span + 1.0) / 4.0)
    return None


def unwrapped(values: Array, turn: float | None) -> Array:
    """A continuous angle; @p turn: after which it starts again."""
    if turn is None:
        return values
    step = np.diff(values)
    step = step - turn * np.round(step / turn)
    return values[0] + np.concatenate(([0.0], np.cumsum(np.nan_to_num(step))))


def foretold(t: Array, speed: Array) -> Array:
    """How far the angle goes from row to row, by the speed."""
    return np.asarray(np.nan_to_num(0.5 * (speed[1:] + speed[:-1]) * np.diff(t)))


def likeness(values: Array, turn: float, steps: Array) -> float:
    """1 where an angle that starts again after @p turn makes these steps from row to row, 0 where it makes others.

    Of the faster half of the rows: all angles stand still alike.
    """
    beside = np.diff(values) - steps
    rows = np.isfinite(beside) & (np.abs(steps) >= np.median(np.abs(steps)))
    return float(np.abs(np.mean(np.exp(2j * np.pi * beside[rows] / turn)))) if rows.any() else 0.0


def unwrapped_along(values: Array, turn: float, steps: Array) -> Array:
    """A continuous angle whose rows may be more than half a turn apart. @p steps: about those from row to row."""
    beside = np.nan_to_num(np.diff(values) - steps)
    return values[0] + np.concatenate(([0.0], np.cumsum(steps + beside - turn * np.round(beside / turn))))


def ratio_foretold(values: Array, turn: float, steps: Array, pole_pairs: int | None) -> int | None:
    """How many times as fast as the speed an angle turns of which rows are far apart; negative: the other way round."""
    if not np.max(np.abs(steps), initial=0.0) * (pole_pairs or MOST_POLE_PAIRS) > FAR * turn:
        return None
    pairs = (1, pole_pairs) if pole_pairs is not None else range(1, MOST_POLE_PAIRS + 1)
    tried = sorted(((likeness(values, turn, s * p * steps), s * p) for p in set(pairs) for s in (1, -1)), reverse=True)
    return tried[0][1] if tried[0][0] > FORETOLD and 1.0 - tried[0][0] < CLOSER * (1.0 - tried[1][0]) else None


def window_pairs(t: Array, angle: Array, speed: Array) -> tuple[Array, Array]:
    """Change of the angle and integral of the speed over each of many windows."""
    area = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(t))))
    edges = np.unique(np.linspace(0, len(t) - 1, min(WINDOWS, max(2, len(t) // 8))).astype(int))
    return np.diff(angle[edges]), np.diff(area[edges])


def ratio_of(t: Array, angle: Array, speed: Array) -> tuple[float, float]:
    """Least-squares ratio of the two, and their correlation about zero."""
    turned, integral = window_pairs(t, angle, speed)
    xx, yy, xy = float(integral @ integral), float(turned @ turned), float(turned @ integral)
    if xx <= 0.0 or yy <= 0.0:
        return math.nan, 0.0
    return xy / xx, xy / math.sqrt(xx * yy)


def readings(
    ratio: float,
    units: Iterable[tuple[tuple[str, float], tuple[str, float], tuple[str, float]]],
    pole_pairs: int | None,
    electrical: bool,
) -> list[Reading]:
    """Which units make a ratio that a machine can have. @p ratio: of bare numbers. @p electrical: the name says so."""
    found = []
    for (time_name, time_si), (angle_name, angle_si), (speed_name, speed_si) in units:
        value = ratio * angle_si / (speed_si * time_si)
        size = abs(value)
        pairs = round(size)
        if not 1 <= pairs <= MOST_POLE_PAIRS or abs(size - pairs) > min(AGREE * pairs, APART):
            continue
        if pole_pairs is not None and pairs not in (1, pole_pairs):
            continue
        if electrical and pole_pairs is not None and pairs != pole_pairs:
            continue
        found.append(Reading(time_name, angle_name, speed_name, value, pairs, value < 0.0))
    return found


def time_units(step: float) -> list[tuple[str, float]]:
    """Units in which rows at this distance come at a rate that logs have."""
    known = (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9))
    return [(name, si) for name, si in known if step > 0.0 and RATES_HZ[0] <= 1.0 / (step * si) <= RATES_HZ[1]]


def combinations(
    times: Sequence[tuple[str, float]], angles: Sequence[tuple[str, float]], speeds: Sequence[tuple[str, float]]
) -> list[tuple[tuple[str, float], tuple[str, float], tuple[str, float]]]:
    return list(itertools.product(times, angles, speeds))
