"""One smoothing filter for everything that enters a balance.

Every column of a regression passes the same zero-phase Gaussian, and a derivative is the derivative of that very
Gaussian. What the filter takes away is then missing on both sides of the equation, and amplitudes stay right.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.hermite_e import hermeval
from numpy.typing import NDArray
from scipy.signal import fftconvolve, upfirdn

Array = NDArray[np.float64]

WIDTH_SIGMAS = 5.5  # where the fourth derivative has died out as well


@dataclass(frozen=True, slots=True)
class Smoother:
    """Gaussian of this width, and its derivatives."""

    sigma_s: float
    period_s: float

    @property
    def half(self) -> int:
        """Samples to each side."""
        return max(2, int(np.ceil(WIDTH_SIGMAS * self.sigma_s / self.period_s)))

    def __call__(self, x: Array) -> Array:
        return fftconvolve(x, self._kernel(0), mode="same")

    def every(self, x: NDArray[Any], stride: int) -> NDArray[Any]:
        """Smoothed, each `stride`-th sample only: the same numbers for less work."""
        if np.iscomplexobj(x):  # in complex arithmetic each product would cost four
            return self.every(x.real, stride) + 1j * self.every(x.imag, stride)
        front = -self.half % stride
        padded = np.concatenate((np.zeros(front, dtype=x.dtype), x, np.zeros(self.half, dtype=x.dtype)))
        start = (self.half + front) // stride
        return upfirdn(self._kernel(0), padded, down=stride)[start : start - (-len(x) // stride)]

    def rate(self, x: Array, order: int = 1) -> Array:
        """Derivative with regard to time, per second^order."""
        return fftconvolve(x, self._kernel(order), mode="same") / self.period_s**order

    def gain(self, order: int = 0) -> float:
        """Rms of what comes out, for white noise of rms 1 that goes in."""
        return float(np.sqrt(np.sum(self._kernel(order) ** 2))) / self.period_s**order

    def _kernel(self, order: int) -> Array:
        """Derivative of the Gaussian, normed so that t^order has its right derivative whatever the sampling does."""
        k = np.arange(-self.half, self.half + 1)
        x = k / (self.sigma_s / self.period_s)
        bell = np.exp(-0.5 * x**2)
        g = bell * hermeval(x, [0.0] * order + [1.0])
        if order:  # sampled, it would see a little of a constant: of an angle of many turns, an acceleration
            g -= bell * (np.sum(g) / np.sum(bell))
        # np.convolve turns the kernel round, which is the sign (-1)^order of the derivative of a Gaussian
        return g * math.factorial(order) / np.sum(g * (-k) ** order) if order else g / g.sum()
