"""The experiments that make every effect identifiable, for any machine, and how the virtual drive performs them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from evenspin.errors import NativeError
from evenspin.gap.thresholds_records import TOP_VOLTAGE_SHARE
from evenspin.log import LOG_COLUMNS, meta_of
from evenspin.log.controller import FORMAT_CONTROLLER, format_controller
from evenspin.log.experiments import LOG_HZ, VALIDATION
from evenspin.log.experiments import Experiment as Commanded
from evenspin.log.plan import RPM, Sizes, eight_experiments
from evenspin.model import InputCurve, Machine, Setup
from evenspin.model.machine import RATINGS, SIMULATED
from evenspin.native import tables
from evenspin.sim import Record, simulate

TOP_RPM = 600.0  # of the format; slower where the dc link does not allow it
START_RAD = 0.4  # arbitrary
OTHER_ANGLE_RAD = 2.0  # from there, for the validation with a locked rotor
NOISE_SHARE, LSB_SHARE = 0.003, 0.002  # of the rated current, where the model has none: a real log has both
QUIET_START = {"offset_calibration_periods": 0.0, "align_periods": 0.0, "auto_run": 1.0}
LOAD, MODE = "load_torque_nm", "control_mode"


@dataclass(frozen=True, slots=True)
class Experiment:
    """One of the eight as the virtual drive performs it."""

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
    plant = machine.plant
    sizes = Sizes(top_speed(machine), 0.5 * plant["rated_torque_nm"], plant["rated_current_a"])
    base = _base(machine, seed)
    return [Experiment(e.name, e.what, _setup(base, e), e.needs_load_machine) for e in eight_experiments(sizes, seed)]


def top_speed(machine: Machine) -> float:
    """rad/s: 600 r/min, or less where the back-EMF would fill the dc link."""
    plant = machine.plant
    allowed = TOP_VOLTAGE_SHARE * plant["dc_link_v"] / math.sqrt(3.0) / (plant["pole_pairs"] * plant["psi_wb"])
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
    """Parameters of the model that the plan changes."""
    params = tables().params
    given = {name: params[name].to_text(machine.drive.get(name, params[name].default)) for name in FORMAT_CONTROLLER}
    changed = {
        name: f"{old} -> {FORMAT_CONTROLLER[name]}" for name, old in given.items() if old != FORMAT_CONTROLLER[name]
    }
    return changed | {name: f"0 -> {value:g}" for name, value in _noise(machine).items()}


def _noise(machine: Machine) -> dict[str, float]:
    """What a current measurement has and this model has not."""
    shares = {"current_noise_a": NOISE_SHARE, "current_lsb_a": LSB_SHARE}
    rated_a = machine.plant["rated_current_a"]
    return {name: share * rated_a for name, share in shares.items() if not machine.plant[name] > 0.0}


def _base(machine: Machine, seed: int) -> Setup:
    drive = {name: field.default for name, field in tables().params.items()} | dict(machine.drive) | QUIET_START
    drive |= format_controller()
    plant = {**machine.plant, **_noise(machine), "initial_angle_rad": START_RAD}
    return Setup(machine.name, plant, drive, machine.effects, {}, (), 1.0, LOG_HZ, seed)


def _setup(base: Setup, experiment: Commanded) -> Setup:
    inputs = dict(experiment.curves)
    if experiment.rotor_locked:
        inputs[MODE] = InputCurve((0.0,), (0.0,), False)
    elif experiment.current_from_s is not None:
        inputs[MODE] = InputCurve((0.0, experiment.current_from_s), (1.0, 0.0), False)
    plant = dict(base.plant)
    if experiment.rotor_locked:
        plant["rotor_locked"] = 1.0
        plant["initial_angle_rad"] += OTHER_ANGLE_RAD if experiment.name in VALIDATION else 0.0
    return replace(
        base,
        name=experiment.name,
        plant=plant,
        inputs=inputs,
        duration_s=experiment.duration_s,
        log_rate_hz=experiment.log_rate_hz,
    )
