"""MAP.toml: which column is what, in which unit, and why; written from a guess, corrected by a person, read again."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping as MappingType
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import tomlkit

from evenspin.errors import EvenspinError, InputError, did_you_mean, one_line
from evenspin.importer.names import QUANTITIES
from evenspin.importer.units import UNITS, unit_of

HINT = "docs/import.md describes MAP.toml"
MOST_POLE_PAIRS = 200


@dataclass(frozen=True, slots=True)
class ColumnMap:
    """Value in SI = (number in the file + offset) * scale * unit."""

    source: str
    unit: str
    scale: float = 1.0
    offset: float = 0.0
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Mapping:
    """`columns`: quantity of QUANTITIES to where it comes from. `questions`: what a person has to decide first."""

    columns: MappingType[str, ColumnMap]
    rate_hz: float | None = None
    pole_pairs: int | None = None
    counts_per_turn: float | None = None
    electrical_zero_rad: float | None = None  # of p * theta_m, for phase quantities; None: from the data
    power_invariant: bool = False
    ignored: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    questions: tuple[str, ...] = field(default=())


class UndecidedError(EvenspinError):
    """What a file and its data do not tell, all of it in one message."""

    def __init__(self, file: Path, questions: Sequence[str]) -> None:
        asked = " ".join(f"({number}) {question}" for number, question in enumerate(questions, 1))
        hint = (
            f"`evenspin log map {file} --out MAP.toml` writes what is known; decide there and give it back with --map"
        )
        super().__init__(one_line(f"{file}: {len(questions)} to decide: {asked}; {hint}"))


def write_map(mapping: Mapping, source: Path) -> str:
    """The text of MAP.toml."""
    document = tomlkit.document()
    document.add(tomlkit.comment(f"How {source.name} is read. Correct it and give it back with --map."))
    document.add(tomlkit.comment("value in SI = (number in the file + offset) * scale * unit"))
    for question in mapping.questions:
        document.add(tomlkit.comment(f"TO DECIDE: {question}"))
    document.add(tomlkit.nl())
    general = {
        "rate_hz": mapping.rate_hz,
        "pole_pairs": mapping.pole_pairs,
        "counts_per_turn": mapping.counts_per_turn,
        "electrical_zero_rad": mapping.electrical_zero_rad,
    }
    for key, value in general.items():
        if value is not None:
            document.add(key, value)
    if mapping.power_invariant:
        document.add("power_invariant", True)
    columns = tomlkit.table()
    for quantity, column in mapping.columns.items():
        line = tomlkit.inline_table()
        line.update({"from": column.source, "unit": column.unit})
        if column.scale != 1.0:
            line["scale"] = column.scale
        if column.offset != 0.0:
            line["offset"] = column.offset
        columns.add(quantity, line)
        if column.reason:
            columns[quantity].comment(column.reason)
    document.add("columns", columns)
    if mapping.ignored:
        document.add(tomlkit.comment("not used: " + ", ".join(mapping.ignored)))
    return tomlkit.dumps(document)


GENERAL = ("rate_hz", "pole_pairs", "counts_per_turn", "electrical_zero_rad", "power_invariant", "columns")


def read_map(path: Path) -> Mapping:
    """Read a MAP.toml; every error names file, key, value, what is allowed."""
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(path, "file", "(missing)", "an existing MAP.toml", HINT) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(path, "file", str(error), "TOML", HINT) from None
    except OSError as error:
        raise InputError(path, "file", error.strerror or str(error), "a readable file", HINT) from None
    for key in content:
        if key not in GENERAL:
            raise InputError(path, "key", key, "one of MAP.toml", did_you_mean(key, GENERAL))
    columns = content.get("columns")
    if not isinstance(columns, dict) or not columns:
        raise InputError(path, "columns", columns, "a table of quantities", HINT)
    invariant = content.get("power_invariant", False)
    if not isinstance(invariant, bool):
        raise InputError(path, "power_invariant", invariant, "true or false", HINT)
    pairs = _number(path, content, "pole_pairs", 1.0, MOST_POLE_PAIRS)
    if pairs is not None and not pairs.is_integer():
        raise InputError(path, "pole_pairs", pairs, f"a whole number of 1 .. {MOST_POLE_PAIRS}", HINT)
    return Mapping(
        {name: _column(path, name, value) for name, value in columns.items()},
        _number(path, content, "rate_hz", 1e-3, 1e7),
        None if pairs is None else int(pairs),
        _number(path, content, "counts_per_turn", 1.0, 2.0**32),
        _number(path, content, "electrical_zero_rad", -100.0, 100.0),
        invariant,
    )


def _column(path: Path, name: str, value: Any) -> ColumnMap:
    place = f"columns.{name}"
    if name not in QUANTITIES:
        raise InputError(path, "quantity", name, "one that is known", did_you_mean(name, QUANTITIES))
    if isinstance(value, str | int) and not isinstance(value, bool):
        value = {"from": value}
    if not isinstance(value, dict):
        raise InputError(path, place, value, '{ from = "COLUMN", unit = "UNIT" }', HINT)
    for key in value:
        if key not in ("from", "unit", "scale", "offset"):
            raise InputError(path, f"{place} key", key, "from, unit, scale or offset", HINT)
    source = value.get("from")
    if isinstance(source, bool) or not isinstance(source, str | int) or source == "":
        raise InputError(path, f"{place}.from", source, "the name of a column, or its number from 1", HINT)
    unit = value.get("unit", "")
    known = unit_of(unit) if isinstance(unit, str) else None
    if unit and known is None:
        raise InputError(path, f"{place}.unit", unit, "a known unit", did_you_mean(str(unit), UNITS))
    if known is not None and known.dimension not in (QUANTITIES[name], "share"):
        raise InputError(path, f"{place}.unit", unit, f"a unit of {QUANTITIES[name]}", HINT)
    scale = _number(path, value, "scale", -1e12, 1e12, place)
    if scale == 0.0:
        raise InputError(path, f"{place}.scale", scale, "other than 0", HINT)
    offset = _number(path, value, "offset", -1e15, 1e15, place)
    return ColumnMap(
        str(source), str(unit), 1.0 if scale is None else scale, 0.0 if offset is None else offset, "MAP.toml"
    )


def _number(
    path: Path, content: MappingType[str, Any], key: str, least: float, most: float, place: str = ""
) -> float | None:
    value = content.get(key)
    if value is None:
        return None
    good = not isinstance(value, bool) and isinstance(value, int | float) and math.isfinite(value)
    if not good or not least <= value <= most:
        name = f"{place}.{key}" if place else key
        raise InputError(path, name, value, f"a number of {least:g} .. {most:g}", HINT)
    return float(value)
