"""Ripple by orders: multiples of the electrical angle, measured against the true angle of the rotor.

In the angle domain a ripple tied to the rotor is one line, however the speed wanders.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FITTED_ORDERS = 12  # lines that are fitted together, so that none leaks into another
MOST_ORDER = 400.0  # that are searched, over whichever angle
LEAST_SHARE = 0.05  # of the largest line: below, it is not worth a name
TAU = 2.0 * np.pi

Array = NDArray[np.float64]


def order_amplitudes(value: Array, theta_e_rad: Array, orders: Sequence[int] = (1, 2)) -> Array:
    """Amplitude of each order, in the unit of `value`.

    Least squares of a constant and cos/sin of every order up to FITTED_ORDERS, so the window need not be a whole
    number of turns.

    Args:
        value: samples, evenly spaced in time.
        theta_e_rad: electrical angle of each, unwrapped or not; less than half a turn between two samples.
        orders: multiples of the electrical angle, from 1.
    """
    theta = np.unwrap(theta_e_rad)
    highest = max(FITTED_ORDERS, *orders)
    per_turn = len(theta) / max(abs(theta[-1] - theta[0]) / TAU, 1e-12)
    if abs(theta[-1] - theta[0]) < TAU:
        return np.full(len(orders), np.nan)  # less than a turn: nothing to measure
    highest = max(max(orders), min(highest, int(per_turn / 2.5)))
    phases = np.outer(theta, np.arange(1, highest + 1))
    columns = np.hstack((np.ones((len(theta), 1)), np.cos(phases), np.sin(phases)))
    # The normal equations are small, and good enough: the columns are close to orthogonal.
    found = np.linalg.lstsq(columns.T @ columns, columns.T @ value, rcond=None)[0]
    cosine, sine = found[1 : highest + 1], found[highest + 1 :]
    return np.hypot(cosine, sine)[np.asarray(orders) - 1]


def order_spectrum(value: Array, theta_e_rad: Array, max_order: float = 12.0) -> tuple[Array, Array]:
    """(order, amplitude): spectrum over the electrical angle, from whole turns, with a Hann window.

    The resolution is two lines of 1 / turns. The mean is removed.
    """
    part = whole_turns(theta_e_rad)
    theta, samples = np.unwrap(theta_e_rad)[part], value[part]
    turns = round(abs(theta[-1] - theta[0]) / TAU) if len(theta) > 1 else 0
    if turns < 1:
        return np.empty(0), np.empty(0)
    if theta[-1] < theta[0]:
        theta, samples = -theta, samples
    per_turn = max(8, int(2 ** np.ceil(np.log2(2.5 * max_order))))
    grid = theta[0] + TAU * np.arange(turns * per_turn) / per_turn
    even = np.interp(grid, theta, samples)
    window = np.hanning(len(even) + 1)[:-1]
    lines = 2.0 * np.abs(np.fft.rfft((even - even.mean()) * window)) / window.sum()
    order = np.arange(len(lines)) / turns
    keep = order <= max_order + 1e-9
    return order[keep], lines[keep]


def whole_turns(theta_e_rad: Array) -> slice:
    """The longest end of the window that is a whole number of electrical turns; empty when there is none."""
    theta = np.abs(np.unwrap(theta_e_rad) - np.unwrap(theta_e_rad)[-1])
    turns = np.floor(theta[0] / TAU)
    if turns < 1:
        return slice(0, 0)
    start = int(np.argmin(np.abs(theta - turns * TAU)))
    return slice(start, len(theta))


def strongest_orders(
    value: Array, theta_rad: Array, count: int = 3, most: float = MOST_ORDER
) -> list[tuple[float, float]]:
    """The largest lines over the angle as (order, amplitude), largest first; empty when there is less than a turn.

    Only local maxima of at least LEAST_SHARE of the largest, and up to `most` or what the samples can show. Two lines
    closer than the resolution (2 / turns) are one.
    """
    turns = abs(theta_rad[-1] - theta_rad[0]) / TAU if len(theta_rad) > 1 else 0.0
    if turns < 1.0:
        return []
    order, amplitude = order_spectrum(value, theta_rad, min(most, len(value) / turns / 2.5))
    inside = np.flatnonzero((amplitude[1:-1] >= amplitude[:-2]) & (amplitude[1:-1] > amplitude[2:])) + 1
    inside = inside[order[inside] > 1.5 / turns]  # what is left of the mean
    ranked = inside[np.argsort(-amplitude[inside])]
    found: list[tuple[float, float]] = []
    for index in ranked:
        line = (float(order[index]), float(amplitude[index]))
        if found and line[1] < LEAST_SHARE * found[0][1]:
            break
        if all(abs(line[0] - other) > 2.5 / turns for other, _ in found):
            found.append(line)
        if len(found) == count:
            break
    return found
