"""Model files: the plant, the drive that runs it, and the non-ideal effects.

name = "my drive"

[plant]                 # keys of docs/model.md
resistance_ohm = 0.36

[drive]                 # keys of docs/parameters.md
method = "fal-forc"

[effects.current_gain]  # keys of docs/effects.md
gain_a = 1.1

The numbers of MOTOR must be there, those of SIMULATED for a simulation. `base = "guo2024"` at the top takes what
[plant] does not state from the [plant] of a built-in model, and nothing else. What is left has a neutral value: no
noise, no load, slots and ratings not known. The drive gets the motor data of [plant] (DRIVE_FROM_PLANT) unless
[drive] states them. `drive_file = "drive.toml"` at the top (relative to the model) takes a table [drive] from another
file, such as `evenspin tune` writes; [drive] of the model comes on top of it. [range] says between which limits a
number of [plant] is known, as in `inertia_kgm2 = [4e-5, 6e-5]`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import pydantic

from evenspin.errors import InputError, did_you_mean
from evenspin.model.document import Document, read_document
from evenspin.model.schema import Real, Strict, check, given_numbers, group_schema, table_schema
from evenspin.native import tables

DATA = Path(__file__).resolve().parents[1] / "data"

# The drive knows its motor unless the file sets other values.
DRIVE_FROM_PLANT = {
    "pole_pairs": "pole_pairs",
    "encoder_counts": "counts_per_rev",
    "motor_resistance_ohm": "resistance_ohm",
    "motor_ld_h": "ld_h",
    "motor_lq_h": "lq_h",
    "motor_psi_wb": "psi_wb",
    "observer_inertia_kgm2": "inertia_kgm2",
    "observer_viscous_nms": "viscous_nms",
    "rdc_inertia_kgm2": "inertia_kgm2",
    "rdc_viscous_nms": "viscous_nms",
}
# Numbers that have no neutral value: another machine's would be silently wrong.
TORQUE_ALONE = ("pole_pairs", "psi_wb", "viscous_nms")  # where a log gives the inertia itself
MOTOR = ("pole_pairs", "resistance_ohm", "ld_h", "lq_h", "psi_wb", "inertia_kgm2", "viscous_nms")
SIMULATED = (*MOTOR, "dc_link_v", "counts_per_rev")
RATINGS = ("rated_current_a", "rated_torque_nm")
UNKNOWN = (*RATINGS, "slots")  # 0: not known
DRIVE_TABLE = "[drive] of the model"
DRIVE_FILE = "[drive] of its drive_file"
DEFAULT_ORIGIN = "default, of another motor"

Numbers = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Machine:
    """A model file. `plant` is complete; `drive` and `effects` have what differs from the defaults.

    `plant_from` and `drive_from` say for each number that the file or its base states where it stands.
    """

    document: Document
    name: str
    plant: Numbers
    drive: Numbers
    effects: Mapping[str, Numbers]
    base: str = ""
    plant_from: Mapping[str, str] = field(default_factory=dict)
    drive_from: Mapping[str, str] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # of [plant]: between what it is known

    @property
    def torque_per_a_nm(self) -> float:
        """Torque constant 1.5 p psi, N m per A of q-axis current."""
        return 1.5 * self.plant["pole_pairs"] * self.plant["psi_wb"]

    def calculated_with(self, names: Sequence[str], given: Mapping[str, str] | None = None) -> str:
        """One line: numbers of [plant] and [drive] with where each comes from; `given`: the option that replaced it."""
        parts = []
        for name in names:
            of_plant = name in self.plant
            fields, known = (tables().model, self.plant_from) if of_plant else (tables().params, self.drive_from)
            value = self.plant[name] if of_plant else self.drive.get(name, fields[name].default)
            unit = f" {fields[name].unit}" if fields[name].unit else ""
            number = f"{name} = {value:.6g}{unit}"
            if given and name in given:
                parts.append(f"{name}: {given[name]}")
            elif name in known:
                parts.append(f"{number} ({known[name]})")
            else:
                parts.append(f"{number} ({'0, not given' if of_plant else DEFAULT_ORIGIN})")
        return f"Calculated with {'; '.join(parts)}."

    def need(self, names: Sequence[str]) -> None:
        """Refuse a model that leaves any of these numbers open, naming all that are missing."""
        missing = [name for name in names if name not in self.plant_from]
        given = f"{len(names) - len(missing)} of {len(names)} numbers"
        if missing:
            hint = 'give them in [plant], or base = "guo2024" at the top to take the others from that one'
            must = f"complete: {', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing"
            line = self.document.line_of(["plant"])
            raise InputError(self.document.path, "plant", given, must, hint, line)


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
def range_schema() -> type[Strict]:
    pair = Annotated[list[Real], pydantic.Field(min_length=2, max_length=2)]
    members: dict[str, Any] = {
        name: (pair | None, pydantic.Field(None, description="two numbers, as in [4e-5, 6e-5]"))
        for name in tables().model
    }
    return pydantic.create_model("Range", __base__=Strict, **members)


@functools.cache
def drive_file_schema() -> type[Strict]:
    """A file with parameters of a drive: what `bench config pull`, `tune` and `commission` write."""
    fields: dict[str, Any] = {"drive": (drive_schema(), pydantic.Field(description="a table [drive]"))}
    return pydantic.create_model(
        "DriveFile", __config__=pydantic.ConfigDict(extra="ignore", strict=True, frozen=True), **fields
    )


@functools.cache
def machine_schema() -> type[Strict]:
    fields: dict[str, Any] = {
        "name": (str, pydantic.Field(description="the name of the model, in quotes")),
        "description": (str, pydantic.Field("", description="text in quotes")),
        "base": (str, pydantic.Field("", description="the name of a built-in model, in quotes")),
        "drive_file": (str, pydantic.Field("", description="the name of a file with a table [drive], in quotes")),
        "range": (range_schema() | None, pydantic.Field(None, description="a table [range]")),
        "plant": (plant_schema() | None, pydantic.Field(None, description="a table [plant]")),
        "drive": (drive_schema() | None, pydantic.Field(None, description="a table [drive]")),
        "effects": (effects_schema() | None, pydantic.Field(None, description="tables [effects.NAME]")),
    }
    return pydantic.create_model("Machine", __base__=Strict, **fields)


def load_machine(path: Path, needs: Sequence[str] = MOTOR) -> Machine:
    """Read and check a model file; `needs`: numbers of [plant] that it or its base must state."""
    return machine_from(read_document(path), needs)


def machine_from(document: Document, needs: Sequence[str] = MOTOR) -> Machine:
    """From what a model file holds."""
    file: Any = check(machine_schema(), document)
    given = given_numbers(file.plant, tables().model)
    base = _base_plant(document, file.base)
    plant = {name: 0.0 if name in UNKNOWN else field.default for name, field in tables().model.items()} | base | given
    plant_from = {name: f"[plant] {name} of the base {file.base}" for name in base}
    plant_from |= {name: f"[plant] {name} of the model" for name in given}
    drive, drive_from = {}, {}
    for name, source in DRIVE_FROM_PLANT.items():
        limits = tables().params[name]
        if source in plant_from and plant[source] > 0 and limits.minimum <= plant[source] <= limits.maximum:
            drive[name], drive_from[name] = plant[source], plant_from[source]
    stated = given_numbers(file.drive, tables().params)
    for numbers, origin in ((_drive_file(document, file.drive_file), DRIVE_FILE), (stated, DRIVE_TABLE)):
        drive |= numbers
        drive_from |= dict.fromkeys(numbers, origin)
    ranges = _ranges(document, file.range, plant)
    effects = effect_numbers(file.effects)
    machine = Machine(document, file.name, plant, drive, effects, file.base, plant_from, drive_from, ranges)
    machine.need(needs)
    return machine


def _drive_file(document: Document, name: str) -> dict[str, float]:
    """[drive] of the file that a model names."""
    if not name:
        return {}
    path = document.path.parent / name
    if not path.is_file():
        raise document.error(["drive_file"], "an existing file", "`evenspin tune MODEL --out FILE` writes one")
    return drive_numbers(path)


def drive_numbers(path: Path) -> dict[str, float]:
    """[drive] of a file with parameters of a drive."""
    file: Any = check(drive_file_schema(), read_document(path))
    return given_numbers(file.drive, tables().params)


def _ranges(document: Document, table: Any, plant: Numbers) -> dict[str, tuple[float, float]]:
    """Each range holds the number that it belongs to."""
    found = {}
    for name, pair in ({} if table is None else table.model_dump(exclude_none=True)).items():
        low, high = pair
        if not low <= plant[name] <= high:
            must = f"two numbers with [plant] {name} = {plant[name]:g} between them"
            raise document.error(["range", name], must, "correct one of the two")
        found[name] = (low, high)
    return found


def _base_plant(document: Document, base: str) -> dict[str, float]:
    """[plant] of the model that this one stands on."""
    known = builtin_models()
    if not base:
        return {}
    if base not in known:
        raise document.error(["base"], "a built-in model", did_you_mean(base, known))
    other: Any = check(machine_schema(), read_document(known[base]))
    return given_numbers(other.plant, tables().model)


def check_supply(machine: Machine, drive: Numbers) -> None:
    """Refuse a drive that must trip on its own supply at once; `drive`: what was given to it."""
    for limit, beyond in (("over_voltage_v", float.__gt__), ("under_voltage_v", float.__lt__)):
        value = float(drive.get(limit, tables().params[limit].default))
        supply = float(machine.plant["dc_link_v"])
        if beyond(supply, value):
            bound = "at least" if limit == "over_voltage_v" else "at most"
            of = "the default" if limit not in drive else "given"
            must = f"{bound} dc_link_v ({supply:g} V), or the drive trips at once"
            hint = f"give {limit} in [drive]"
            line = machine.document.line_of(["drive", limit])
            raise InputError(machine.document.path, f"drive.{limit}", f"{value:g} V ({of})", must, hint, line)


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
