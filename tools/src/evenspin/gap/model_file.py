"""model.toml: the machine with what was found, and scenario.toml, which runs it: `evenspin run DIR/scenario.toml`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.log.case import Case
from evenspin.log.nominal import Nominal
from evenspin.log.tolerance import TOLERANCES
from evenspin.log.unit import Unit
from evenspin.native import Field, tables

MODEL, SCENARIO = "model.toml", "scenario.toml"
RUN_S = 1.0  # at each speed of the scenario
SPEEDS = (0.1, 0.4, 1.0)  # of the fastest reference in the log


def write_model(
    folder: Path,
    case: Case,
    nominal: Nominal,
    effects: Mapping[str, Mapping[str, float]],
    delta: np.ndarray[Any, np.dtype[np.float64]],
    unit: Unit,
    notes: list[str],
) -> None:
    """`effects` and `delta` are what `unit` is made of; they say what is named and what is tolerance."""
    name = str(case.meta.get("case", case.path.name))
    lines = [f"# {note}" for note in notes]
    lines += [f"name = {_quoted(name + '-found')}", 'description = "nominal machine with what its log showed"', ""]
    lines += ["[plant]", *_plant(nominal, unit, delta), "", "[drive]", *_table(nominal.drive, tables().params)]
    for effect, params in unit.effects.items():
        added = f"added: {tables().effects[effect].signature}"
        about = added if effect in effects else "residual error of a healthy unit"
        if effect in effects and any(t.sensor and t.sensor[0] == effect for t in TOLERANCES):
            about += "; with the residual error of a healthy unit"
        lines += ["", f"[effects.{effect}] # {about}", *_table(params, tables().effects[effect].params)]
    (folder / MODEL).write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / SCENARIO).write_text(_scenario(name, case), encoding="utf-8")


def _plant(nominal: Nominal, unit: Unit, delta: Any) -> list[str]:
    numbers = {
        **nominal.machine,
        **nominal.supply,
        "counts_per_rev": nominal.counts_per_rev,
        "current_noise_a": nominal.current_noise_a,
    }
    fields = tables().model
    sigma = {key: t.sigma for t in TOLERANCES for key in t.factors}
    lines = []
    for key, value in numbers.items():
        factor = unit.factors.get(key, 1.0)
        comment = ""
        if factor != 1.0:
            deviations = abs(factor - 1.0) / sigma[key]
            comment = f" # {value:.6g} times {factor:.5f}: {deviations:.1f} of the tolerance's standard deviation"
        lines.append(f"{key} = {_number(value * factor, fields[key])}{comment}")
    return lines


def _table(values: Mapping[str, float], fields: Mapping[str, Field]) -> list[str]:
    return [f"{key} = {_number(value, fields[key])}" for key, value in values.items()]


def _number(value: float, field: Field) -> str:
    if field.kind == "choice":
        return _quoted(field.to_text(value))
    if field.kind == "flag":
        return field.to_text(value)
    if field.kind == "integer":
        return str(round(value))
    text = f"{value:.9g}"
    return text if any(c in text for c in ".en") else f"{text}.0"


def _quoted(text: str) -> str:
    plain = "".join(c if c.isprintable() and c not in '"\\' else "_" for c in text)
    return f'"{plain}"'


def _scenario(name: str, case: Case) -> str:
    motor = case.meta["motor"]
    refs = [float(np.max(np.abs(record["speed_ref_rad_s"]))) for record in case.experiments.values()]
    top = max([w for w in refs if math.isfinite(w)], default=0.0) or 10.0
    lines = [
        f"name = {_quoted(name + '-found')}",
        f'model = "{MODEL}"',
        f"duration_s = {RUN_S * (len(SPEEDS) + 1):g}",
        "seed = 1",
        "log_rate_hz = 2000.0",
    ]
    for i, share in enumerate(SPEEDS):
        lines += ["", "[[event]]", f"at_s = {RUN_S * i:g}", f"speed_rad_s = {share * top:.6g}"]
    load = 0.5 * float(motor.get("rated_torque_nm", 0.0))
    lines += ["", "[[event]]", f"at_s = {RUN_S * len(SPEEDS):g}", f"load_brake_nm = {load:.6g}"]
    return "\n".join(lines) + "\n"
