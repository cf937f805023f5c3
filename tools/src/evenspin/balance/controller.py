"""The speed controller of the recorded drive, from the log: proportional gain, its delay, and what else adds current.

A stretch in which the current is the controller's gain times the speed error and nothing more is uncompensated: the
whole ripple is in the speed. Where something else adds current (a feed-forward table), it has moved to the current.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.regression import rms
from evenspin.balance.time_grid import Grid

Array = NDArray[np.float64]

WINDOWS = 16
LAGS_S = np.arange(0.0, 8.01e-3, 0.25e-3)
PLAIN = 0.97  # share of the variance of the current that the gain explains where nothing else acts
RATIO = 3.0  # of what the gain leaves, between two parts of a log, for them to be called different
LEAST_PART = 0.08  # of the log


@dataclass(frozen=True, slots=True)
class Part:
    """A stretch of the log under one rule. `added_a`: current beside the controller's, rms."""

    start_s: float
    end_s: float
    plain: bool
    added_a: float
    speed_ripple_rad_s: float
    current_ripple_a: float


@dataclass(frozen=True, slots=True)
class Controller:
    """iq = gain (speed_ref - speed) a while later. `lag_s`: from the logged speed to the logged current."""

    gain_as_per_rad: float
    offset_a: float
    lag_s: float
    explained: float  # share of the current's variance in the plain parts
    parts: tuple[Part, ...]

    @property
    def plain(self) -> tuple[Part, ...]:
        return tuple(part for part in self.parts if part.plain)


def find_controller(grid: Grid) -> Controller | None:
    """None: no speed reference, or no stretch in which a gain explains the current."""
    if "speed_ref_rad_s" not in grid.columns or "speed_rad_s" not in grid.columns:
        return None
    error = grid.column("speed_ref_rad_s") - grid.column("speed_rad_s")
    iq = grid.column("iq_a")
    windows = [w for w in np.array_split(np.arange(len(iq)), WINDOWS) if np.std(iq[w]) > 0.0 and np.std(error[w]) > 0.0]
    if not windows:
        return None
    shares = np.array([[_line(_lagged(grid, error, lag)[w], iq[w])[2] for w in windows] for lag in LAGS_S])
    if shares.max() < PLAIN:
        return None
    good = [w for w, share in zip(windows, shares.max(axis=0), strict=True) if share >= PLAIN]
    rows = np.concatenate(good)
    left = np.array([1.0 - _line(_lagged(grid, error, lag)[rows], iq[rows])[2] for lag in LAGS_S])
    lag_s = vertex(LAGS_S, left)
    late = _lagged(grid, error, lag_s)
    gain, offset, share = _line(late[rows], iq[rows])
    if not gain > 0.0:
        return None
    added = iq - gain * late - offset
    return Controller(gain, offset, lag_s, share, _parts(grid, added, iq))


def _lagged(grid: Grid, x: Array, lag_s: float) -> Array:
    return np.interp(grid.t_s - lag_s, grid.t_s, x)


def _line(x: Array, y: Array) -> tuple[float, float, float]:
    """Slope, intercept, share of the variance of y."""
    slope = float(np.cov(x, y, bias=True)[0, 1] / max(np.var(x), 1e-300))
    intercept = float(y.mean() - slope * x.mean())
    return slope, intercept, 1.0 - float(np.var(y - slope * x) / np.var(y))


def vertex(x: Array, y: Array) -> float:
    """Abscissa of the lowest point, by a parabola through its neighbours."""
    i = int(np.clip(np.argmin(y), 1, len(x) - 2))
    a, b, c = y[i - 1 : i + 2]
    bend = a - 2.0 * b + c
    return float(x[i] + (0.5 * (a - c) / bend if bend > 0.0 else 0.0) * (x[1] - x[0]))


def _parts(grid: Grid, added: Array, iq: Array) -> tuple[Part, ...]:
    """One part, or two with the most likely instant between them."""
    n = len(added)
    least = int(LEAST_PART * n)
    head = np.cumsum(added**2)
    at = np.arange(least, n - least)
    cost = at * np.log(head[at - 1] / at + 1e-300) + (n - at) * np.log((head[-1] - head[at - 1]) / (n - at) + 1e-300)
    cut = int(at[np.argmin(cost)])
    levels = rms(added[:cut]), rms(added[cut:])
    if max(levels) < RATIO * min(levels):
        return (_part(grid, added, iq, slice(0, n)),)
    parts = _part(grid, added, iq, slice(0, cut)), _part(grid, added, iq, slice(cut, n))
    if parts[0].plain and parts[1].plain:
        return (_part(grid, added, iq, slice(0, n)),)
    return parts


def _part(grid: Grid, added: Array, iq: Array, rows: slice) -> Part:
    speed = grid.column("speed_rad_s")[rows]
    share = 1.0 - np.var(added[rows]) / max(float(np.var(iq[rows])), 1e-300)
    end_s = float(grid.t_s[rows][-1]) + grid.period_s
    plain = bool(share >= PLAIN - 0.05)
    return Part(float(grid.t_s[rows][0]), end_s, plain, rms(added[rows]), float(np.std(speed)), float(np.std(iq[rows])))
