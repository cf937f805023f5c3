"""Lines in what is left of the torque: over the angle, and over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.driven.windows import Windows

Array = NDArray[np.float64]


def order_spectrum(orders: Array, left: Array, theta: Array, speed: Array, windows: Windows) -> tuple[Array, Array]:
    """Amplitude and chi-square of each order over the angle; one fit each, of the left over of every window."""
    return _spectrum(orders, left, theta, lambda k: windows.bump.transform(k * speed))


def frequency_spectrum(hz: Array, left: Array, t_s: Array, windows: Windows) -> tuple[Array, Array]:
    return _spectrum(2.0 * np.pi * hz, left, t_s, lambda w: windows.bump.transform(np.full(1, w)))


def _spectrum(rates, left, phase, passes):  # type: ignore[no-untyped-def]
    amplitude, gain = np.zeros(len(rates)), np.zeros(len(rates))
    variance = max(float((1.4826 * np.median(np.abs(left))) ** 2), 1e-300)
    limited = np.clip(left, -4.0 * np.sqrt(variance), 4.0 * np.sqrt(variance))
    for k, rate in enumerate(rates):
        column = np.exp(1j * rate * phase) * passes(rate)
        power = float(np.sum(np.abs(column) ** 2))
        if power <= 0.02 * len(left):
            continue
        found = 2.0 * np.sum(np.conj(column) * limited) / power
        amplitude[k] = abs(found)
        gain[k] = 0.5 * abs(found) ** 2 * power / variance
    return amplitude, gain


STANDS_OUT = 40.0  # chi-square of a line that becomes a candidate
NEAR = 0.04  # of an order: as near to a known one it is that one, smeared
FINE_ORDERS = 30.0
TOP_ORDER = 200
TOP_HZ = 80.0
FINE_HZ = 0.3


def foreign_orders(
    left: Array, theta: Array, speed: Array, windows: Windows, known: Sequence[float]
) -> list[tuple[float, float]]:
    """Orders that stand out and are none of the known ones, with their chi-square, strongest first."""
    turns = float(np.ptp(theta)) / (2.0 * np.pi)
    if turns < 3.0:
        return []
    step = max(0.01, 0.4 / turns)
    fine = np.arange(0.3, FINE_ORDERS, step)
    orders = np.concatenate((fine, np.arange(FINE_ORDERS, TOP_ORDER + 1.0)))
    _, gain = order_spectrum(orders, left, theta, speed, windows)
    reach = max(NEAR, 2.0 / turns)
    for order in known:
        gain[np.abs(orders - order) < reach] = 0.0
    return _peaks(orders, gain, reach)


def foreign_frequencies(left: Array, t_s: Array, windows: Windows) -> list[tuple[float, float]]:
    span_s = float(np.ptp(t_s))
    top_hz = min(TOP_HZ, 1.0 / (windows.bump.half * windows.bump.period_s))
    hz = np.arange(max(FINE_HZ, 4.0 / span_s), top_hz, 0.4 / span_s)
    _, gain = frequency_spectrum(hz, left, t_s, windows)
    return _peaks(hz, gain, 2.0 / span_s)


def _peaks(at: Array, gain: Array, reach: float, most: int = 2) -> list[tuple[float, float]]:
    found: list[tuple[float, float]] = []
    gain = gain.copy()
    while len(found) < most and len(gain) and float(np.max(gain)) > STANDS_OUT:
        k = int(np.argmax(gain))
        found.append((float(at[k]), float(gain[k])))
        gain[np.abs(at - at[k]) < 3.0 * reach] = 0.0
    return found
