"""The eight experiments with their references and loads, for a machine of any size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from evenspin.log.experiments import LOCKED_HZ, LOG_HZ, Experiment
from evenspin.model import InputCurve

RPM = math.pi / 30.0
# Speeds are shares of the top speed, which is 600 r/min in the format.
STAIRS = (60 / 600, 120 / 600, 200 / 600, 300 / 600, 400 / 600, 500 / 600, 600 / 600)
STAIRS_S = (1.3, 1.3, 0.8, 0.8, 0.8, 0.8, 0.8)  # the slow ones last longer: ripple needs turns
LOADED_STAIRS, LOADED_STAIRS_S = (60 / 600, 200 / 600, 450 / 600), (1.3, 0.9, 0.9)
FAST, SLOW = 300 / 600, 60 / 600  # of load_step and reversal
RAMP = (  # of reversal: time, and share of FAST; then slowly through standstill, shares of SLOW
    ((0.0, 0.0), (0.2, 0.0), (1.0, 1.0), (2.6, -1.0), (3.4, -1.0)),
    ((4.0, 1.0), (5.2, -1.0), (5.6, -1.0), (6.8, 1.0), (7.2, 1.0)),
)
LOAD_STEPS, LOAD_STEPS_S = (0.0, 1.0, 0.0, -1.0, 0.0), (0.8, 0.7, 0.7, 0.7, 0.7)  # of half the rated torque
COAST_FROM_S, COAST_END_S = 1.2, 5.2
CURRENT_STEPS = (0.0, 0.15, 0.3, 0.6, 0.9, 0.0, -0.3, -0.6, 0.0)  # of the rated current, first in d, then in q
CURRENT_STEP_S, VALIDATION_STEP_S = 0.06, 0.03
VALIDATION_S, VALIDATION_STEPS = 6.0, 20
VALIDATION_D, VALIDATION_Q = 0.9, 0.8  # of the rated current, drawn together

Points = Sequence[tuple[float, float]]  # time, value


@dataclass(frozen=True, slots=True)
class Sizes:
    """What the experiments are scaled by."""

    top_rad_s: float
    half_load_nm: float  # half the rated torque
    current_a: float  # the rated current, or less where the drive does not allow it


def eight_experiments(sizes: Sizes, seed: int = 1) -> tuple[Experiment, ...]:
    """In the order in which they are to be recorded, at rest in between; `seed` of the two random ones."""
    random = np.random.default_rng(seed)
    return (
        _staircase(sizes),
        _staircase_load(sizes),
        _load_step(sizes),
        _reversal(sizes),
        _coast_down(sizes),
        _standstill_steps(sizes),
        _validation(sizes, random),
        _validation_steps(sizes, random),
    )


def _staircase(sizes: Sizes) -> Experiment:
    up = _shares(STAIRS, sizes.top_rad_s)
    return _turning(
        "staircase",
        f"speed mode, no load machine: {_list(up)} r/min, then the same negative; 1.3 s each at the two "
        "slowest, else 0.8 s",
        _held([*up, *(-w for w in up)], STAIRS_S * 2),
        2.0 * sum(STAIRS_S),
    )


def _staircase_load(sizes: Sizes) -> Experiment:
    up, load_nm = _shares(LOADED_STAIRS, sizes.top_rad_s), sizes.half_load_nm
    return _turning(
        "staircase_load",
        f"speed mode: {_list(up)} r/min, then negative, with a constant load of {load_nm:.3g} N m of one sign, "
        "measured",
        _held([*up, *(-w for w in up)], LOADED_STAIRS_S * 2),
        2.0 * sum(LOADED_STAIRS_S),
        [(0.0, load_nm)],
    )


def _load_step(sizes: Sizes) -> Experiment:
    fast, load_nm = FAST * sizes.top_rad_s, sizes.half_load_nm
    return _turning(
        "load_step",
        f"{fast / RPM:.0f} r/min; load 0, {load_nm:.3g}, 0, {-load_nm:.3g}, 0 N m, measured",
        [(0.0, fast)],
        sum(LOAD_STEPS_S),
        _held(_shares(LOAD_STEPS, load_nm), LOAD_STEPS_S),
    )


def _reversal(sizes: Sizes) -> Experiment:
    fast, slow = FAST * sizes.top_rad_s, SLOW * sizes.top_rad_s
    points = [(t, share * top) for part, top in zip(RAMP, (fast, slow), strict=True) for t, share in part]
    return _turning(
        "reversal",
        f"speed ramps 0, {fast / RPM:.0f}, {-fast / RPM:.0f} r/min, then slowly between {slow / RPM:.0f} and "
        f"{-slow / RPM:.0f} r/min through standstill; no load machine",
        points,
        points[-1][0],
        linear=True,
    )


def _coast_down(sizes: Sizes) -> Experiment:
    return Experiment(
        "coast_down",
        "speed",
        COAST_END_S,
        LOG_HZ,
        {"speed_ref_rad_s": _curve([(0.0, sizes.top_rad_s)])},
        current_from_s=COAST_FROM_S,
        what=f"{sizes.top_rad_s / RPM:.0f} r/min for {COAST_FROM_S:g} s, then current mode with id_ref = iq_ref = 0 "
        f"for {COAST_END_S - COAST_FROM_S:g} s",
    )


def _standstill_steps(sizes: Sizes) -> Experiment:
    steps, zeros = _shares(CURRENT_STEPS, sizes.current_a), [0.0] * len(CURRENT_STEPS)
    return _locked(
        "standstill_steps",
        f"rotor held; current mode: id_ref {_list(steps, 1.0)} A, {1e3 * CURRENT_STEP_S:.0f} ms each, then the "
        "same in iq_ref; 10 kHz log",
        [*steps, *zeros],
        [*zeros, *steps],
        CURRENT_STEP_S,
    )


def _validation(sizes: Sizes, random: np.random.Generator) -> Experiment:
    top = sizes.top_rad_s
    times = np.concatenate(([0.0], np.round(np.cumsum(random.uniform(0.25, 0.7, 30)), 3)))
    speed = [(float(t), float(random.uniform(-top, top))) for t in times if t < VALIDATION_S]
    starts = np.concatenate(([0.0], np.round(np.cumsum(random.uniform(0.35, 1.2, 20)), 3)))
    load = [(float(t), float(random.uniform(-1.0, 1.0)) * sizes.half_load_nm) for t in starts if t < VALIDATION_S]
    what = "random speeds and random loads, measured; never used for the fit"
    return _turning("validation", what, speed, VALIDATION_S, load)


def _validation_steps(sizes: Sizes, random: np.random.Generator) -> Experiment:
    return _locked(
        "validation_steps",
        f"rotor held at another angle; random id_ref and iq_ref together, {1e3 * VALIDATION_STEP_S:.0f} ms each; "
        "10 kHz log; never used for the fit",
        list(random.uniform(-VALIDATION_D, VALIDATION_D, VALIDATION_STEPS) * sizes.current_a),
        list(random.uniform(-VALIDATION_Q, VALIDATION_Q, VALIDATION_STEPS) * sizes.current_a),
        VALIDATION_STEP_S,
    )


def _turning(
    name: str, what: str, speed: Points, duration_s: float, load: Points = (), linear: bool = False
) -> Experiment:
    curves = {"speed_ref_rad_s": _curve(speed, linear)} | ({"load_torque_nm": _curve(load)} if load else {})
    return Experiment(name, "speed", round(duration_s, 6), LOG_HZ, curves, what=what)


def _locked(name: str, what: str, id_a: Sequence[float], iq_a: Sequence[float], each_s: float) -> Experiment:
    seconds = [each_s] * len(id_a)
    curves = {"id_ref_a": _curve(_held(id_a, seconds)), "iq_ref_a": _curve(_held(iq_a, seconds))}
    return Experiment(name, "current", each_s * len(id_a), LOCKED_HZ, curves, rotor_locked=True, what=what)


def _shares(shares: Sequence[float], whole: float) -> list[float]:
    return [share * whole for share in shares]


def _held(values: Sequence[float], seconds: Sequence[float]) -> list[tuple[float, float]]:
    starts = np.cumsum([0.0, *seconds[:-1]])
    return [(round(float(t), 6), float(v)) for t, v in zip(starts, values, strict=True)]


def _curve(points: Points, linear: bool = False) -> InputCurve:
    return InputCurve(tuple(t for t, _ in points), tuple(v for _, v in points), linear)


def _list(values: Sequence[float], unit: float = RPM) -> str:
    return ", ".join(f"{value / unit:.3g}" for value in values)
