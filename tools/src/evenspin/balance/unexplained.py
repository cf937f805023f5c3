"""What is left when everything named has been taken away: its size beside that of noise, and where it is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.analysis import Analysis
from evenspin.balance.confidence import confident_lines
from evenspin.balance.formatting import amperes
from evenspin.balance.line_search import OrderBank
from evenspin.balance.regression import rms
from evenspin.balance.residuals import RATIO, JudgedBalance, angle_balance_of, beyond_noise, noise_of

Array = NDArray[np.float64]

LEAST = 0.02  # of the current, rms: less than this is no gap worth a name
BANDS = 3  # of the speed, and of time
CONCENTRATED = 1.5  # of the rms over everything, for a place to be reported
LINE = 0.4  # of the rms over everything, in one order of the angle, for it to be reported
ORDERS = 40


@dataclass(frozen=True, slots=True)
class Unexplained:
    """rms of the balance with everything found, and of noise alone; `significant`: it is more than noise."""

    rms_a: float
    noise_a: float
    beyond_a: float  # what of it cannot be noise
    significant: bool
    where: tuple[str, ...]


def judged_balance(analysis: Analysis) -> JudgedBalance | None:
    angle, friction = analysis.angle, analysis.friction
    if angle is not None and (friction is None or confident_lines(analysis)):
        return angle_balance_of(angle)
    if friction is None:
        return None
    return JudgedBalance("friction", friction.motion, friction.validation_rows, friction.before, friction.after)


def unexplained_of(analysis: Analysis) -> Unexplained | None:
    found = judged_balance(analysis)
    if found is None or not np.any(found.validation_rows):
        return None
    noise_a = noise_of(analysis, found.motion)
    size_a = found.after_a
    excess_a = math.sqrt(max(size_a**2 - noise_a**2, 0.0))
    current_a = rms(found.motion.iq_a[found.validation_rows])
    significant = size_a > RATIO * noise_a and excess_a > LEAST * current_a
    places = tuple(_places(found)) if significant else ()
    return Unexplained(size_a, noise_a, beyond_noise(size_a, noise_a), significant, places)


def _places(found: JudgedBalance) -> list[str]:
    """Speeds, times and orders of the angle where more of it is than elsewhere."""
    rows, after, motion = found.validation_rows, found.after, found.motion
    total = rms(after[rows])
    places = []
    for what, unit, x in (("speeds", "rad/s", motion.speed_rad_s), ("times", "s", motion.t_s)):
        edges = np.linspace(x[rows].min(), x[rows].max() + 1e-9, BANDS + 1)
        sizes = []
        for low, high in zip(edges[:-1], edges[1:], strict=True):
            inside = rows & (x >= low) & (x < high)
            sizes.append(rms(after[inside]) if np.count_nonzero(inside) > ORDERS else 0.0)
        at = int(np.argmax(sizes))
        if sizes[at] > CONCENTRATED * total:
            places.append(f"at {what} of {edges[at]:.3g} to {edges[at + 1]:.3g} {unit} ({amperes(sizes[at])} rms)")
    if motion.theta_rad is not None:
        bank = OrderBank(motion)
        thin = bank.rows(rows)
        y = after[:: bank.stride][thin]
        sizes = []
        amplitudes = []
        for order in range(1, ORDERS + 1):
            own = np.column_stack([column[thin] for column in bank(order)])
            amplitudes.append(np.linalg.lstsq(own, y, rcond=None)[0])
            sizes.append(rms(own @ amplitudes[-1]))
        order = int(np.argmax(sizes)) + 1
        if sizes[order - 1] > LINE * total:
            places.append(f"at order {order} of the angle ({amperes(float(np.hypot(*amplitudes[order - 1])))})")
    return places or ["spread over all speeds and times"]
