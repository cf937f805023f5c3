"""The experiments that make every effect identifiable, for any machine, and how the virtual drive performs them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from evenspin.errors import NativeError
from evenspin.log import LOG_COLUMNS, meta_of
from evenspin.model import InputCurve, Machine, Setup
from evenspin.model.machine import RATINGS, SIMULATED
from evenspin.native import tables
from evenspin.sim import Record, simulate

RPM = math.pi / 30.0
TOP_RPM = 600.0  # of the format; slower where the dc link does not allow it
VOLTAGE_SHARE = 0.6  # of what the dc link allows, for the back-EMF at the top speed
LOG_HZ, LOCKED_HZ = 2000.0, 10_000.0
START_RAD = 0.4  # arbitrary
LOCKED_STEPS = (0.0, 0.15, 0.3, 0.6, 0.9, 0.0, -0.3, -0.6, 0.0)  # of the rated current
# The controller that the format describes. What else the drive can do would hide what is looked for.
FORMAT_DRIVE = {"method": "pi", "speed_source": "pll", "speed_inline": "true", "current_controller": "pi"}
NOISE_SHARE, LSB_SHARE = 0.003, 0.002  # of the rated current, where the model has none: a real log has both
QUIET_START = {"offset_calibration_periods": 0.0, "align_periods": 0.0, "auto_run": 1.0}
SPEED, LOAD, MODE = "speed_ref_rad_s", "load_torque_nm", "control_mode"
Points = Sequence[tuple[float, float]]  # time, value


@dataclass(frozen=True, slots=True)
class Experiment:
    name: str
    what: str  # for the person at the bench
    setup: Setup
    load_measured: bool

    @property
    def serves(self) -> tuple[str, ...]:
        """Effects that this experiment makes identifiable."""
        return tuple(name for name, effect in tables().effects.items() if self.name in effect.shown_by)


def plan(machine: Machine, seed: int = 1) -> list[Experiment]:
    """In the order in which they are to be recorded, at rest in between."""
    machine.need((*SIMULATED, *RATINGS))
    base = _base(machine, seed)
    random = np.random.default_rng(seed)
    amps, half_nm = machine.plant["rated_current_a"], 0.5 * machine.plant["rated_torque_nm"]
    top = top_speed(machine)

    def speeds(*rpm: float) -> list[float]:
        return [r / TOP_RPM * top for r in rpm]

    stairs = [*speeds(60, 120), *speeds(200, 300, 400, 500, 600)]
    seconds = [1.3, 1.3] + [0.8] * 5
    loaded, loaded_s = speeds(60, 200, 450), [1.3, 0.9, 0.9]
    fast, slow = speeds(300)[0], speeds(60)[0]
    ramp = [(0.0, 0.0), (0.2, 0.0), (1.0, fast), (2.6, -fast), (3.4, -fast), (4.0, slow), (5.2, -slow), (5.6, -slow)]
    held = [(0.8, 0.0), (0.7, half_nm), (0.7, 0.0), (0.7, -half_nm), (0.7, 0.0)]
    top_rpm = top / RPM
    made = [
        (
            "staircase",
            f"speed mode, no load machine: {_list(stairs)} r/min, then the same negative; 1.3 s each at the two "
            "slowest, else 0.8 s",
            _turning(base, _held(stairs, seconds) + _held([-w for w in stairs], seconds, 2 * 1.3 + 5 * 0.8), 13.2),
        ),
        (
            "staircase_load",
            f"speed mode: {_list(loaded)} r/min, then negative, with a constant load of {half_nm:.3g} N m of one sign, "
            "measured",
            _turning(base, _held(loaded, loaded_s) + _held([-w for w in loaded], loaded_s, 3.1), 6.2, [(0.0, half_nm)]),
        ),
        (
            "load_step",
            f"{fast / RPM:.0f} r/min; load 0, {half_nm:.3g}, 0, {-half_nm:.3g}, 0 N m, measured",
            _turning(base, [(0.0, fast)], 3.6, _held([v for _, v in held], [s for s, _ in held])),
        ),
        (
            "reversal",
            f"speed ramps 0, {fast / RPM:.0f}, {-fast / RPM:.0f} r/min, then slowly between {slow / RPM:.0f} and "
            f"{-slow / RPM:.0f} r/min through standstill; no load machine",
            _ramps(base, [*ramp, (6.8, slow), (7.2, slow)], 7.2),
        ),
        (
            "coast_down",
            f"{top_rpm:.0f} r/min for 1.2 s, then current mode with id_ref = iq_ref = 0 for 4 s",
            _coasting(base, top, 1.2, 5.2),
        ),
        (
            "standstill_steps",
            f"rotor held; current mode: id_ref {_list([s * amps for s in LOCKED_STEPS], 1.0)} A, 60 ms each, then the "
            "same in iq_ref; 10 kHz log",
            _locked(
                base, [s * amps for s in LOCKED_STEPS] + [0.0] * 9, [0.0] * 9 + [s * amps for s in LOCKED_STEPS], 0.06
            ),
        ),
        (
            "validation",
            "random speeds and random loads, measured; never used for the fit",
            _random_run(base, random, top, half_nm),
        ),
        (
            "validation_steps",
            "rotor held at another angle; random id_ref and iq_ref together, 30 ms each; 10 kHz log; never used for "
            "the fit",
            _locked(
                replace(base, plant={**base.plant, "initial_angle_rad": START_RAD + 2.0}),
                list(random.uniform(-0.9, 0.9, 20) * amps),
                list(random.uniform(-0.8, 0.8, 20) * amps),
                0.03,
            ),
        ),
    ]
    measured = ("staircase_load", "load_step", "validation")
    return [Experiment(name, what, replace(setup, name=name), name in measured) for name, what, setup in made]


def top_speed(machine: Machine) -> float:
    """rad/s: 600 r/min, or less where the back-EMF would fill the dc link."""
    plant = machine.plant
    allowed = VOLTAGE_SHARE * plant["dc_link_v"] / math.sqrt(3.0) / (plant["pole_pairs"] * plant["psi_wb"])
    return min(TOP_RPM * RPM, allowed)


def perform(experiment: Experiment, progress: Callable[[float], None] | None = None) -> Record:
    record = simulate(experiment.setup, (*LOG_COLUMNS, "fault"), "float", progress)
    if record["fault"].any():
        fault = tables().faults[int(record["fault"].max())]
        raise NativeError(f"{experiment.name}: the drive tripped: {fault.name}; {fault.check}")
    values = record.pick(LOG_COLUMNS).values.copy()
    if not experiment.load_measured:
        values[:, LOG_COLUMNS.index(LOAD)] = np.nan
    return Record(LOG_COLUMNS, record.pick(LOG_COLUMNS).units, values)


def meta(experiments: Sequence[Experiment], case: str) -> dict[str, Any]:
    return meta_of(experiments[0].setup, case, [experiment.name for experiment in experiments])


def changed_model(machine: Machine) -> dict[str, str]:
    """What of the model the plan sets otherwise."""
    params = tables().params
    given = {name: params[name].to_text(machine.drive.get(name, params[name].default)) for name in FORMAT_DRIVE}
    changed = {name: f"{old} -> {FORMAT_DRIVE[name]}" for name, old in given.items() if old != FORMAT_DRIVE[name]}
    return changed | {name: f"0 -> {value:g}" for name, value in _noise(machine).items()}


def _noise(machine: Machine) -> dict[str, float]:
    """What a current measurement has and this model has not."""
    shares = {"current_noise_a": NOISE_SHARE, "current_lsb_a": LSB_SHARE}
    rated_a = machine.plant["rated_current_a"]
    return {name: share * rated_a for name, share in shares.items() if not machine.plant[name] > 0.0}


def _base(machine: Machine, seed: int) -> Setup:
    params = tables().params
    drive = {name: field.default for name, field in params.items()} | dict(machine.drive) | QUIET_START
    words = {"true": 1.0}
    for name, word in FORMAT_DRIVE.items():
        drive[name] = words[word] if word in words else params[name].to_number(word)
    plant = {**machine.plant, **_noise(machine), "initial_angle_rad": START_RAD}
    return Setup(machine.name, plant, drive, machine.effects, {}, (), 1.0, LOG_HZ, seed)


def _turning(base: Setup, speed: Points, duration_s: float, load: Points = ()) -> Setup:
    inputs = {SPEED: _input(speed)} | ({LOAD: _input(load)} if load else {})
    return replace(base, inputs=inputs, duration_s=duration_s)


def _ramps(base: Setup, speed: Points, duration_s: float) -> Setup:
    return replace(base, inputs={SPEED: _input(speed, linear=True)}, duration_s=duration_s)


def _coasting(base: Setup, speed: float, release_s: float, duration_s: float) -> Setup:
    inputs = {SPEED: _input([(0.0, speed)]), MODE: _input([(0.0, 1.0), (release_s, 0.0)])}
    return replace(base, inputs=inputs, duration_s=duration_s)


def _locked(base: Setup, id_a: Sequence[float], iq_a: Sequence[float], each_s: float) -> Setup:
    inputs = {
        MODE: _input([(0.0, 0.0)]),
        "id_ref_a": _input(_held(id_a, [each_s] * len(id_a))),
        "iq_ref_a": _input(_held(iq_a, [each_s] * len(iq_a))),
    }
    plant = {**base.plant, "rotor_locked": 1.0}
    return replace(base, plant=plant, inputs=inputs, duration_s=each_s * len(id_a), log_rate_hz=LOCKED_HZ)


def _random_run(base: Setup, random: np.random.Generator, top: float, half_nm: float) -> Setup:
    duration_s = 6.0
    times = np.concatenate(([0.0], np.round(np.cumsum(random.uniform(0.25, 0.7, 30)), 3)))
    speed = [(float(t), float(random.uniform(-top, top))) for t in times if t < duration_s]
    starts = np.concatenate(([0.0], np.round(np.cumsum(random.uniform(0.35, 1.2, 20)), 3)))
    load = [(float(t), float(random.uniform(-1.0, 1.0)) * half_nm) for t in starts if t < duration_s]
    return _turning(base, speed, duration_s, load)


def _held(values: Sequence[float], seconds: Sequence[float], start_s: float = 0.0) -> list[tuple[float, float]]:
    ends = start_s + np.cumsum([0.0, *seconds[:-1]])
    return [(round(float(t), 6), float(v)) for t, v in zip(ends, values, strict=True)]


def _input(points: Points, linear: bool = False) -> InputCurve:
    return InputCurve(tuple(t for t, _ in points), tuple(v for _, v in points), linear)


def _list(values: Sequence[float], unit: float = RPM) -> str:
    return ", ".join(f"{value / unit:.3g}" for value in values)
