"""Inertia and viscous friction from a log in which the torque changes all the time, such as a pseudo-random sequence.

    J dw/dt + B w + T_0 = k_T i_q                                                                            (1)

The angle of the encoder is not differentiated: (1) is multiplied with a smooth function f(t) that is zero, with its
first two derivatives, at both ends of a window, and integrated by parts (Shinbrot 1957):

    J int f'' theta  -  B int f' theta  +  T_0 int f  =  k_T int f i_q                                       (2)

Each window gives one line of a linear problem. T_0 is what does not change with the speed: Coulomb friction, a load.
It is fitted, too; without changes of the speed B cannot be separated from it, and the interval of B says so.

Source   Tang et al. 2020, section V-D: J and B from a low-frequency pseudo-random torque.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from evenspin.errors import InputError
from evenspin.identify.estimate import Array, Estimate, linear
from evenspin.identify.source import Run

WHERE = "identify mechanics"
WINDOW_S = 0.2
OVERLAP = 4  # windows that a sample is in
LEAST_WINDOWS = 12
SLOW = 0.1  # of the fastest: below this, friction is not a straight line
UNSURE = 0.1


@dataclass(frozen=True, slots=True)
class Mechanics:
    """`speed_rad_s`, `torque_nm`, `residual_nm`: means over the windows, at `t_s`; the residual is what (1) leaves."""

    inertia_kgm2: Estimate
    viscous_nms: Estimate
    constant_nm: Estimate
    window_s: float
    t_s: Array
    speed_rad_s: Array
    torque_nm: Array
    residual_nm: Array


def identify_mechanics(runs: Sequence[Run], window_s: float = WINDOW_S) -> Mechanics:
    """Fit all runs together; an InputError says what the data lack."""
    if not 0.0 < window_s < 3600.0:
        raise InputError(WHERE, "--window-s", window_s, "above 0 and below 3600 s", f"try {WINDOW_S:g}")
    lines = [_lines(run, window_s) for run in runs]
    t_s, speed, columns, torque = (np.concatenate([line[i] for line in lines]) for i in range(4))
    if len(t_s) < LEAST_WINDOWS:
        must = f"at least {LEAST_WINDOWS}, in which the rotor turns in one direction"
        raise InputError(WHERE, "windows", len(t_s), must, "record longer, turn faster, or shorten --window-s")
    estimates, residual = linear(columns, torque, 1.0 / OVERLAP)
    inertia, viscous, constant = estimates
    _check(inertia, "inertia", "kg m^2", "make the steps of the torque larger or the record longer")
    swing = np.ptp(speed) / np.abs(speed).max()
    hint = f"the speed varies by {100.0 * swing:.0f} % of its largest: let it vary more, or record longer"
    _check(viscous, "viscous friction", "N m s/rad", hint)
    return Mechanics(inertia, viscous, constant, window_s, t_s, speed, torque, residual)


def _check(estimate: Estimate, name: str, unit: str, hint: str) -> None:
    if not (estimate.value > 0.0 and estimate.relative < UNSURE):
        given = f"{estimate.value:.3g} +- {estimate.half:.2g} {unit}"
        raise InputError(WHERE, name, given, f"above 0 and sure to +-{100.0 * UNSURE:g} %", hint)


def _lines(run: Run, window_s: float) -> tuple[Array, Array, Array, Array]:
    """(time, mean speed, columns, torque) of the windows of (2), each divided by int f."""
    length = round(window_s / run.ts_s) + 1
    if length < 9:
        raise InputError(WHERE, "--window-s", window_s, f"at least {8.0 * run.ts_s:g} s, 8 rows", "make it longer")
    if len(run.theta_rad) < length:
        return np.empty(0), np.empty(0), np.empty((0, 3)), np.empty(0)
    x = np.linspace(0.0, 1.0, length)
    span_s = (length - 1) * run.ts_s
    # (x (1 - x))^4: its second derivative, too, is flat at both ends, which makes sums as good as integrals
    u = x * (1.0 - x)
    area = float((u**4).sum())
    f = u**4 / area
    first = 4.0 * u**3 * (1.0 - 2.0 * x) / span_s / area
    second = 4.0 * u**2 * (3.0 - 14.0 * u) / span_s**2 / area
    step = max(1, length // OVERLAP)
    theta = sliding_window_view(run.theta_rad, length)[::step]
    torque = sliding_window_view(run.torque_nm, length)[::step]
    theta = theta - theta[:, :1]  # both derivatives are blind to a constant, but not to its rounding
    speed = -theta @ first
    slowest = np.diff(theta[:, :: max(1, length // 8)], axis=1) / (max(1, length // 8) * run.ts_s)
    limit = SLOW * np.abs(speed).max(initial=0.0)
    kept = (slowest.min(axis=1) > limit) | (slowest.max(axis=1) < -limit)
    columns = np.column_stack((theta @ second, speed, np.sign(speed)))
    t_s = (np.arange(len(theta)) * step + (length - 1) / 2.0) * run.ts_s
    return t_s[kept], speed[kept], columns[kept], (torque @ f)[kept]
