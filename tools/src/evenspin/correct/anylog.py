"""Corrections for what logs of any drive name.

Nobody has performed experiments there: those that the format plans for the model are simulated, with the machine that
was found, and are what `evenspin bench apply` will perform.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.correct.file import write_correction
from evenspin.correct.found import Found
from evenspin.correct.proposal import Proposal, propose
from evenspin.correct.rules import Rule, rule_of
from evenspin.errors import EvenspinError, InputError
from evenspin.gap import plan as planning
from evenspin.log.case import Case
from evenspin.log.meta_numbers import MetaNumbers
from evenspin.log.nominal import Nominal
from evenspin.model import Machine
from evenspin.model.machine import RATINGS, SIMULATED, find_model, load_machine
from evenspin.native import tables

GAINS = ("current_kp_v_per_a", "current_ki_v_per_as", "speed_kp_a_per_unit", "speed_ki_a_per_unit_s")


def write_for_log(folder: Path, verdict: Mapping[str, Any], model: str) -> tuple[Proposal | None, str]:
    """correction.toml for a verdict on logs, and why there is none where the model says too little of the drive."""
    named = [name for name in verdict["verdict"] if name in verdict["parameters"]]
    if not named:
        return None, ""
    undecided = [name for name in named if name not in tables().effects]
    if undecided:
        return None, f"No correction.toml: {', '.join(undecided)}: the logs do not say which, and each has another one."
    machine = load_machine(
        find_model(model, Path(), lambda must, hint: InputError("gap", "--model", model, must, hint)), ("pole_pairs",)
    )
    missing = [name for name in (*SIMULATED, *RATINGS) if name not in machine.plant_from]
    missing += [name for name in GAINS if name not in machine.drive]
    if missing or machine.effects:
        why = f"the model does not state {', '.join(missing)}" if missing else "the model has effects of its own"
        return None, f"No correction.toml: {why}."
    try:
        case, found = _performed(folder, machine, verdict, named)
        proposal = propose(case, str(verdict["case"]), verdict["verdict"], found)
    except EvenspinError as error:
        return None, f"No correction.toml: the experiments that would show it cannot be simulated: {error.bare}."
    without_log = tuple(replace(c, predicted=replace(c.predicted, log=math.nan)) for c in proposal.corrections)
    proposal = replace(proposal, corrections=without_log)
    write_correction(folder, proposal, case, found.nominal)
    return proposal, ""


def _performed(folder: Path, machine: Machine, verdict: Mapping[str, Any], named: list[str]) -> tuple[Case, Found]:
    effects: dict[str, dict[str, float]] = {}
    halves: dict[str, dict[str, float]] = {}
    for name in named:
        given, spans = verdict["parameters"][name], verdict["intervals"].get(name, {})
        fields = tables().effects[name].params
        effects[name] = {key: float(given.get(key, field.default)) for key, field in fields.items()}
        halves[name] = {key: 0.5 * (span["high"] - span["low"]) for key, span in spans.items()}
    experiments = planning.plan(machine)
    meta = planning.meta(experiments, str(verdict["case"]))
    found = Found(effects, halves, np.zeros(9), Nominal.of(MetaNumbers(folder / "meta.json", meta)))
    wanted: set[str] = set()
    for name in named:
        rule = rule_of(name)
        if isinstance(rule, Rule):
            wanted |= set(rule.spoils(found, [name]).records)
            wanted |= set(rule.beside(found, [name]).records) if rule.beside is not None else set()
    records = {}
    for experiment in experiments:
        if experiment.name in wanted:
            setup = replace(experiment.setup, effects=effects)
            records[experiment.name] = planning.perform(replace(experiment, setup=setup))
    return Case(folder, meta, records), found
