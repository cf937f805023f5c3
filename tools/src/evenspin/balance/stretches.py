"""Which rows fit and which validate: stretches of a log by turns, so that both have the same speeds; and idle ones.

A log cut in the middle would fit one experiment and validate another. The order of the stretches is that of Thue and
Morse, which no period of the experiment keeps step with.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from evenspin.balance.time_grid import Flags, Grid

Array = NDArray[np.float64]

PIECES = (16, 24, 32, 48, 64, 96)
SHORTEST_S = 0.25
BANDS = 8  # of speed, in which both sets are to have like shares
SLOW_S = 0.05
IDLE_SHARE = 0.02  # of the highest speed
LEAST_IDLE_S = 1.0


@dataclass(frozen=True, slots=True)
class Stretches:
    """Flags over the grid, and the course of the speed without its ripple."""

    fits: Flags
    idle: Flags
    idle_s: tuple[tuple[float, float], ...]
    slow_rad_s: Array


def stretches_of(grid: Grid) -> Stretches:
    slow = slow_speed(grid)
    idle, idle_s = _idle(grid, slow)
    return Stretches(_fits(grid, slow, ~idle), idle, idle_s, slow)


def slow_speed(grid: Grid) -> Array:
    """Course of the speed without its ripple; from the angle where there is one. The ends of the log are whole."""
    if "theta_m_rad" in grid.columns:
        speed = np.gradient(grid.column("theta_m_rad"), grid.period_s)
    else:
        speed = grid.column("speed_rad_s")
    return gaussian_filter1d(speed, max(SLOW_S / grid.period_s, 2.0), mode="nearest")


def thue_morse(count: int) -> Flags:
    """0 1 1 0 1 0 0 1 ..."""
    return np.array([bin(i).count("1") % 2 == 1 for i in range(count)])


def _fits(grid: Grid, slow: Array, used: Flags) -> Flags:
    """Of some numbers of stretches, the one whose two sets have the most alike speeds."""
    at = np.flatnonzero(used)
    edges = np.quantile(slow[at], np.linspace(0.0, 1.0, BANDS + 1)[1:-1])
    band = np.searchsorted(edges, slow[at])
    best, least = np.zeros(len(slow), dtype=bool), np.inf
    for count in PIECES:
        if len(at) * grid.period_s / count < SHORTEST_S and np.isfinite(least):
            break
        fit = ~thue_morse(count)[np.arange(len(at)) * count // len(at)]
        shares = [np.bincount(band[part], minlength=BANDS) / max(int(np.sum(part)), 1) for part in (fit, ~fit)]
        unlike = float(np.max(np.abs(shares[0] - shares[1]))) + 1e-3 * count / PIECES[0]  # longer ones when alike
        if unlike < least:
            least = unlike
            best = np.zeros(len(slow), dtype=bool)
            best[at[fit]] = True
    return best


def _idle(grid: Grid, slow: Array) -> tuple[Flags, tuple[tuple[float, float], ...]]:
    """Long rests: at rest dry friction balances any torque up to its limit, so that the rows carry no information."""
    top = float(np.quantile(np.abs(slow), 0.99))
    still = np.abs(slow) < IDLE_SHARE * top
    edges = np.flatnonzero(np.diff(np.concatenate(([False], still, [False])).astype(int)))
    idle, spans = np.zeros_like(still), []
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        if (end - start) * grid.period_s >= LEAST_IDLE_S:
            idle[start:end] = True
            spans.append((float(grid.t_s[start]), float(grid.t_s[end - 1])))
    return idle, tuple(spans)
