"""The experiments of the gap workflow: what to command, for how long, at which rate to log. As a list and as a file.

name = "guo2024"
model = "guo2024"                     # nominal motor: a built-in model or a file beside this one

[[experiment]]
name = "staircase"
mode = "speed"                        # or "current"
duration_s = 13.2
log_rate_hz = 2000.0
[experiment.speed_ref_rad_s]          # also id_ref_a, iq_ref_a, load_torque_nm
t_s = [0.0, 1.3]
value = [6.3, 12.6]
linear = false                        # true: straight lines between the points
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import pydantic
import tomlkit

from evenspin.errors import InputError
from evenspin.model import InputCurve, Machine
from evenspin.model.document import read_document
from evenspin.model.machine import RATINGS, SIMULATED, find_model, load_machine
from evenspin.model.schema import Real, Strict, check, within
from evenspin.native import tables

LOG_HZ, STEPS_HZ = 2000.0, 10_000.0
TOP_PART = 0.22  # of the speed at which the back-EMF fills the dc link: the voltage limit stays out of the experiments
OVER_SPEED_PART = 0.7
STAIRS = (0.1, 0.2, 1 / 3, 0.5, 2 / 3, 5 / 6, 1.0)  # of the top speed
SLOW_STAIRS = 2  # so many of them rest longer: ripple needs turns
SLOW_S, FAST_S = 1.3, 0.8
LOAD_STAIRS = ((0.1, 1.3), (1 / 3, 0.9), (0.75, 0.9))
LOAD_PART = 0.5  # of the rated torque
STEPS = (0.0, 0.15, 0.3, 0.6, 0.9, 0.0, -0.3, -0.6, 0.0)  # of the rated current
STEP_S, VALIDATION_STEP_S = 0.06, 0.03
STEPS_PART = 0.85
COAST_FROM_S = 1.2
SEED = 2024  # of the random references: the same list for everybody

CURVES = ("speed_ref_rad_s", "id_ref_a", "iq_ref_a", "load_torque_nm")


@dataclass(frozen=True, slots=True)
class Experiment:
    """One record. Curves begin at 0 s; what has none is 0. `current_from_s`: current mode from then on."""

    name: str
    mode: Literal["speed", "current"]
    duration_s: float
    log_rate_hz: float
    curves: Mapping[str, InputCurve] = field(default_factory=dict)
    rotor_locked: bool = False
    current_from_s: float | None = None

    @property
    def needs_load_machine(self) -> bool:
        return "load_torque_nm" in self.curves

    def value(self, name: str, t_s: float) -> float:
        """A curve at a time."""
        curve = self.curves.get(name)
        if curve is None:
            return 0.0
        if curve.linear:
            return float(np.interp(t_s, curve.t_s, curve.value))
        at = int(np.searchsorted(curve.t_s, t_s + 1e-9, side="right")) - 1
        return curve.value[max(at, 0)]


@dataclass(frozen=True, slots=True)
class ExperimentList:
    """What `evenspin bench run` performs. `model` is as written in the file; `machine` is what it names."""

    name: str
    model: str
    machine: Machine
    experiments: tuple[Experiment, ...]


def plan(machine: Machine, top_rad_s: float | None = None) -> tuple[Experiment, ...]:
    """The eight experiments of the gap workflow for this motor."""
    machine.need((*SIMULATED, *RATINGS))
    plant = machine.plant
    drive = {name: f.default for name, f in tables().params.items()} | dict(machine.drive)
    base_rad_s = plant["dc_link_v"] / math.sqrt(3.0) / max(plant["pole_pairs"] * plant["psi_wb"], 1e-9)
    most_rad_s = OVER_SPEED_PART * drive["over_speed_rad_s"]
    if top_rad_s is None:
        top_rad_s = min(TOP_PART * base_rad_s, most_rad_s)
    if not 0.0 < top_rad_s <= most_rad_s:
        must = f"above 0 and at most {most_rad_s:.4g} rad/s, {OVER_SPEED_PART:g} of over_speed_rad_s"
        raise InputError("bench plan", "--top-speed", top_rad_s, must, "leave it out for a speed that fits the model")
    load_nm = LOAD_PART * plant["rated_torque_nm"]
    current_a = min(plant["rated_current_a"], drive["iq_limit_a"], drive["id_limit_a"])
    return (
        _staircase(top_rad_s),
        _staircase_load(top_rad_s, load_nm),
        _load_step(top_rad_s, load_nm),
        _reversal(top_rad_s),
        _coast_down(top_rad_s),
        _standstill_steps(current_a),
        _validation(top_rad_s, load_nm),
        _validation_steps(current_a),
    )


def _held(steps: list[tuple[float, float]]) -> tuple[InputCurve, float]:
    """(value, for how long): the curve and its end."""
    ends = np.round(np.cumsum([seconds for _, seconds in steps]), 6)
    curve = InputCurve((0.0, *(float(t) for t in ends[:-1])), tuple(round(float(value), 6) for value, _ in steps))
    return curve, float(ends[-1])


def _staircase(top: float) -> Experiment:
    one_way = [(part * top, SLOW_S if number < SLOW_STAIRS else FAST_S) for number, part in enumerate(STAIRS)]
    curve, end_s = _held(one_way + [(-speed, seconds) for speed, seconds in one_way])
    return Experiment("staircase", "speed", end_s, LOG_HZ, {"speed_ref_rad_s": curve})


def _staircase_load(top: float, load_nm: float) -> Experiment:
    one_way = [(part * top, seconds) for part, seconds in LOAD_STAIRS]
    curve, end_s = _held(one_way + [(-speed, seconds) for speed, seconds in one_way])
    curves = {"speed_ref_rad_s": curve, "load_torque_nm": InputCurve((0.0,), (load_nm,))}
    return Experiment("staircase_load", "speed", end_s, LOG_HZ, curves)


def _load_step(top: float, load_nm: float) -> Experiment:
    load, _ = _held([(0.0, 0.7), (load_nm, 0.7), (0.0, 0.7), (-load_nm, 0.7), (0.0, 0.8)])
    curves = {"speed_ref_rad_s": InputCurve((0.0,), (0.5 * top,)), "load_torque_nm": load}
    return Experiment("load_step", "speed", 3.6, LOG_HZ, curves)


def _reversal(top: float) -> Experiment:
    t_s = (0.0, 0.2, 1.2, 1.6, 3.6, 4.0, 4.6, 5.9, 7.2)
    part = (0.0, 0.0, 0.5, 0.5, -0.5, -0.5, 0.1, -0.1, 0.1)
    curve = InputCurve(t_s, tuple(round(top * p, 6) for p in part), linear=True)
    return Experiment("reversal", "speed", 7.2, LOG_HZ, {"speed_ref_rad_s": curve})


def _coast_down(top: float) -> Experiment:
    curves = {"speed_ref_rad_s": InputCurve((0.0,), (top,))}
    return Experiment("coast_down", "speed", 5.2, LOG_HZ, curves, current_from_s=COAST_FROM_S)


def _standstill_steps(current_a: float) -> Experiment:
    axis = [(part * current_a, STEP_S) for part in STEPS]
    still = [(0.0, STEP_S)] * len(STEPS)
    id_ref, end_s = _held(axis + still)
    iq_ref, _ = _held(still + axis)
    curves = {"id_ref_a": id_ref, "iq_ref_a": iq_ref}
    return Experiment("standstill_steps", "current", end_s, STEPS_HZ, curves, rotor_locked=True)


def _validation(top: float, load_nm: float) -> Experiment:
    """Speeds by chance, half of them reached on a ramp; loads by chance, at other times."""
    dice = np.random.default_rng(SEED)
    end_s, ramp_rad_s2 = 6.0, 6.5 * top
    t_s, value = [0.0], [float(dice.uniform(0.3, 1.0)) * top]
    at_s = 0.0
    while True:
        at_s += float(dice.uniform(0.45, 0.8))
        if at_s > end_s - 0.3:
            break
        speed = float(dice.uniform(-1.0, 1.0)) * top
        takes_s = abs(speed - value[-1]) / ramp_rad_s2 if dice.random() < 0.5 else 0.001
        t_s += [at_s, at_s + takes_s]
        value += [value[-1], speed]
        at_s += takes_s
    speed_ref = InputCurve(tuple(round(t, 3) for t in t_s), tuple(round(v, 6) for v in value), linear=True)
    loads, load_s = [], 0.0
    while load_s < end_s:
        seconds = round(float(dice.uniform(0.4, 0.9)), 3)
        loads.append((float(dice.uniform(-1.0, 1.0)) * load_nm, seconds))
        load_s += seconds
    load, _ = _held(loads)
    return Experiment("validation", "speed", end_s, LOG_HZ, {"speed_ref_rad_s": speed_ref, "load_torque_nm": load})


def _validation_steps(current_a: float) -> Experiment:
    dice = np.random.default_rng(SEED + 1)
    count = 20
    curves = {}
    for name in ("id_ref_a", "iq_ref_a"):
        values = dice.uniform(-STEPS_PART, STEPS_PART, count) * current_a
        curves[name], end_s = _held([(float(value), VALIDATION_STEP_S) for value in values])
    return Experiment("validation_steps", "current", end_s, STEPS_HZ, curves, rotor_locked=True)


# ---- the file


class _Curve(Strict):
    t_s: list[Annotated[Real, within(0.0, 1e5)]] = pydantic.Field(
        description="times in s that rise from 0", min_length=1
    )
    value: list[Annotated[Real, within(-1e6, 1e6)]] = pydantic.Field(
        description="as many numbers as t_s has", min_length=1
    )
    linear: bool = pydantic.Field(False, description="true or false")


class _Experiment(Strict):
    name: str = pydantic.Field(description="a name in quotes: letters, digits, _", pattern=r"^[A-Za-z0-9_]+$")
    mode: Literal["speed", "current"] = pydantic.Field(description='"speed" or "current"')
    duration_s: Annotated[Real, within(0.01, 3600.0)] = pydantic.Field(description="a number in 0.01 .. 3600 s")
    log_rate_hz: Annotated[Real, within(1.0, 10_000.0)] = pydantic.Field(description="10000 Hz over a whole number")
    rotor_locked: bool = pydantic.Field(False, description="true or false")
    current_from_s: Annotated[Real, within(0.0, 3600.0)] | None = pydantic.Field(None, description="a time in s")
    speed_ref_rad_s: _Curve | None = pydantic.Field(None, description="a table with t_s and value")
    id_ref_a: _Curve | None = pydantic.Field(None, description="a table with t_s and value")
    iq_ref_a: _Curve | None = pydantic.Field(None, description="a table with t_s and value")
    load_torque_nm: _Curve | None = pydantic.Field(None, description="a table with t_s and value")


class _List(Strict):
    name: str = pydantic.Field(description="a name in quotes")
    model: str = pydantic.Field(description="a built-in model or a file .toml, in quotes")
    experiment: list[_Experiment] = pydantic.Field(description="tables [[experiment]]", min_length=1)


def read_experiments(path: Path) -> ExperimentList:
    """Read and check a list."""
    document = read_document(path)
    found = check(_List, document)
    model = find_model(found.model, path.parent, lambda must, hint: document.error(("model",), must, hint))
    experiments = []
    for number, entry in enumerate(found.experiment):
        curves = {}
        for name in CURVES:
            curve = getattr(entry, name)
            if curve is None:
                continue
            keys = ("experiment", number, name)
            if len(curve.t_s) != len(curve.value):
                raise document.error((*keys, "value"), "as many numbers as t_s has", "give a value for each time")
            if any(later <= earlier for earlier, later in zip(curve.t_s, curve.t_s[1:], strict=False)):
                raise document.error((*keys, "t_s"), "times that rise", "sort them")
            curves[name] = InputCurve(tuple(curve.t_s), tuple(curve.value), curve.linear)
        experiments.append(
            Experiment(
                entry.name, entry.mode, entry.duration_s, entry.log_rate_hz, curves, entry.rotor_locked,
                entry.current_from_s,
            )
        )  # fmt: skip
    names = [experiment.name for experiment in experiments]
    for number, name in enumerate(names):
        if name in names[:number]:
            raise document.error(("experiment", number, "name"), "a name of its own", "rename it")
    return ExperimentList(found.name, found.model, load_machine(model), tuple(experiments))


def experiments_toml(name: str, model: str, experiments: tuple[Experiment, ...]) -> str:
    """The file of a list."""
    document = tomlkit.document()
    document.add(tomlkit.comment("Experiments for `evenspin bench run`. Times in s from the start of each record."))
    document["name"] = name
    document["model"] = model
    tables_ = tomlkit.aot()
    for experiment in experiments:
        tables_.append(_table(experiment))
    document["experiment"] = tables_
    return tomlkit.dumps(document)


def _table(experiment: Experiment) -> Any:
    table = tomlkit.table()
    table["name"] = experiment.name
    table["mode"] = experiment.mode
    table["duration_s"] = experiment.duration_s
    table["log_rate_hz"] = experiment.log_rate_hz
    if experiment.rotor_locked:
        table["rotor_locked"] = True
    if experiment.current_from_s is not None:
        table["current_from_s"] = experiment.current_from_s
    for name, curve in experiment.curves.items():
        inner = tomlkit.table()
        inner["t_s"] = list(curve.t_s)
        inner["value"] = list(curve.value)
        if curve.linear:
            inner["linear"] = True
        table[name] = inner
    return table
