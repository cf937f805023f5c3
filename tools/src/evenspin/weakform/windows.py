"""Modulating functions: an equation times a bump of compact support, integrated, with the derivatives on the bump.

    sum of phi f'  = -sum of phi' f          sum of phi f'' = sum of phi'' f

No signal is differentiated, and both sides of an equation are smoothed alike. The weights are corrected so that they
are exact for a signal that is quadratic within the window.

Source   Preisig, Rippin 1993, modulating-function method for parameter estimation (Comp. Chem. Eng. 17).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

POWER = 4  # (1 - u^2)^4: three derivatives vanish at the ends
LEAST_ROWS = 4  # on each side of the centre
OVERLAP = 0.5
FREQUENCIES = 400  # up to half the sampling rate, of the table by which `Bump.transform` interpolates


@dataclass(frozen=True, slots=True)
class Bump:
    """Weights of the rows of a window: of the signal, and of its first and second derivative. The first sums to 1."""

    half: int
    period_s: float
    value: Array
    slope: Array  # of f, so that the sum is that of phi f'
    curve: Array  # of f, so that the sum is that of phi f''
    passed: Array  # what of a line passes, at evenly spaced frequencies

    @property
    def rows(self) -> int:
        return 2 * self.half + 1

    @classmethod
    def of(cls, half_s: float, period_s: float) -> Bump:
        half = max(LEAST_ROWS, round(half_s / period_s))
        u = np.arange(-half, half + 1) / (half + 1.0)
        t = np.arange(-half, half + 1) * period_s
        scale = 1.0 / ((half + 1.0) * period_s)
        value = (1.0 - u**2) ** POWER
        slope = 2.0 * POWER * u * (1.0 - u**2) ** (POWER - 1) * scale
        curve = -2.0 * POWER * (1.0 - u**2) ** (POWER - 2) * (1.0 - (2 * POWER - 1) * u**2) * scale**2
        total = float(np.sum(value))
        value, slope, curve = value / total, slope / total, curve / total
        slope = slope / float(np.sum(slope * t))
        curve = curve - np.mean(curve)
        curve = curve * (2.0 / float(np.sum(curve * t * t)))
        passed = np.cos(np.outer(_frequencies(period_s), t)) @ value
        return cls(half, period_s, value, slope, curve, passed)

    def transform(self, rad_s: Array) -> Array:
        """What of a line of this angular frequency passes."""
        return np.asarray(np.interp(np.abs(rad_s), _frequencies(self.period_s), self.passed))


def _frequencies(period_s: float) -> Array:
    return np.linspace(0.0, np.pi / period_s, FREQUENCIES)


@dataclass(frozen=True, slots=True)
class Windows:
    """The windows of a record that lie side by side with half overlap; `used` picks those that are judged."""

    bump: Bump
    centre: NDArray[np.int64]
    used: Flags

    @classmethod
    def over(cls, rows: int, bump: Bump, step: int | None = None) -> Windows:
        step = max(1, round(2.0 * (1.0 - OVERLAP) * bump.half)) if step is None else step
        centre = np.arange(bump.half, rows - bump.half, step)
        return cls(bump, centre, np.ones(len(centre), dtype=bool))

    def where(self, good: Flags) -> Windows:
        return Windows(self.bump, self.centre, self.used & good)

    def all_of(self, flags: Flags) -> Flags:
        """Windows in which every row has the flag."""
        bad = np.concatenate(([0], np.cumsum(~flags)))
        return np.asarray(bad[self.centre + self.bump.half + 1] == bad[self.centre - self.bump.half])

    def share_of(self, flags: Flags) -> Array:
        count = np.concatenate(([0], np.cumsum(flags)))
        return (count[self.centre + self.bump.half + 1] - count[self.centre - self.bump.half]) / self.bump.rows

    def at_rows(self, flags: Flags) -> Flags:
        """Of the windows in use, those whose centre has the flag."""
        return np.asarray(flags[self.centre[self.used]])

    def at_centre(self, signal: Array) -> Array:
        return np.asarray(signal[self.centre[self.used]])

    def value(self, signal: Array) -> Array:
        return self._sums(signal, self.bump.value)

    def slope(self, signal: Array) -> Array:
        return self._sums(signal, self.bump.slope)

    def curve(self, signal: Array) -> Array:
        return self._sums(signal, self.bump.curve)

    def _sums(self, signal: Array, weights: Array) -> Array:
        if len(self.centre) == 0:
            return np.empty(0)
        step = int(self.centre[1] - self.centre[0]) if len(self.centre) > 1 else 1
        # a view as of sliding_window_view, made for each of thousands of columns
        signal = np.ascontiguousarray(signal)
        size = signal.itemsize
        views = np.ndarray((len(self.centre), self.bump.rows), signal.dtype, signal, strides=(step * size, size))
        return np.asarray((views @ weights)[self.used])
