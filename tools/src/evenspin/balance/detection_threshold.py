"""How large a line over the angle has to be for a log to show it: the detection threshold of each order.

Noise between the orders decides, and how well the log resolves the order: what shows in a few turns only leaks into
the half orders beside it, where it is taken for noise. An order that hides itself has no threshold.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.line_search import ABOVE_NOISE, NEARBY, OrderBank, OrderSpectrum
from evenspin.balance.time_grid import Flags

Array = NDArray[np.float64]

RESOLVED = 0.5  # of its own detection limit: an order that leaks more into the half orders beside it is not resolved


@dataclass(frozen=True, slots=True)
class LineThreshold:
    """Amplitude, A, below which a log does not show a line: at the orders where that is smallest and largest."""

    up_to_order: int
    smallest_a: float
    smallest_at: int
    largest_a: float
    largest_at: int


def thresholds_of(bank: OrderBank, rows: Flags, spectrum: OrderSpectrum) -> dict[int, float]:
    """Threshold of each order that these rows resolve, A."""
    is_whole = spectrum.order % 1.0 == 0.0
    whole, half = spectrum.order[is_whole], spectrum.order[~is_whole]
    beside = np.array([[column[rows] for column in bank(k)] for k in half])
    inverse = np.linalg.inv(np.einsum("kin,kjn->kij", beside, beside) + 1e-12 * np.eye(2))
    found = {}
    for order, noise_a in zip(whole, spectrum.noise_a[is_whole], strict=True):
        near = np.abs(half - order) <= NEARBY
        line = np.array([column[rows] for column in bank(order)])
        hidden = ABOVE_NOISE * float(np.median(leakage(line, beside[near], inverse[near])))
        if hidden < RESOLVED:
            found[int(order)] = ABOVE_NOISE * float(noise_a) / (1.0 - hidden)
    return found


def leakage(line: Array, beside: Array, inverse: Array) -> Array:
    """Amplitudes that a line of amplitude 1 (sine and cosine) seems to have at the orders beside it.

    `inverse`: of the Gram matrix of each of those orders.
    """
    seen = inverse @ (beside @ line.T)
    return np.sqrt(0.5 * np.sum(seen**2, axis=(1, 2)))


def least_of(found: Sequence[Mapping[int, float]]) -> dict[int, float]:
    """The smoothing that shows an order best decides."""
    orders = sorted({order for each in found for order in each})
    return {order: min(each[order] for each in found if order in each) for order in orders}


def line_threshold(found: Mapping[int, float], least_a: float) -> LineThreshold | None:
    """`least_a`: what is smaller is not named at any order. None: the log resolves no order."""
    if not found:
        return None
    at = {order: max(threshold_a, least_a) for order, threshold_a in found.items()}
    low, high = min(at, key=lambda k: at[k]), max(at, key=lambda k: at[k])
    return LineThreshold(max(at), at[low], low, at[high], high)
