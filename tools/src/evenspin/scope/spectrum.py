"""Ripple as lines: in orders of the angle when it was measured along, else in hertz."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.orders import order_spectrum

ANGLE = "theta_m_rad"
LEAST_ROWS = 32


@dataclass(frozen=True, slots=True)
class Lines:
    """`note` says what to do when there are no lines, or why the axis is another than the one asked for."""

    axis: str  # "electrical", "mechanical" or "hz"
    x: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    mean: float = 0.0
    note: str = ""


def lines_of(
    t_s: NDArray[np.float64], columns: Mapping[str, NDArray[np.float64]], signal: str, axis: str, max_order: float,
    pole_pairs: float,
) -> Lines:  # fmt: skip
    """Amplitudes of one signal. The highest frequency is half the sampling rate; `max_order` counts for orders only."""
    value = columns[signal].astype(float)
    if len(value) < LEAST_ROWS:
        return _none(axis, "Not enough rows yet.")
    mean = float(value.mean())
    if axis == "hz":
        return _in_hertz(t_s, value, mean, "")
    if ANGLE not in columns:
        return _in_hertz(t_s, value, mean, f"In hertz: for orders add {ANGLE} to the signals.")
    angle = columns[ANGLE].astype(float)
    steps = np.abs(np.diff(np.unwrap(angle)))
    times = pole_pairs if axis == "electrical" else 1.0
    if steps.max(initial=0.0) * times > np.pi:
        return _in_hertz(t_s, value, mean, "In hertz: the angle moves more than half a turn between two rows.")
    turned = np.unwrap(angle) * times
    per_turn = 2.0 * np.pi * (len(turned) - 1) / max(abs(turned[-1] - turned[0]), 1e-12)
    x, amplitude = order_spectrum(value, turned, min(max_order, per_turn / 2.5))
    if not len(x):
        return _none(axis, f"Less than one {axis} turn in these rows: turn faster or show more seconds.")
    return Lines(axis, x, amplitude, mean)


def _in_hertz(t_s: NDArray[np.float64], value: NDArray[np.float64], mean: float, note: str) -> Lines:
    period_s = float(np.median(np.diff(t_s)))
    if not np.allclose(np.diff(t_s), period_s, rtol=1e-3):
        last_gap = int(np.flatnonzero(np.abs(np.diff(t_s) / period_s - 1.0) > 1e-3)[-1]) + 1
        value = value[last_gap:]
        if len(value) < LEAST_ROWS:
            return _none("hz", "Rows were lost just now; wait a moment.")
    window = np.hanning(len(value) + 1)[:-1]
    amplitude = 2.0 * np.abs(np.fft.rfft((value - value.mean()) * window)) / window.sum()
    f_hz = np.asarray(np.fft.rfftfreq(len(value), period_s), dtype=np.float64)
    return Lines("hz", f_hz, amplitude, mean, note)


def _none(axis: str, note: str) -> Lines:
    return Lines(axis, np.empty(0), np.empty(0), 0.0, note)
