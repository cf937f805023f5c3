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
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import pydantic
import tomlkit

from evenspin.errors import InputError
from evenspin.log.experiments import CURVES, Experiment
from evenspin.log.plan import Sizes, eight_experiments
from evenspin.model import InputCurve, Machine
from evenspin.model.document import read_document
from evenspin.model.machine import RATINGS, SIMULATED, find_model, load_machine
from evenspin.model.schema import Real, Strict, check, within
from evenspin.native import tables

TOP_PART = 0.22  # of the speed at which the back-EMF fills the dc link: the voltage limit stays out of the experiments
OVER_SPEED_PART = 0.7
LOAD_PART = 0.5  # of the rated torque
SEED = 2024  # of the random references: the same list for everybody


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
    return tuple(_rounded(each) for each in eight_experiments(Sizes(top_rad_s, load_nm, current_a), SEED))


def _rounded(experiment: Experiment) -> Experiment:
    """With values of six decimals, which a person can read."""
    curves = {
        name: replace(curve, value=tuple(round(value, 6) for value in curve.value))
        for name, curve in experiment.curves.items()
    }
    return replace(experiment, curves=curves)


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
