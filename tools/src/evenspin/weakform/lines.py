"""Lines in what is left of the torque: over the angle, and over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.empirical.lines import frequency_spectrum, order_spectra, peaks
from evenspin.weakform.windows import Windows

Array = NDArray[np.float64]

STANDS_OUT = 40.0  # chi-square of a line that becomes a candidate
NEAR = 0.04  # of an order: as near to a known one it is that one, smeared
LEAST_ORDER = 0.3
LEAST_TURNS = 3.0
TOP_HZ = 80.0
LEAST_HZ = 0.3
MOST = 2


def foreign_orders(
    left: Array, theta: Array, speed: Array, windows: Windows, known: Sequence[float]
) -> list[tuple[float, float]]:
    """Orders that stand out and are none of the known ones, with their chi-square, strongest first."""
    turns = float(np.ptp(theta)) / (2.0 * np.pi)
    if turns < LEAST_TURNS:
        return []
    orders, (gain,) = order_spectra(left, theta, speed, windows.bump.transform, (0.0,))
    reach = max(NEAR, 2.0 / turns)
    for order in known:
        gain[np.abs(orders - order) < reach] = 0.0
    gain[orders < LEAST_ORDER] = 0.0
    return peaks(orders, gain, 3.0 * reach, MOST, STANDS_OUT)


def foreign_frequencies(left: Array, t_s: Array, windows: Windows) -> list[tuple[float, float]]:
    """Frequencies that stand out, whatever the speed, with their chi-square, strongest first."""
    span_s = float(np.ptp(t_s))
    top_hz = min(TOP_HZ, 1.0 / (windows.bump.half * windows.bump.period_s))
    hz, gain = frequency_spectrum(left, t_s, windows.bump.transform, np.ones(len(left)))
    gain = np.where((hz >= LEAST_HZ) & (hz <= top_hz), gain, 0.0)
    return peaks(hz, gain, 6.0 / span_s, MOST, STANDS_OUT)
