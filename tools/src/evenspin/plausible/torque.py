"""How much current goes with how much acceleration, whatever else the current does."""

from __future__ import annotations

import math

import numpy as np

from evenspin.plausible.finding import Array, rms

SMOOTH_S = 0.02
ANGLE_SMOOTH_S = 0.06  # where the speed is the rate of a counted angle
SMOOTH_ROWS = 4
LEAST_WINDOWS = 20


def mean_of(x: Array, n: int) -> Array:
    """Of n rows each."""
    sums = np.concatenate(([0.0], np.cumsum(x)))
    return (sums[n:] - sums[:-n]) / n


def acceleration_factor(t_s: Array, speed: Array, current: Array, smooth_s: float = SMOOTH_S) -> tuple[float, float]:
    """Current over acceleration, and how alike both are beside what goes with speed and direction; nan: not known."""
    step_s = float(np.median(np.diff(t_s)))
    n = max(SMOOTH_ROWS, round(smooth_s / step_s)) if step_s > 0.0 else 0
    if n == 0 or len(t_s) < LEAST_WINDOWS * n:
        return math.nan, 0.0
    even = t_s[0] + step_s * np.arange(min(len(t_s), 1 + int((t_s[-1] - t_s[0]) / step_s)))
    smooth = mean_of(np.interp(even, t_s, speed), n)
    if len(smooth) <= LEAST_WINDOWS * n // 2:
        return math.nan, 0.0
    accel = (smooth[n:] - smooth[:-n]) / (n * step_s)
    rows = slice(n // 2, n // 2 + len(accel))
    w = smooth[rows]
    return partial_slope(accel, mean_of(np.interp(even, t_s, current), n)[rows], (w, np.sign(w), np.ones_like(w)))


def partial_slope(x: Array, y: Array, beside: tuple[Array, ...]) -> tuple[float, float]:
    """Slope of y on x and their correlation, after what the other columns explain of both."""
    base = np.column_stack(beside)
    x = x - base @ np.linalg.lstsq(base, x, rcond=None)[0]
    y = y - base @ np.linalg.lstsq(base, y, rcond=None)[0]
    size = rms(x) * rms(y)
    if not size > 0.0:
        return math.nan, 0.0
    like = float(np.mean(x * y)) / size
    return like * rms(y) / rms(x), like


WORK = 0.3  # share of work done on the shaft above which braking loads, not the sign, explain the correlation
AGAINST = -0.3  # correlation of current and acceleration that only disturbances, or a wrong sign, make


def current_is_reversed(t_s: Array, speed: Array, current: Array) -> bool:
    """Whether a torque current has the wrong sign against the motion.

    The shaft speeds up against the current. Load steps under a speed controller do that, too, but then the motor does
    most of the work; a load that drives takes the work away, but then the shaft speeds up with the current.
    """
    _, like = acceleration_factor(t_s, speed, current)
    return like < AGAINST and work_share(speed, current) < WORK


def work_share(speed: Array, current: Array) -> float:
    """Work that a torque current does on a shaft, of all the work in both directions: -1 .. 1; 0 without any."""
    power = current * speed
    total = float(np.sum(np.abs(power)))
    return float(np.sum(power)) / total if total > 0.0 else 0.0
