"""How evenly it turns in a window: rms, peak to peak and lines of the true speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.segments import RAD_S
from evenspin.sim import Record

Array = NDArray[np.float64]

TAU = 2.0 * np.pi
ORDERS = (1, 2, 5, 10, 12, 20, 24, 30, 36)  # mechanical: everything that these machines excite


@dataclass(frozen=True, slots=True)
class Evenness:
    """Speed ripple of one window, rpm. `orders`: amplitude of each mechanical order."""

    rms_rpm: float
    pp_rpm: float
    orders: Mapping[int, float]


def evenness(record: Record, start_s: float, end_s: float) -> Evenness:
    """Over the whole mechanical turns at the end of the window."""
    part = record.between(start_s, end_s)
    theta, rpm = part["true_theta_m_rad"], part["true_speed_rad_s"] / RAD_S
    turns = np.floor((theta[-1] - theta[0]) / TAU)
    kept = theta > theta[-1] - turns * TAU
    theta, rpm = theta[kept], rpm[kept]
    amplitudes = line_amplitudes(rpm, theta, ORDERS)
    return Evenness(float(rpm.std()), float(np.ptp(rpm)), dict(zip(ORDERS, amplitudes.tolist(), strict=True)))


def line_amplitudes(value: Array, theta_rad: Array, orders: Sequence[int]) -> Array:
    """Amplitude of each order: least squares of a constant and cos, sin of these orders together."""
    phases = np.outer(theta_rad, orders)
    columns = np.hstack((np.ones((len(theta_rad), 1)), np.cos(phases), np.sin(phases)))
    found = np.linalg.solve(columns.T @ columns, columns.T @ value)
    count = len(orders)
    return np.hypot(found[1 : count + 1], found[count + 1 :])


def rms_by_turn(record: Record) -> tuple[Array, Array]:
    """(time of the end of each mechanical turn, s; rms of the speed around the mean of that turn, rpm)."""
    theta, rpm = record["true_theta_m_rad"], record["true_speed_rad_s"] / RAD_S
    turn = np.floor((theta - theta[0]) / TAU).astype(int)
    turn -= turn.min()
    count = np.maximum(np.bincount(turn), 1)
    mean = np.bincount(turn, rpm) / count
    spread = np.bincount(turn, (rpm - mean[turn]) ** 2) / count
    last = np.searchsorted(turn, np.arange(len(count)), side="right") - 1
    return record["t_s"][last][:-1], np.sqrt(spread)[:-1]  # the last turn is not a whole one


def settled_s(time_s: Array, rms_rpm: Array, limit_rpm: float) -> float:
    """When the rms of a turn exceeded the limit for the last time; nan if it does so to the end."""
    above = np.flatnonzero(rms_rpm > limit_rpm)
    if len(above) == 0:
        return 0.0
    return float(time_s[above[-1]]) if above[-1] + 1 < len(time_s) else float("nan")
