"""The text of the files: model.toml (the machine), drive.toml (the drive for it), first.toml (a run to begin with)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import tomlkit

from evenspin.motor.resolve import Resolved
from evenspin.native import Field, tables

MODEL, DRIVE, FIRST = "model.toml", "drive.toml", "first.toml"
MEASURED = {"resistance_ohm": "rl", "psi_wb": "flux"}


def plain(field: Field, value: float) -> Any:
    """As TOML has it: a word of a choice, true or false, a whole number, or the shortest number of five digits."""
    if field.kind == "choice":
        return field.to_text(value)
    if field.kind == "flag":
        return bool(value)
    return int(value) if field.kind == "integer" else float(f"{value:.6g}")


def add(table: Any, field: Field, value: float, comment: str = "") -> None:
    """A line: name = value  # unit, comment."""
    item = tomlkit.item(plain(field, value))
    words = ", ".join(word for word in (field.unit, comment) if word)
    if words:
        item.comment(words)
    table[field.name] = item


def model_toml(
    name: str,
    numbers: Mapping[str, tuple[float, str]],
    ranges: Mapping[str, tuple[float, float]],
    head: Sequence[str],
    effects: Mapping[str, Mapping[str, float]] | None = None,
) -> str:
    """`numbers`: value and comment by the names of [plant]; `head`: lines at the top."""
    document = tomlkit.document()
    for line in head:
        document.add(tomlkit.comment(line))
    document["name"] = name
    document["drive_file"] = DRIVE
    plant = tomlkit.table()
    for key, (value, comment) in numbers.items():
        add(plant, tables().model[key], value, comment)
    document["plant"] = plant
    if ranges:
        table = tomlkit.table()
        for key, (low, high) in ranges.items():
            table[key] = [float(f"{low:.4g}"), float(f"{high:.4g}")]
            if not low <= numbers[key][0] <= high:
                table[key] = [low, high]
        document["range"] = table
    if effects:
        group = tomlkit.table(is_super_table=True)
        for effect, params in effects.items():
            table = tomlkit.table()
            for key, value in params.items():
                add(table, tables().effects[effect].params[key], value)
            group[effect] = table
        document["effects"] = group
    return tomlkit.dumps(document)


def drive_toml(values: Mapping[str, float], comments: Mapping[str, str], head: Sequence[str], schema: int) -> str:
    """A file that a model's drive_file and `bench config push` take. `schema`: of this firmware."""
    document = tomlkit.document()
    for line in head:
        document.add(tomlkit.comment(line))
    table = tomlkit.table()
    table["hash"] = f"{schema:08x}"
    document["schema"] = table
    drive = tomlkit.table()
    for key, field in tables().params.items():
        if key in values:
            add(drive, field, values[key], comments.get(key, ""))
    document["drive"] = drive
    return tomlkit.dumps(document)


def ranges_of(found: Resolved) -> dict[str, tuple[float, float]]:
    return {name: (each.low, each.high) for name, each in found.numbers.items() if each.low != each.high}


def first_toml(speed_rad_s: float, torque_nm: float) -> str:
    """Start, load step, reversal."""
    speed, torque = float(f"{speed_rad_s:.3g}"), float(f"{torque_nm:.3g}")
    return f"""\
# A run to begin with: start, load step, reversal. `evenspin run first.toml --out OUT`
name = "first"
model = "model.toml"
duration_s = 6.0
seed = 1
log_rate_hz = 2000.0

[drive]
auto_run = true # a simulation starts by itself, a drive on a bench does not
offset_calibration_periods = 0
align_periods = 0

[[event]]
at_s = 0.1
speed_rad_s = {speed}
ramp_s = 0.5

[[event]]
at_s = 2.0
load_brake_nm = {torque}

[[event]]
at_s = 3.0
load_brake_nm = 0.0

[[event]]
at_s = 4.0
speed_rad_s = {-speed}
ramp_s = 0.5
"""
