"""The eight experiments of the measured-log format, one value of every input per control period.

Written apart from evenspin.log on purpose: each of the two lists checks the other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.blind.referee import PWM_HZ, Inputs

RPM = math.pi / 30.0
STEPS_OF_RATED = (0.0, 0.15, 0.3, 0.6, 0.9, 0.0, -0.3, -0.6, 0.0)
VALIDATION_RAMP_RAD_S2 = 4000.0 * RPM


@dataclass(frozen=True, slots=True)
class Experiment:
    """A record to be made."""

    name: str
    inputs: Inputs
    locked: bool
    load_measured: bool

    @property
    def decimate(self) -> int:
        return 1 if self.locked else 5

    @property
    def duration_s(self) -> float:
        return len(self.inputs) / PWM_HZ


def all_experiments(rng: np.random.Generator, rated_current_a: float, rated_torque_nm: float) -> list[Experiment]:
    """In the order in which they are recorded; the random ones are drawn from `rng`."""
    half_nm = 0.5 * rated_torque_nm
    stairs = (60, 120, 200, 300, 400, 500, 600)
    up = [(1.3 if rpm <= 120 else 0.8, rpm * RPM) for rpm in stairs]
    loaded = [(1.3 if rpm <= 60 else 0.9, rpm * RPM) for rpm in (60, 200, 450)]
    return [
        _turning("staircase", _held(up + [(s, -w) for s, w in up])),
        _turning("staircase_load", _held(loaded + [(s, -w) for s, w in loaded]), half_nm),
        _turning(
            "load_step",
            _held([(3.6, 300 * RPM)]),
            _held([(0.8, 0.0), (0.7, half_nm), (0.7, 0.0), (0.7, -half_nm), (0.7, 0.0)]),
        ),
        _turning("reversal", _reversal()),
        _coast_down(),
        _locked("standstill_steps", 0.06, *_axis_after_axis(rated_current_a)),
        _validation(rng, half_nm),
        _validation_steps(rng, rated_current_a),
    ]


def _held(levels: Sequence[tuple[float, float]]) -> NDArray[np.float64]:
    """(seconds, value) one after the other."""
    return np.concatenate([np.full(round(seconds * PWM_HZ), value) for seconds, value in levels])


def _turning(
    name: str, speed_ref_rad_s: NDArray[np.float64], load_nm: NDArray[np.float64] | float | None = None
) -> Experiment:
    count = len(speed_ref_rad_s)
    none = np.zeros(count)
    load = none if load_nm is None else np.broadcast_to(load_nm, (count,))
    return Experiment(name, Inputs(speed_ref_rad_s, none, none, load, none), False, load_nm is not None)


def _reversal() -> NDArray[np.float64]:
    t_s = np.arange(round(7.2 * PWM_HZ)) / PWM_HZ
    fast, slow = 300 * RPM, 60 * RPM
    return np.where(
        t_s < 3.6,
        np.interp(t_s, (0.2, 1.0, 2.8, 3.4, 3.6), (0.0, 0.8 * fast, -fast, -fast, -0.8 * fast)),
        np.interp(t_s, (4.0, 5.2, 5.6, 6.8), (slow, -slow, -slow, slow)),
    )


def _coast_down() -> Experiment:
    turning = _turning("coast_down", _held([(5.2, 600 * RPM)])).inputs
    mode = _held([(1.2, 0.0), (4.0, 1.0)])
    none = turning.id_ref_a
    return Experiment("coast_down", Inputs(turning.speed_ref_rad_s, none, none, none, mode), False, False)


def _axis_after_axis(rated_a: float) -> tuple[list[float], list[float]]:
    steps = [share * rated_a for share in STEPS_OF_RATED]
    rest = [0.0] * len(steps)
    return steps + rest, rest + steps


def _locked(name: str, seconds: float, id_a: Sequence[float], iq_a: Sequence[float]) -> Experiment:
    id_ref, iq_ref = _held([(seconds, i) for i in id_a]), _held([(seconds, i) for i in iq_a])
    none = np.zeros(len(id_ref))
    return Experiment(name, Inputs(none, id_ref, iq_ref, none, np.ones(len(id_ref))), True, False)


def _validation(rng: np.random.Generator, half_nm: float) -> Experiment:
    duration_s = 6.0
    t_s = np.arange(round(duration_s * PWM_HZ)) / PWM_HZ
    knots_s, knots = [0.0], [rng.uniform(-60.0, 60.0)]
    while knots_s[-1] < duration_s:
        start_s = knots_s[-1] + rng.uniform(0.2, 0.65)
        target = rng.uniform(-60.0, 60.0)
        knots_s += [start_s, start_s + abs(target - knots[-1]) / VALIDATION_RAMP_RAD_S2]
        knots += [knots[-1], target]
    load = np.zeros(len(t_s))
    at_s = 0.0
    while at_s < duration_s:
        level = 0.0 if rng.uniform() < 0.4 else rng.uniform(-1.04, 1.04) * half_nm
        load[round(at_s * PWM_HZ) :] = level
        at_s += rng.uniform(0.35, 1.2)
    return _turning("validation", np.interp(t_s, knots_s, knots), load)


def _validation_steps(rng: np.random.Generator, rated_a: float) -> Experiment:
    return _locked(
        "validation_steps",
        0.03,
        list(rng.uniform(-0.9, 0.9, 20) * rated_a),
        list(rng.uniform(-0.8, 0.8, 20) * rated_a),
    )
