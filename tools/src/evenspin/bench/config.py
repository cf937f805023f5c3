"""Parameters of a drive as a file: pull, push, diff. TOML with the schema it belongs to; units stand beside the values.

    [schema]
    hash = "1a2b3c4d"
    version = 1

    [drive]
    pole_pairs = 4
    current_kp_v_per_a = 0.6    # V/A

A file of another firmware can be pushed as far as its names are known to the drive; ranges are the drive's own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from evenspin.bench.client import Drive
from evenspin.bench.messages import VERSION
from evenspin.errors import InputError, did_you_mean
from evenspin.model.document import Document, read_document
from evenspin.native import Field


@dataclass(frozen=True, slots=True)
class Difference:
    """A parameter whose value in the file is not that of the drive."""

    field: Field
    file: float
    drive: float


def config_toml(drive: Drive) -> str:
    """The file that `pull` writes."""
    document = tomlkit.document()
    document.add(tomlkit.comment("Parameters of a drive. `evenspin bench config push` writes them back."))
    schema = tomlkit.table()
    schema["hash"] = f"{drive.info.schema:08x}"
    schema["version"] = VERSION
    schema["name"] = drive.info.name
    schema["firmware"] = drive.info.firmware
    document["schema"] = schema
    table = tomlkit.table()
    for name, value in drive.get().items():
        parameter = drive.parameters[name]
        item = tomlkit.item(_to_toml(parameter, value))
        if parameter.unit:
            item.comment(parameter.unit)
        table[name] = item
    document["drive"] = table
    return tomlkit.dumps(document)


def read_config(path: Path, drive: Drive) -> dict[str, float]:
    """The values of a file, checked against the ranges of this drive."""
    document = read_document(path)
    table = document.data.get("drive")
    if not isinstance(table, dict) or not table:
        raise document.error(("drive",), "a table [drive] with parameters", "`evenspin bench config pull` writes one")
    return {name: _number(document, drive, name, value) for name, value in table.items()}


def same_schema(path: Path, drive: Drive) -> bool:
    """Whether the file was pulled from a drive with the same lists."""
    schema = read_document(path).data.get("schema")
    return isinstance(schema, dict) and schema.get("hash") == f"{drive.info.schema:08x}"


def differences(values: Mapping[str, float], drive: Drive) -> list[Difference]:
    """Compared in single precision, in which the drive holds them."""
    held = drive.get()
    return [
        Difference(drive.parameters[name], value, held[name])
        for name, value in values.items()
        if np.float32(value) != np.float32(held[name])
    ]


def _to_toml(field: Field, value: float) -> Any:
    if field.kind == "choice":
        return field.to_text(value)
    if field.kind == "flag":
        return bool(value)
    return int(value) if field.kind == "integer" else shortest(value)


def shortest(value: float) -> float:
    """The shortest number that is the same in single precision: 0.6, not 0.6000000238."""
    return float(str(np.float32(value)))


def _number(document: Document, drive: Drive, name: str, value: object) -> float:
    keys = ("drive", name)
    if name not in drive.parameters:
        raise document.error(keys, "a parameter of this drive", did_you_mean(name, drive.parameters))
    field = drive.parameters[name]
    hint = "correct the value"
    if field.kind == "choice":
        if value not in field.choices:
            raise document.error(keys, field.allowed(), hint)
        return float(field.choices.index(str(value)))
    if field.kind == "flag":
        if not isinstance(value, bool):
            raise document.error(keys, field.allowed(), hint)
        return float(value)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise document.error(keys, field.allowed(), hint)
    if not np.float32(field.minimum) <= np.float32(value) <= np.float32(field.maximum):
        raise document.error(keys, field.allowed(), hint)
    if field.kind == "integer" and value != int(value):
        raise document.error(keys, field.allowed(), hint)
    return float(value)


def diff_error(path: Path) -> InputError:
    return InputError(path, "schema", "another firmware", "of this drive's firmware", "pull again, or give --force")
