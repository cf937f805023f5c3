"""Model files: the plant, the drive that runs it, and the non-ideal effects.

name = "my drive"

[plant]                 # keys of docs/model.md
resistance_ohm = 0.36

[drive]                 # keys of docs/parameters.md
method = "fal-forc"

[effects.current_gain]  # keys of docs/effects.md
gain_a = 1.1
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pydantic

from evenspin.errors import InputError, did_you_mean
from evenspin.model.document import Document, read_document
from evenspin.model.schema import Strict, check, given_numbers, group_schema, table_schema
from evenspin.native import tables

DATA = Path(__file__).resolve().parents[1] / "data"

# The drive knows its motor unless the file says otherwise.
DRIVE_FROM_PLANT = {"pole_pairs": "pole_pairs", "encoder_counts": "counts_per_rev"}

Numbers = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Machine:
    """A model file. `plant` is complete; `drive` and `effects` have what differs from the defaults."""

    document: Document
    name: str
    plant: Numbers
    drive: Numbers
    effects: Mapping[str, Numbers]

    @property
    def torque_per_a_nm(self) -> float:
        """Torque constant 1.5 p psi, N m per A of q-axis current."""
        return 1.5 * self.plant["pole_pairs"] * self.plant["psi_wb"]


@functools.cache
def plant_schema() -> type[Strict]:
    return table_schema("Plant", tables().model)


@functools.cache
def drive_schema() -> type[Strict]:
    return table_schema("Drive", tables().params)


@functools.cache
def effects_schema() -> type[Strict]:
    members = {name: table_schema(name, effect.params) for name, effect in tables().effects.items()}
    return group_schema("Effects", members, "a table with the parameters of the effect")


@functools.cache
def machine_schema() -> type[Strict]:
    fields: dict[str, Any] = {
        "name": (str, pydantic.Field(description="the name of the model, in quotes")),
        "description": (str, pydantic.Field("", description="text in quotes")),
        "plant": (plant_schema() | None, pydantic.Field(None, description="a table [plant]")),
        "drive": (drive_schema() | None, pydantic.Field(None, description="a table [drive]")),
        "effects": (effects_schema() | None, pydantic.Field(None, description="tables [effects.NAME]")),
    }
    return pydantic.create_model("Machine", __base__=Strict, **fields)


def load_machine(path: Path) -> Machine:
    """Read and check a model file."""
    document = read_document(path)
    file: Any = check(machine_schema(), document)
    plant = {name: field.default for name, field in tables().model.items()} | given_numbers(file.plant, tables().model)
    drive = {name: plant[source] for name, source in DRIVE_FROM_PLANT.items() if plant[source] > 0}
    drive |= given_numbers(file.drive, tables().params)
    return Machine(document, file.name, plant, drive, effect_numbers(file.effects))


def effect_numbers(group: Any) -> dict[str, dict[str, float]]:
    """Parameters of the effects that a file names."""
    if group is None:
        return {}
    chosen = {name: getattr(group, name) for name in tables().effects}
    return {
        name: given_numbers(table, tables().effects[name].params) for name, table in chosen.items() if table is not None
    }


def builtin_models() -> dict[str, Path]:
    """Model files that come with the package, by name."""
    return {path.stem: path for path in sorted((DATA / "models").glob("*.toml"))}


def find_model(given: str, beside: Path, refuse: Callable[[str, str], InputError]) -> Path:
    """A file name relative to the folder `beside`, or the name of a built-in model."""
    known = builtin_models()
    if given in known:
        return known[given]
    if not given.endswith(".toml"):
        raise refuse("a file .toml or a built-in model", did_you_mean(given, known))
    if not (beside / given).is_file():
        raise refuse("an existing file or a built-in model", did_you_mean(given.removesuffix(".toml"), known))
    return beside / given
