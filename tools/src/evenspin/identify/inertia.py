"""Inertia from a run that accelerates and brakes.

The second difference of the angle over m samples is the mean of the acceleration under a triangle of 2 m samples,
exactly. With the torque averaged under the same triangle, J a = T - friction - torque tied to the angle is linear.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from evenspin.errors import InputError
from evenspin.identify.estimate import Array, Estimate, linear
from evenspin.identify.source import TURN_RAD, Run

WINDOW_S = 0.008
ORDERS = 32  # torque tied to the angle: whole orders up to here, when the run is long enough to separate them
UNSURE = 0.1
WHERE = "identify inertia"


@dataclass(frozen=True, slots=True)
class Inertia:
    """`residual_nm` is what inertia, friction and whole orders do not explain."""

    inertia_kgm2: Estimate
    acceleration_rad_s2: Array
    inertial_nm: Array
    residual_nm: Array


def identify_inertia(runs: Sequence[Run]) -> Inertia:
    """Fit all runs together."""
    pieces = [_columns(run) for run in runs if len(run.theta_rad) > 4 * _window(run)]
    if not pieces:
        raise InputError(WHERE, "LOG", "too short", f"longer than {4.0 * WINDOW_S:g} s", "record longer")
    a, columns, torque = (np.concatenate([piece[i] for piece in pieces]) for i in range(3))
    if not (a.max() > 0.0 > a.min()) or np.sqrt(np.mean(a**2)) < 1.0:
        given = f"{a.min():.3g} .. {a.max():.3g} rad/s^2"
        must = "both speeding up and braking"
        raise InputError(WHERE, "acceleration", given, must, "ramp the speed reference up and down")
    if np.ptp(columns[:, 0]) == 0.0:  # one direction: Coulomb friction and an offset are the same
        columns = columns[:, 1:]
    turns = sum(run.turns for run in runs)
    if turns >= 3.0:
        theta = columns[:, -1]
        phases = np.outer(theta, np.arange(1, ORDERS + 1))
        columns = np.hstack((columns[:, :-1], np.cos(phases), np.sin(phases)))
    else:
        columns = columns[:, :-1]
    # neighbouring rows share most of their triangle: 1 / (2 m) of a row is new
    effective = 1.0 / (2.0 * _window(runs[0]))
    estimates, residual = linear(np.column_stack((a, columns)), torque, effective)
    inertia = estimates[0]
    if not (inertia.value > 0.0 and inertia.relative < UNSURE):
        given = f"{inertia.value:.4g} +- {inertia.half:.2g} kg m^2"
        raise InputError(WHERE, "inertia", given, f"sure to +-{100 * UNSURE:g} %", "accelerate faster, or longer")
    return Inertia(inertia, a, inertia.value * a + residual, residual)


def _window(run: Run) -> int:
    return max(2, round(WINDOW_S / run.ts_s))


def _columns(run: Run) -> tuple[Array, Array, Array]:
    """(acceleration, [sgn v, v, 1, angle], torque), each the mean under the triangle."""
    m = _window(run)
    theta, middle = run.theta_rad, slice(m, -m)
    span = m * run.ts_s
    a = (theta[2 * m :] - 2.0 * theta[m:-m] + theta[: -2 * m]) / span**2
    v = (theta[2 * m :] - theta[: -2 * m]) / (2.0 * span)
    triangle = np.concatenate((np.arange(1, m + 1), np.arange(m - 1, 0, -1))) / m**2
    torque = np.convolve(run.torque_nm, triangle, mode="valid")[1:-1]
    moving = np.abs(v) > 0.05 * np.abs(v).max()  # friction near standstill is not a straight line
    columns = np.column_stack((np.sign(v), v, np.ones(len(v)), theta[middle] % TURN_RAD))
    return a[moving], columns[moving], torque[moving]
