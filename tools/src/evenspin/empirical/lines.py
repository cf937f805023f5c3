"""Orders over the angle and frequencies over time in what is left: where a line stands out.

What is left of every window goes into bins of the angle (or of the time), one row of bins for each class of speed, and
the Fourier transform gives every order at the resolution that the log has; a class passes
a line by the bump at its speed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len, rfft

Array = NDArray[np.float64]
Passes = Callable[[Array], Array]  # share of a line of an angular frequency that a window shows

CLASSES = 6
BINS_PER_TURN = 512
MOST_BINS = 2**20
PADDED = 2.5  # times the resolution
LEAST_POWER = 0.02  # of the windows that a line shows in
CLIPPED = 4.0
TOP_ORDER = 120.0
LEAST_TURNS = 1.5  # of a line over the log


def order_spectra(
    left: Array, theta: Array, speed: Array, passes: Passes, powers: Sequence[float]
) -> tuple[Array, list[Array]]:
    """Orders, and for each power the chi-square of a line whose amplitude grows with that power of the speed."""
    span = float(np.ptp(theta)) if len(theta) else 0.0
    turns = span / (2.0 * np.pi)
    if turns < LEAST_TURNS or len(left) < 50:
        return np.empty(0), [np.empty(0) for _ in powers]
    per_turn = min(BINS_PER_TURN, max(64, int(MOST_BINS / (PADDED * turns))))
    edge = 2.0 * np.pi / per_turn
    where = np.minimum(((theta - theta.min()) / edge).astype(np.int64), int(span / edge))
    length = next_fast_len(int(PADDED * (span / edge + 1.0)), real=True)
    rates = np.arange(length // 2) * (per_turn / length)
    keep = (rates >= LEAST_TURNS / turns) & (rates <= min(TOP_ORDER, 0.25 * per_turn))
    size = np.abs(speed)
    top = max(float(np.max(size)), 1e-12)
    edges = np.unique(np.quantile(size, np.linspace(0.0, 1.0, CLASSES + 1)))
    number = np.clip(np.searchsorted(edges, size, side="right") - 1, 0, max(len(edges) - 2, 0))
    lines = [_Line(rates[keep]) for _ in powers]
    limited = _limited(left)
    for k in np.unique(number):
        own = number == k
        middle = float(np.median(size[own]))
        found = rfft(np.bincount(where[own], weights=limited[own], minlength=length), length)[: length // 2][keep]
        share = passes(rates[keep] * middle)
        for line, power in zip(lines, powers, strict=True):
            line.add(found, (middle / top) ** power * share, int(np.count_nonzero(own)))
    return rates[keep], [line.chi_square() for line in lines]


def frequency_spectrum(left: Array, t_s: Array, passes: Passes, size: Array) -> tuple[Array, Array]:
    """Frequencies, and the chi-square of a line at each, up to half the rate of the windows. `size`: amplitude of a
    unit line in each window."""
    span = float(np.ptp(t_s)) if len(t_s) else 0.0
    step = float(np.median(np.diff(t_s))) if len(t_s) > 2 else 0.0
    if not span > 0.0 or not step > 0.0 or len(left) < 50:
        return np.empty(0), np.empty(0)
    where = np.round((t_s - t_s[0]) / step).astype(np.int64)
    length = next_fast_len(int(PADDED * (where[-1] + 1.0)), real=True)
    hz = np.arange(length // 2) / (length * step)
    keep = (hz >= 4.0 / span) & (hz <= 0.48 / step)
    scale = max(float(np.max(np.abs(size))), 1e-300)
    line = _Line(hz[keep])
    found = rfft(np.bincount(where, weights=_limited(left) * size / scale, minlength=length), length)
    line.add(found[: length // 2][keep], passes(2.0 * np.pi * hz[keep]), float(np.sum((size / scale) ** 2)))
    return hz[keep], line.chi_square()


class _Line:
    """Sums over classes: of what is left against a unit line, and of its power."""

    def __init__(self, rates: Array) -> None:
        self.sum = np.zeros(len(rates), dtype=np.complex128)
        self.power = np.zeros(len(rates))
        self.most = 0.0

    def add(self, found: NDArray[np.complex128], size: Array, count: float) -> None:
        self.sum += size * found
        self.power += size * size * count
        self.most = max(self.most, float(np.max(self.power, initial=0.0)))

    def chi_square(self) -> Array:
        few = self.power < LEAST_POWER * self.most
        return np.where(few, 0.0, 2.0 * np.abs(self.sum) ** 2 / np.maximum(self.power, 1e-300))


def _limited(left: Array) -> Array:
    sigma = max(1.4826 * float(np.median(np.abs(left))), 1e-300)
    return np.asarray(np.clip(left / sigma, -CLIPPED, CLIPPED))


def peaks(at: Array, gain: Array, reach: float, most: int, least: float) -> list[tuple[float, float]]:
    """The strongest, none within `reach` of a stronger one."""
    found: list[tuple[float, float]] = []
    gain = gain.copy()
    while len(found) < most and len(gain):
        k = int(np.argmax(gain))
        if gain[k] < least:
            break
        found.append((float(at[k]), float(gain[k])))
        gain[np.abs(at - at[k]) < reach] = 0.0
    return found
