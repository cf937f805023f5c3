"""Friction from runs at constant speeds: viscous, Coulomb, static, Stribeck speed and shape.

The torque is averaged over the angle, over whole turns: a torque tied to the angle, however large, does no work over a
turn and cancels, and so does the inertia.

    T(v) = offset + B v + [T_c + (T_s - T_c) exp(-(|v| / v_s)^shape)] sgn(v)

Source   Yeh and Liu 2024, equations 1 and 2 (constant-speed experiment).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from evenspin.errors import InputError
from evenspin.identify.estimate import Array, Estimate, nonlinear
from evenspin.identify.source import Run, constant_stretches, whole_turns

NAMES = ("viscous_nms", "coulomb_nm", "static_nm", "stribeck_rad_s", "shape", "offset_nm")
LEAST_SPEEDS = 4  # per direction: as many as a side has parameters of its own, without the Stribeck part
UNSURE = 0.5  # a parameter whose interval is wider than +-50 % is not determined
WHERE = "identify friction"


@dataclass(frozen=True, slots=True)
class FrictionPoint:
    """Mean over whole turns at one speed."""

    speed_rad_s: float
    torque_nm: float
    turns: float


@dataclass(frozen=True, slots=True)
class Friction:
    """`estimates` by the names of NAMES; without Stribeck part static is Coulomb and the last two are missing."""

    points: Sequence[FrictionPoint]
    estimates: dict[str, Estimate]
    residual_nm: Array

    def torque_nm(self, speed_rad_s: Array) -> Array:
        return _model(speed_rad_s, [self.value(name) for name in NAMES])

    def value(self, name: str) -> float:
        return self.estimates[name].value if name in self.estimates else 1.0


def friction_points(runs: Sequence[Run]) -> list[FrictionPoint]:
    """One point per stretch of constant speed."""
    points = []
    for run in runs:
        for stretch in constant_stretches(run):
            speed = float(stretch.speed_ref_rad_s[0])
            rows = whole_turns(stretch)
            if rows is None:
                given = f"{stretch.turns:.2f} turns at {speed:g} rad/s"
                raise InputError(run.name, "run", given, "at least one turn", "record longer, or leave this speed out")
            part = stretch.part(rows)
            travel = np.diff(part.theta_rad)
            middle = (part.torque_nm[1:] + part.torque_nm[:-1]) / 2.0
            mean_speed = float((part.theta_rad[-1] - part.theta_rad[0]) / ((len(travel)) * part.ts_s))
            points.append(FrictionPoint(mean_speed, float((middle * travel).sum() / travel.sum()), part.turns))
    return points


def identify_friction(points: Sequence[FrictionPoint], *, stribeck: bool = True) -> Friction:
    """Fit; refuses what these points cannot determine."""
    v = np.array([point.speed_rad_s for point in points])
    torque = np.array([point.torque_nm for point in points])
    _check_speeds(v)
    found, residual = _fit(v, torque, stribeck=stribeck)
    result = Friction(points, found, residual)
    _check_fit(result, np.abs(v), stribeck=stribeck)
    return result


def _fit(v: Array, torque: Array, *, stribeck: bool) -> tuple[dict[str, Estimate], Array]:
    size = np.abs(v)
    along = np.sign(v) * torque
    fast = size >= np.median(size)
    slope, coulomb = np.polyfit(size[fast], along[fast], 1)
    start = [max(slope, 1e-9), max(coulomb, 1e-9)]
    if not stribeck:
        estimates, residual = nonlinear(
            lambda p: _model(v, [p[0], p[1], p[1], 1.0, 1.0, p[2]]),
            [*start, 0.0],
            [0, 0, -np.inf],
            [np.inf] * 3,
            torque,
        )
        viscous, coulomb_e, offset = estimates
        return dict(zip(NAMES[:3], (viscous, coulomb_e, coulomb_e), strict=True)) | {"offset_nm": offset}, residual
    best = None
    rise = max(float(along[np.argmin(size)] - start[0] * size.min() - start[1]), 1e-3 * start[1])
    for knee in np.geomspace(size.min(), size.max(), 7)[1:-1]:  # the sum of squares may have several local minima
        estimates, residual = nonlinear(
            lambda p: _model(v, [p[0], p[1], p[1] + p[2], p[3], p[4], p[5]]),
            [*start, rise, float(knee), 1.5, 0.0],
            [0.0, 0.0, 0.0, 1e-4, 0.1, -np.inf],
            [np.inf, np.inf, np.inf, 1e3, 10.0, np.inf],
            torque,
        )
        if best is None or residual @ residual < best[1] @ best[1]:
            best = (estimates, residual)
    assert best is not None
    (viscous, coulomb_e, rise_e, knee_e, shape, offset), residual = best
    # static = Coulomb + rise; how sure it is, from a fit in which it is a parameter itself
    p0 = [viscous.value, coulomb_e.value, coulomb_e.value + rise_e.value, knee_e.value, shape.value, offset.value]
    again, residual = nonlinear(
        lambda p: _model(v, p),
        p0,
        [0.0, 0.0, 0.0, 1e-4, 0.1, -np.inf],
        [np.inf] * 3 + [1e3, 10.0 + 1e-9, np.inf],
        torque,
    )
    return dict(zip(NAMES, again, strict=True)), residual


def _model(v: Array, p: Sequence[float] | Array) -> Array:
    viscous, coulomb, static, knee, shape, offset = p
    rise = (static - coulomb) * np.exp(-np.minimum((np.abs(v) / knee) ** shape, 700.0))
    return offset + viscous * v + (coulomb + rise) * np.sign(v)


def _check_speeds(v: Array) -> None:
    if len(v) == 0:
        must = "a log with stretches of constant speed"
        raise InputError(WHERE, "LOG", "no constant speed", must, "step the speed reference and hold it for a turn")
    for sign, word in ((1.0, "positive"), (-1.0, "negative")):
        speeds = np.unique(np.round(np.abs(v[np.sign(v) == sign]), 6))
        if len(speeds) < LEAST_SPEEDS:
            must = f"at least {LEAST_SPEEDS}"
            hint = "an offset cannot be separated from Coulomb friction with one direction: add runs"
            raise InputError(WHERE, f"speeds in {word} direction", len(speeds), must, hint)


def _check_fit(result: Friction, size: Array, *, stribeck: bool) -> None:
    if stribeck:
        _check_stribeck(result, size)
    _check_sure("viscous_nms", result.estimates["viscous_nms"], "add faster runs")
    _check_sure("coulomb_nm", result.estimates["coulomb_nm"], "add runs")


def _check_stribeck(result: Friction, size: Array) -> None:
    """Does friction rise towards standstill, and do the runs show where?"""
    knee = result.estimates["stribeck_rad_s"]
    rise = result.value("static_nm") - result.value("coulomb_nm")
    noise = float(np.sqrt(np.mean(result.residual_nm**2)))
    below = np.unique(np.round(size[size < knee.value], 6))
    hint = "add slower runs in both directions, or give --no-stribeck"
    if rise < 3.0 * noise or len(below) < 2 or not knee.relative < UNSURE:
        must = "at least two speeds below the Stribeck speed, where friction rises"
        raise InputError(WHERE, "slowest run", f"{size.min():.3g} rad/s", must, hint)
    if size.max() < 3.0 * knee.value:
        must = f"a speed of at least three times the Stribeck speed ({3.0 * knee.value:.3g} rad/s)"
        raise InputError(WHERE, "fastest run", f"{size.max():.3g} rad/s", must, "add faster runs")
    for name in ("static_nm", "shape"):
        _check_sure(name, result.estimates[name], hint)


def _check_sure(name: str, estimate: Estimate, hint: str) -> None:
    if not estimate.relative < UNSURE:
        given = f"{estimate.value:.4g} +- {estimate.half:.2g}"
        raise InputError(WHERE, name, given, f"sure to +-{100.0 * UNSURE:g} %", hint)
