"""The load that acted, from the reading of a torque sensor: its noise is not part of what happened to the shaft."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

WINDOW = 12  # samples on either side of a possible step
STEP_SIGMAS = 8.0  # change of a mean over its own noise that is a step
APPROACH = 60  # samples that a step may take until the load stands; they stay as read
PLAIN = 1.3  # a stretch is constant when its noise is at most this many times what neighbouring samples show


def steady_load(reading_nm: NDArray[np.float64]) -> NDArray[np.float64]:
    """Constant where the reading is constant; where it moves it is returned as it is. NaN reads as 0."""
    reading = np.nan_to_num(reading_nm)
    out = reading.copy()
    for start, end in steady_stretches(reading):
        out[start:end] = np.mean(reading[start:end])
    return out


def reading_noise(reading_nm: NDArray[np.float64]) -> NDArray[np.float64]:
    """Standard deviation of what `steady_load` leaves in its result, per row, N m."""
    reading = np.nan_to_num(reading_nm)
    sigma = float(np.median(np.abs(np.diff(reading))) / (0.6745 * np.sqrt(2.0))) if len(reading) > 1 else 0.0
    left = np.full(len(reading), sigma)
    for start, end in steady_stretches(reading):
        left[start:end] = 0.0
    return left


def steady_stretches(reading: NDArray[np.float64]) -> list[tuple[int, int]]:
    """Rows [start, end) over which the reading is a constant with white noise."""
    if len(reading) < 4 * WINDOW:
        return []
    sigma = float(np.median(np.abs(np.diff(reading))) / (0.6745 * np.sqrt(2.0)))
    sigma = max(sigma, 1e-6 * float(np.ptp(reading)))
    if sigma == 0.0:
        return [(0, len(reading))]
    moves = _moves(reading, sigma)
    starts = [0, *(last + APPROACH for _, last in moves)]
    ends = [*(first - WINDOW for first, _ in moves), len(reading)]
    return [
        (start, end)
        for start, end in zip(starts, ends, strict=True)
        if end - start >= 4 * WINDOW and _is_constant(reading[start:end], sigma)
    ]


def _moves(reading: NDArray[np.float64], sigma: float) -> list[tuple[int, int]]:
    """First and last row of each change of level."""
    sums = np.concatenate(([0.0], np.cumsum(reading)))
    at = np.arange(WINDOW, len(reading) - WINDOW)
    jump = (sums[at + WINDOW] - 2.0 * sums[at] + sums[at - WINDOW]) / WINDOW
    rows = at[np.abs(jump) > STEP_SIGMAS * sigma * np.sqrt(2.0 / WINDOW)]
    groups = np.split(rows, np.flatnonzero(np.diff(rows) > WINDOW) + 1) if len(rows) else []
    return [(int(group[0]), int(group[-1])) for group in groups]


def _is_constant(x: NDArray[np.float64], sigma: float) -> bool:
    parts = np.array_split(x, max(2, min(8, len(x) // (2 * WINDOW))))
    means = np.array([part.mean() for part in parts])
    spread = sigma / np.sqrt(len(parts[0]))
    return float(np.std(x)) <= PLAIN * sigma and bool(np.all(np.abs(means - x.mean()) <= 5.0 * spread))
