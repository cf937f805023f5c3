"""Angle, speed, acceleration and current of one instant, with the delay of the drive's speed estimate undone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.csv_rows import HINT
from evenspin.balance.log_reader import Log
from evenspin.balance.regression import Fit, fit, rms
from evenspin.balance.smoothing import Smoother
from evenspin.balance.time_grid import SHAFT, Flags, Grid
from evenspin.errors import InputError

Array = NDArray[np.float64]

LAG_SIGMA_S = 2.5e-3  # smoothing for the comparison of angle and speed
UNIT_BAND = (0.93, 1.07)  # speed over rate of the angle; outside, one of them is not in rad
SURE_S = 1e-3  # a delay known worse than this is not used
LEAST_RAD = 2.0 * np.pi
MOST_DELAY_S = 0.05
ORDERS = 3  # derivatives of the logged speed that may be needed to undo its filter
CHANCE = 1e-4
JITTER_SIGMA_S = 10e-3
NOISIER = 5.0  # noise of the angle's second derivative over that of the speed's first
COUNTS = 3.0  # noise of the angle over that of counting
LEAST_COUNT = 3e-5  # rad: less is the rounding of a CSV
SIGN_SIGMA_S = 2.5e-3  # smoothing of the speed whose sign dry friction has
SIGN_SIGMAS = 3.0  # of its noise, below which a sign is uncertain
UNCERTAIN_SHARE = 0.05  # of the smoothing with such a sign, at most
WORTH = 0.01  # share of the difference between angle and speed that a further derivative must take away


@dataclass(frozen=True, slots=True)
class Lag:
    """How the drive's speed estimate follows the angle: speed = estimate + sum of undo[j] times its (j+1)th derivative.

    One term is a delay. A tracking filter of second order needs two, and is undone exactly by them.
    """

    delay_s: float
    half_s: float  # of the 95 % interval
    gain: float
    known: bool
    undo: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Motion:
    """Everything smoothed alike. `theta_rad` is not smoothed: functions of it are, as columns."""

    smooth: Smoother
    t_s: Array
    iq_a: Array
    speed_rad_s: Array
    accel_rad_s2: Array
    raw_speed_rad_s: Array  # smoothed for its sign, which enters a column that is smoothed then
    theta_rad: Array | None
    good: Flags
    sure_sign: Flags  # the sign of the speed stands out of its noise over nearly all of the smoothing
    speed_noise: float  # rad/s rms, of the smoothed speed
    accel_noise: float  # rad/s^2 rms


def speed_lag(log: Log, grid: Grid) -> Lag:
    """dtheta/dt = gain w + delay dw/dt + ..., by least squares. A gain other than 1 is a wrong unit."""
    _check_motion(log)
    if "theta_m_rad" not in grid.columns or "speed_rad_s" not in grid.columns:
        return Lag(0.0, 0.0, 1.0, known=False)
    smooth = Smoother(max(LAG_SIGMA_S, 2.0 * grid.period_s), grid.period_s)
    rows = grid.good(2.0 * smooth.half * grid.period_s)
    w = grid.column("speed_rad_s")
    truth = smooth.rate(grid.column("theta_m_rad"))[rows]
    columns = [smooth(w)[rows], *(smooth.rate(w, order)[rows] for order in range(1, ORDERS + 1))]
    tried: list[Fit] = [
        fit(("gain", *(f"order_{j}" for j in range(1, count + 1))), columns[: count + 1], truth)
        for count in range(1, ORDERS + 1)
    ]
    found = tried[0]
    _check_units(log, found["gain"], found.half("gain"))
    for more in tried[1:]:
        better = rms(more.residual) < (1.0 - WORTH) * rms(found.residual)
        if better and more.p_value((more.names[-1],)) < CHANCE:
            found = more
    delay_s, half_s = found["order_1"], found.half("order_1")
    known = half_s < SURE_S and abs(delay_s) < MOST_DELAY_S
    undo = tuple(float(value) for value in found.value[1:]) if known else ()
    return Lag(delay_s if known else 0.0, half_s, found["gain"], known, undo)


def _check_motion(log: Log) -> None:
    """A rotor at rest shows nothing of the torque."""
    if log.theta_m_rad is not None:
        turned_rad = float(np.ptp(log.theta_m_rad))
    else:
        assert log.speed_rad_s is not None
        turned_rad = float(np.sum(np.abs(log.speed_rad_s[1:]) * np.diff(log.t_s)))
    if turned_rad < LEAST_RAD:
        must = f"at least {LEAST_RAD:.2f} rad, one turn"
        raise InputError(log.path, "travel of the rotor", f"{turned_rad:.3g} rad", must, "record a motor that turns")


def _check_units(log: Log, gain: float, half: float) -> None:
    low, high = UNIT_BAND
    if low - half < gain < high + half:
        return
    ratio = f"{gain:.4g} rad of theta_m_rad per rad of speed_rad_s"
    raise InputError(
        log.path, "theta_m_rad", ratio, f"{low:g} .. {high:g}, or one of them is not in rad and rad/s", HINT
    )


def motion_of(grid: Grid, sigma_s: float, lag: Lag, current_later_s: float = 0.0, *, by_speed: bool = False) -> Motion:
    """On the time base of the angle, and made from it, or from the logged speed with its lag undone.

    `current_later_s`: how much the logged current lags the torque balance.
    """
    smooth = Smoother(max(sigma_s, grid.period_s), grid.period_s)
    fine = Smoother(max(SIGN_SIGMA_S, 2.0 * grid.period_s), grid.period_s)
    undo = lag.undo if by_speed and len(lag.undo) > 1 else ()
    source = grid.column("speed_rad_s", 0.0 if undo else lag.delay_s) if by_speed else grid.column("theta_m_rad")
    first = 0 if by_speed else 1  # derivatives from the source to the speed
    noise = white_noise(source)

    def derivative(smoother: Smoother, order: int) -> Array:
        found = smoother.rate(source, order) if order else smoother(source)
        return found + sum((c * smoother.rate(source, order + j) for j, c in enumerate(undo, 1)), np.zeros_like(found))

    raw = derivative(fine, first)
    half_width = (np.abs(raw) < SIGN_SIGMAS * noise * fine.gain(first)).astype(float)
    reach_s = smooth.half * grid.period_s + abs(lag.delay_s) + abs(current_later_s)
    return Motion(
        smooth,
        grid.t_s,
        smooth(grid.column(SHAFT, current_later_s)),
        derivative(smooth, first),
        derivative(smooth, first + 1),
        raw,
        grid.columns.get("theta_m_rad"),
        grid.good(reach_s),
        smooth(half_width) < UNCERTAIN_SHARE,
        noise * smooth.gain(first),
        noise * smooth.gain(first + 1),
    )


def angle_jitters(grid: Grid) -> bool:
    """Rows whose time is not that of their angle: speed is the better source then.

    Counting an angle makes noise of a count's size, and the drive's own speed has the same; a time that is off makes
    more, in proportion to the speed, and the drive's speed has nothing of it.
    """
    if "theta_m_rad" not in grid.columns or "speed_rad_s" not in grid.columns:
        return "theta_m_rad" not in grid.columns
    theta = grid.column("theta_m_rad")
    smooth = Smoother(JITTER_SIGMA_S, grid.period_s)
    angle_balance_of, of_speed = white_noise(theta), white_noise(grid.column("speed_rad_s"))
    noisier = angle_balance_of * smooth.gain(2) > NOISIER * of_speed * smooth.gain(1)
    return noisier and angle_balance_of > COUNTS * count_of(theta) / np.sqrt(12.0)


def count_of(theta: Array) -> float:
    """One count of an angle, rad; 0 when it does not move in counts."""
    apart = np.diff(np.unique(np.round(np.diff(theta), 6)))
    apart = apart[apart > LEAST_COUNT]
    return float(np.quantile(apart, 0.1)) if len(apart) else 0.0


def white_noise(x: Array) -> float:
    """Noise of a column, rms, from its fourth differences: those of anything smooth are small."""
    return float(np.sqrt(np.mean(np.diff(x, 4) ** 2) / 70.0)) if len(x) > 4 else 0.0
