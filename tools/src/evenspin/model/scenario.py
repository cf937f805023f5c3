"""Scenario files: what happens to a drive, when.

name = "load step"
model = "guo2024"       # a built-in model, or a file relative to this one
duration_s = 4.0
seed = 1
log_rate_hz = 2000.0

[drive]                 # on top of the model's
method = "forc"

[effects.current_offset]
offset_a_a = 0.2

[[event]]
at_s = 0.0
speed_rpm = 150.0       # or speed_rad_s; ramp_s: how long it takes to get there. Or control = "position" and
                        # position_ref_turn or position_ref_rad (target of the motion profile); home = 1 finds the index
load_brake_a = 1.0      # A of q-axis current, or load_brake_nm; load_torque_nm, load_torque_a push in either direction

[[event]]
at_s = 2.0
load_brake_a = 2.5      # what holds from now on, not an increment
load_rise_s = 0.03      # time constant with which the load gets there; a step without it
drive = { rc_gain = 0.5 }
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from evenspin.errors import EvenspinError, InputError, NativeError, did_you_mean
from evenspin.model.changes import NO_CHANGES, Changes
from evenspin.model.document import Document, document_of, read_document
from evenspin.model.machine import (
    DATA,
    SIMULATED,
    Machine,
    check_supply,
    effect_numbers,
    find_model,
    machine_from,
)
from evenspin.model.scenario_schema import (
    CONTROL,
    CONTROL_MODE,
    LOADS,
    SPEED,
    TURN,
    EventKey,
    event_keys,
    scenario_schema,
)
from evenspin.model.schema import check, given_numbers
from evenspin.model.setup import InputCurve, Setup, Tune
from evenspin.native import RefusedValueError, tables

MAX_ROWS = 4_000_000
STEP_S = 1e-9  # a step between straight lines takes this long: far less than a PWM period
RISE = tuple(k / 10.0 for k in range(1, 101))  # a rise 1 - exp(-t/T) as straight lines between these t/T: 0.1 % off


@dataclass(frozen=True, slots=True)
class Step:
    """A change of an input: at once, over `ramp_s`, or with the time constant `rise_s`."""

    at_s: float
    value: float
    ramp_s: float = 0.0
    rise_s: float = 0.0

    def course(self, level: float) -> list[tuple[float, float]]:
        """Points after the start, coming from `level`."""
        if not self.rise_s > 0.0:
            return [(self.at_s + self.ramp_s, self.value)]
        shares = [(t, 1.0 - math.exp(-t)) for t in RISE[:-1]] + [(RISE[-1], 1.0)]
        return [(self.at_s + t * self.rise_s, level + share * (self.value - level)) for t, share in shares]


@dataclass(frozen=True, slots=True)
class Scenario:
    """A scenario file with its model, and what it comes to."""

    document: Document
    machine: Machine
    setup: Setup

    def with_changes(self, drive: Mapping[str, float | str] | None = None, seed: int | None = None) -> Setup:
        """This run with other drive parameters, words or numbers, or another seed."""
        given = {name: _number_of(name, value) for name, value in (drive or {}).items()}
        given_here = dict.fromkeys(given, "given for this run")
        setup = self.setup
        setup = replace(setup, drive={**setup.drive, **given}, drive_from={**setup.drive_from, **given_here})
        return setup if seed is None else replace(setup, seed=seed)

    def locate(self, error: NativeError) -> EvenspinError:
        """Where in the files is what the library refused?"""
        if not isinstance(error, RefusedValueError):
            return error
        refusal = error.refusal
        path = (refusal.other, refusal.name) if refusal.list == "effect_param" else (refusal.name,)
        for document in (self.document, self.machine.document):
            for keys in sorted(document.lines, key=document.line_of):
                if tuple(keys[-len(path) :]) == path:
                    must = refusal.must or f"another value ({refusal.reason})"
                    return document.error(keys, must, "correct the value")
        return error


def _number_of(name: str, value: float | str) -> float:
    """A parameter as the library takes it."""
    if name not in tables().params:
        raise InputError("drive", name, value, "a parameter of the drive", did_you_mean(name, tables().params))
    field = tables().params[name]
    if isinstance(value, str) and value not in field.choices:
        raise InputError("drive", name, value, field.allowed(), "correct the value")
    return field.to_number(value)


# ---- reading -------------------------------------------------------------------------------------------------------


def load_scenario(path: Path, changes: Changes = NO_CHANGES) -> Scenario:
    """Read and check a scenario file and its model. `changes`: as if they stood in the files."""
    return scenario_from(read_document(path), changes)


def scenario_from(document: Document, changes: Changes = NO_CHANGES) -> Scenario:
    """From what a scenario file holds. In one that stands in no file `model` may be a table: a model by itself."""
    try:
        return _scenario_from(changes.of_scenario(document), changes)
    except InputError as error:
        raise changes.located(error) from None


def _scenario_from(document: Document, changes: Changes) -> Scenario:
    document, machine = _with_machine(document, changes)
    file: Any = check(scenario_schema(), document)
    events = _ordered_events(document, file)
    _check_rate(document, file, machine)
    drive = {name: field.default for name, field in tables().params.items()} | dict(machine.drive)
    effects = {name: dict(params) for name, params in machine.effects.items()}
    for name, params in effect_numbers(file.effects).items():
        effects[name] = effects.get(name, {}) | params
    stated = given_numbers(file.drive, tables().params)
    drive |= stated
    check_supply(machine, {**machine.drive, **stated})
    _check_target(document, events, drive)
    setup = Setup(
        name=file.name,
        plant=machine.plant,
        drive=drive,
        effects=effects,
        inputs=_inputs(document, events, machine),
        tunes=_tunes(document, events),
        duration_s=file.duration_s,
        log_rate_hz=file.log_rate_hz,
        seed=file.seed,
        drive_from={**machine.drive_from, **dict.fromkeys(stated, "[drive] of the scenario")},
        base=machine.base,
    )
    return Scenario(document, machine, setup)


def _with_machine(document: Document, changes: Changes) -> tuple[Document, Machine]:
    """The model that a scenario names, or holds."""
    given, beside = document.data.get("model"), document.path.parent
    if isinstance(given, Mapping) and not document.lines:
        own = document_of({"name": "own"} | dict(given), "model", beside)
        named = Document(document.path, {**document.data, "model": str(own.data["name"])}, {})
        return named, machine_from(changes.of_model(own), SIMULATED)
    file: Any = check(scenario_schema(), document)
    path = find_model(file.model, beside, lambda must, hint: document.error(["model"], must, hint))
    return document, machine_from(changes.of_model(read_document(path)), SIMULATED)


def builtin_scenarios() -> dict[str, Path]:
    """Scenario files that come with the package, as FOLDER/NAME."""
    found = (path for path in sorted(DATA.glob("*/*.toml")) if path.parent.name != "models")
    return {f"{path.parent.name}/{path.stem}": path for path in found}


def builtin_scenario(name: str) -> Scenario:
    return scenario_from(_builtin_document(name))


def scenario_document(name: str) -> Document:
    """What stands in a scenario file, or in one that comes with the package."""
    if Path(name).exists() or Path(name).suffix:
        return read_document(Path(name))
    return _builtin_document(name)


def _builtin_document(name: str) -> Document:
    known = builtin_scenarios()
    if name not in known:
        raise InputError("SCENARIO", "name", name, "a file .toml or a built-in scenario", did_you_mean(name, known))
    return read_document(known[name])


def _ordered_events(document: Document, file: Any) -> list[tuple[int, Any]]:
    """Events with their position in the file, each later than the one before."""
    events = list(enumerate(file.event))
    last_s = -1.0
    for index, event in events:
        keys: list[str | int] = ["event", index, "at_s"]
        if event.at_s <= last_s:
            raise document.error(keys, f"later than the event before ({last_s:g} s)", "order the events by time")
        if event.at_s + (event.ramp_s or 0.0) >= file.duration_s:
            must = f"over before duration_s ({file.duration_s:g} s)"
            raise document.error(keys, must, "correct it or duration_s")
        last_s = event.at_s
    return events


def _check_rate(document: Document, file: Any, machine: Machine) -> None:
    pwm_hz = machine.plant["pwm_hz"]
    ratio = pwm_hz / file.log_rate_hz
    if ratio < 0.999 or abs(ratio - round(ratio)) > 1e-6 * ratio:
        nearest = pwm_hz / max(1, round(ratio))
        must = f"pwm_hz ({pwm_hz:g} Hz) divided by a whole number"
        raise document.error(["log_rate_hz"], must, f"nearest: {nearest:.10g}")
    if file.duration_s * file.log_rate_hz > MAX_ROWS:
        must = f"low enough for {MAX_ROWS} rows in duration_s"
        raise document.error(["log_rate_hz"], must, f"at most {MAX_ROWS / file.duration_s:g}")


def _inputs(document: Document, events: list[tuple[int, Any]], machine: Machine) -> dict[str, InputCurve]:
    """Inputs over time: every key that some event gives."""
    steps: dict[str, list[Step]] = {}
    for index, event in events:
        seen: dict[str, str] = {}
        for name, key in event_keys().items():
            value = getattr(event, name)
            if value is None:
                continue
            if key.input in seen:
                raise document.error(["event", index, name], f"given without {seen[key.input]}", "keep one of the two")
            seen[key.input] = name
            _check_input(document, ["event", index, name], key, value, machine)
            ramp_s = event.ramp_s or 0.0 if key.input == SPEED else 0.0
            rise_s = event.load_rise_s or 0.0 if key.input in LOADS else 0.0
            step = Step(event.at_s, value * key.scale(machine), ramp_s, rise_s)
            steps.setdefault(key.input, []).append(step)
        if event.ramp_s is not None and SPEED not in seen:
            raise document.error(["event", index, "ramp_s"], "beside speed_rpm or speed_rad_s", "move it or remove it")
        if event.load_rise_s is not None and not seen.keys() & LOADS:
            raise document.error(["event", index, "load_rise_s"], "beside a load", "move it or remove it")
        if event.control is not None:
            steps.setdefault(CONTROL_MODE, []).append(Step(event.at_s, CONTROL[event.control]))
    # An input that is a field of the plant, too, starts from there.
    return {name: _curve(machine.plant.get(name, tables().inputs[name].default), each) for name, each in steps.items()}


def _check_input(document: Document, keys: list[str | int], key: EventKey, value: float, machine: Machine) -> None:
    field, scale = tables().inputs[key.input], key.scale(machine)
    if not field.minimum <= value * scale <= field.maximum:
        low, high = (limit / scale if scale else 0.0 for limit in (field.minimum, field.maximum))
        raise document.error(keys, f"a number in {low:g} .. {high:g} {key.unit}".rstrip(), "correct the value")


def _check_target(document: Document, events: list[tuple[int, Any]], drive: Mapping[str, float]) -> None:
    """A target of position mode beyond the soft limits of the drive."""
    low, high = drive["position_min_turn"], drive["position_max_turn"]
    for index, event in events:
        for name, unit in (("position_ref_turn", 1.0), ("position_ref_rad", TURN)):
            value = getattr(event, name)
            if value is not None and not low * unit <= value <= high * unit:
                must = f"within the soft limits {low * unit:g} .. {high * unit:g} {name.rpartition('_')[2]}"
                hint = "correct it, or position_min_turn and position_max_turn"
                raise document.error(["event", index, name], must, hint)


def _curve(before: float, steps: list[Step]) -> InputCurve:
    """Steps as points, after the value `before`."""
    if not any(step.ramp_s > 0.0 or step.rise_s > 0.0 for step in steps):
        points = [(step.at_s, step.value) for step in steps]
        points = points if points[0][0] == 0.0 else [(0.0, before), *points]
        return InputCurve(tuple(t for t, _ in points), tuple(v for _, v in points))
    points = [(0.0, before)]
    for step in steps:
        start_s = step.at_s if step.ramp_s > 0.0 or step.rise_s > 0.0 else step.at_s - STEP_S
        level = _interpolate(points, start_s)
        points = [point for point in points if point[0] < start_s]
        points += [(start_s, level)] if start_s >= 0.0 else []
        points += step.course(level)
    rises = any(step.rise_s > 0.0 for step in steps)
    at_s = tuple(time_s for step in steps for time_s in (step.at_s, step.at_s + step.ramp_s)) if rises else None
    return InputCurve(tuple(t for t, _ in points), tuple(v for _, v in points), linear=True, at_s=at_s)


def _interpolate(points: list[tuple[float, float]], t_s: float) -> float:
    for (t0, v0), (t1, v1) in itertools.pairwise(points):
        if t0 <= t_s < t1:
            return v0 + (v1 - v0) * (t_s - t0) / (t1 - t0)
    return points[-1][1]


def _tunes(document: Document, events: list[tuple[int, Any]]) -> tuple[Tune, ...]:
    for index, event in events:
        for name in given_numbers(event.drive, tables().params):
            if tables().params[name].at_rest:
                must = "a parameter that changes while the drive runs"
                keys: list[str | int] = ["event", index, "drive", name]
                raise document.error(keys, must, "it changes at rest only: set it in [drive]")
    return tuple(
        Tune(event.at_s, name, value)
        for _, event in events
        for name, value in given_numbers(event.drive, tables().params).items()
    )
