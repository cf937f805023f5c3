"""The balance before and after what was found, and what noise of current and angle alone would leave of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.analysis import Analysis
from evenspin.balance.angle_orders import AngleResult
from evenspin.balance.motion import Motion, white_noise
from evenspin.balance.regression import rms
from evenspin.balance.time_grid import Flags

Array = NDArray[np.float64]

RATIO = 2.0  # of what is left to noise: a right model leaves up to this, since the noise of an angle is not white


@dataclass(frozen=True, slots=True)
class JudgedBalance:
    """The balance that the gap is reported for: that with the lines where the log has any (short smoothing)."""

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


def angle_balance_of(angle: AngleResult) -> JudgedBalance:
    return JudgedBalance("angle", angle.motion, angle.validation_rows, angle.before, angle.after)


def beyond_noise(size_a: float, noise_a: float) -> float:
    """What cannot be noise, A rms. At short smoothing the noise of an angle is many times a line that is certain,
    and a few per cent of it must not count against that line."""
    return math.sqrt(max(size_a**2 - (RATIO * noise_a) ** 2, 0.0))


def noise_of(analysis: Analysis, motion: Motion) -> float:
    """What noise of current and angle leaves of a right balance, A rms."""
    current = white_noise(analysis.grid.column("iq_a")) * motion.smooth.gain()
    inertia = analysis.inertia.value_as2 if analysis.inertia is not None else 0.0
    return math.hypot(current, inertia * motion.accel_noise)
