"""What is left when everything named has been taken away: its size beside that of noise, and where it is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.analysis import Analysis
from evenspin.balance.angle_orders import AngleResult, FoundLine
from evenspin.balance.detection import LineThreshold, line_threshold
from evenspin.balance.friction import SMALL
from evenspin.balance.grid import Flags
from evenspin.balance.lines import OrderBank
from evenspin.balance.motion import Motion, white_noise
from evenspin.balance.regression import rms

Array = NDArray[np.float64]

RATIO = 2.0  # of what is left to noise: a right model leaves up to this, since the noise of an angle is not white
LEAST = 0.02  # of the current, rms: less than this is no gap worth a name
BANDS = 3  # of the speed, and of time
CONCENTRATED = 1.5  # of the rms over everything, for a place to be told
LINE = 0.4  # of the rms over everything, in one order of the angle, for it to be told
ORDERS = 40
SURE = 0.5  # confidence below which nothing is named


@dataclass(frozen=True, slots=True)
class Judged:
    """The balance that the gap is told of: that with the lines where the log has any, which needs short smoothing."""

    kind: str
    motion: Motion
    validation_rows: Flags
    before: Array
    after: Array

    @property
    def before_a(self) -> float:
        return rms(self.before[self.validation_rows])

    @property
    def after_a(self) -> float:
        return rms(self.after[self.validation_rows])


@dataclass(frozen=True, slots=True)
class Left:
    """rms of the balance with everything found, and of noise alone; `significant`: it is more than noise."""

    rms_a: float
    noise_a: float
    beyond_a: float  # what of it cannot be noise
    significant: bool
    where: tuple[str, ...]


def of_angle(angle: AngleResult) -> Judged:
    return Judged("angle", angle.motion, angle.validation_rows, angle.before, angle.after)


def judged(analysis: Analysis) -> Judged | None:
    angle, friction = analysis.angle, analysis.friction
    if angle is not None and (friction is None or sure_lines(analysis)):
        return of_angle(angle)
    if friction is None:
        return None
    return Judged("friction", friction.motion, friction.validation_rows, friction.before, friction.after)


def smallest_named_a(angle: AngleResult) -> float:
    return float(np.sqrt(2.0)) * SMALL * rms(angle.motion.iq_a[angle.rows])


def threshold_of(analysis: Analysis) -> LineThreshold | None:
    """None where no order is resolved, or where J/Kt is not known and a line has no amplitude in torque."""
    if analysis.angle is None or not analysis.inertia_known:
        return None
    return line_threshold(analysis.thresholds_a, smallest_named_a(analysis.angle))


def sure_lines(analysis: Analysis) -> list[FoundLine]:
    """Lines that are large enough and sure enough to be told, whether or not the model has them."""
    angle = analysis.angle
    if angle is None:
        return []
    least_a = smallest_named_a(angle)
    found = [each for each in angle.lines if each.validated]
    first = [each for each in found if each.line.amplitude_a > least_a and sure_line(analysis, each) > SURE]
    return found if first else []


def sure_line(analysis: Analysis, each: FoundLine) -> float:
    """How sure the line is: its noise, how well parts of the log agree, its interval, and what is left beside it."""
    angle = analysis.angle
    assert angle is not None
    snr = each.line.amplitude_a / max(each.noise_a, 1e-12)
    found = of_angle(angle)
    beyond_a = beyond_noise(found.after_a, noise_of(analysis, found.motion))
    rest = beyond_a / max(each.line.amplitude_a / math.sqrt(2.0), 1e-12)
    share = each.half_a / each.line.amplitude_a
    sure = (1.0 - math.exp(-0.25 * snr)) * (1.0 - 0.5 * each.agree**2) / ((1.0 + rest**2) * (1.0 + share**2))
    return sure if analysis.inertia_known else 0.8 * sure


def beyond_noise(size_a: float, noise_a: float) -> float:
    """What cannot be noise, A rms. At short smoothing the noise of an angle is many times a line that is beyond doubt,
    and a few per cent of it must not speak against that line."""
    return math.sqrt(max(size_a**2 - (RATIO * noise_a) ** 2, 0.0))


def noise_of(analysis: Analysis, motion: Motion) -> float:
    """What noise of current and angle leaves of a right balance, A rms."""
    current = white_noise(analysis.grid.column("iq_a")) * motion.smooth.gain()
    inertia = analysis.inertia.value_as2 if analysis.inertia is not None else 0.0
    return math.hypot(current, inertia * motion.accel_noise)


def left_of(analysis: Analysis) -> Left | None:
    found = judged(analysis)
    if found is None or not np.any(found.validation_rows):
        return None
    noise_a = noise_of(analysis, found.motion)
    size_a = found.after_a
    excess_a = math.sqrt(max(size_a**2 - noise_a**2, 0.0))
    current_a = rms(found.motion.iq_a[found.validation_rows])
    significant = size_a > RATIO * noise_a and excess_a > LEAST * current_a
    places = tuple(_places(found)) if significant else ()
    return Left(size_a, noise_a, beyond_noise(size_a, noise_a), significant, places)


def _places(found: Judged) -> list[str]:
    """Speeds, times and orders of the angle where more of it is than elsewhere."""
    rows, after, motion = found.validation_rows, found.after, found.motion
    total = rms(after[rows])
    said = []
    for what, unit, x in (("speeds", "rad/s", motion.speed_rad_s), ("times", "s", motion.t_s)):
        edges = np.linspace(x[rows].min(), x[rows].max() + 1e-9, BANDS + 1)
        sizes = []
        for low, high in zip(edges[:-1], edges[1:], strict=True):
            inside = rows & (x >= low) & (x < high)
            sizes.append(rms(after[inside]) if np.count_nonzero(inside) > ORDERS else 0.0)
        at = int(np.argmax(sizes))
        if sizes[at] > CONCENTRATED * total:
            said.append(f"at {what} of {edges[at]:.3g} to {edges[at + 1]:.3g} {unit} ({milli(sizes[at])} rms)")
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
            said.append(f"at order {order} of the angle ({milli(float(np.hypot(*amplitudes[order - 1])))})")
    return said or ["spread over all speeds and times"]


def milli(value_a: float) -> str:
    """A current with its unit: 15.6 A, 228.4 mA."""
    return f"{value_a:.3g} A" if abs(value_a) >= 1.0 else f"{1e3 * value_a:.1f} mA"
