"""What any method has learned over the angle, as a file.

NAME.json   {"format": "evenspin learned memory 1", "crc32": "0a1b2c3d", "tables": [
             {"method": "fal-forc", "turn": "electrical", "unit": "unit of the speed error", "cells": 256,
              "learned_with": {"speed_error_gain": 4.0, "rc_order": 2.0}, "values": [...]}]}

One table for each method that learns; cell i stands for the angle 2 pi i / cells of its turn. `learned_with` are the
parameters of the drive that give the values their meaning. The check sum is that of the tables as compact JSON with
sorted keys.
"""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import InputError, reason
from evenspin.memory.table import MAX_BYTES, MAX_CELLS, MIN_CELLS, AngleTable, replaced

Array = NDArray[np.float64]

FORMAT = "evenspin learned memory 1"
HINT = "`evenspin run --save-memory FILE.json` writes one"
MAX_TABLES = 3
MAX_VALUE = 1e6
STRONGEST = 6


@dataclass(frozen=True, slots=True)
class LearnedTable:
    """Values over one turn of the angle."""

    method: str
    turn: str
    unit: str
    learned_with: Mapping[str, float]
    values: Array

    def summary(self) -> dict[str, Any]:
        """In numbers, for a script."""
        lines = np.abs(np.fft.rfft(self.values)) / len(self.values)
        lines[1:] *= 2.0
        strongest = sorted(np.argsort(lines[1:])[::-1][:STRONGEST] + 1)
        return {
            "method": self.method,
            "turn": self.turn,
            "unit": self.unit,
            "cells": len(self.values),
            "empty": not self.values.any(),
            "mean": float(self.values.mean()),
            "rms": float(self.values.std()),
            "largest": float(np.abs(self.values).max()),
            "orders": {str(order): float(lines[order]) for order in strongest},
        }

    def as_json(self) -> dict[str, Any]:
        return {
            "method": self.method,
            "turn": self.turn,
            "unit": self.unit,
            "cells": len(self.values),
            "learned_with": dict(self.learned_with),
            "values": [float(f"{value:.9g}") for value in self.values],
        }


Learned = AngleTable | list[LearnedTable]
"""Of the angle observer alone, or of any methods."""


def write_learned(path: Path, tables: Sequence[LearnedTable]) -> None:
    """Write them completely or not at all."""
    rows = [table.as_json() for table in tables]
    content = {"format": FORMAT, "crc32": check_sum(rows), "tables": rows}
    with replaced(path) as staging:
        staging.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def check_sum(rows: Any) -> str:
    return f"{zlib.crc32(json.dumps(rows, sort_keys=True, separators=(',', ':')).encode()):08x}"


def read_learned(path: Path) -> list[LearnedTable]:
    """Whatever the file is, the answer is tables or an InputError."""
    content = _content(path)
    rows = content.get("tables")
    if not isinstance(rows, list) or not 1 <= len(rows) <= MAX_TABLES:
        raise InputError(path, "tables", type(rows).__name__, f"a list of 1 to {MAX_TABLES}", HINT)
    found = [_table(path, index, row) for index, row in enumerate(rows)]
    if content.get("crc32") != check_sum(rows):
        given = content.get("crc32", "(missing)")
        raise InputError(
            path, "crc32", given, f'"{check_sum(rows)}", that of the tables', "the file was changed; save it again"
        )
    return found


def is_learned_file(path: Path) -> bool:
    """Whether it says so itself."""
    if path.suffix != ".json" or not path.is_file() or path.stat().st_size > MAX_BYTES:
        return False
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(content, Mapping) and content.get("format") == FORMAT


def _content(path: Path) -> Mapping[str, Any]:
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError(path, "size", f"{path.stat().st_size} bytes", f"at most {MAX_BYTES} bytes", HINT)
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(path, "file", reason(error), "JSON", HINT) from None
    if not isinstance(content, Mapping) or content.get("format") != FORMAT:
        given = content.get("format", "(missing)") if isinstance(content, Mapping) else "(missing)"
        raise InputError(path, "format", given, f'"{FORMAT}"', HINT)
    return content


def _table(path: Path, index: int, row: Any) -> LearnedTable:
    where = f"tables[{index}]"
    if not isinstance(row, Mapping):
        raise InputError(path, where, type(row).__name__, "a table", HINT)
    texts = {}
    for key in ("method", "turn", "unit"):
        if not isinstance(row.get(key), str):
            raise InputError(path, f"{where}.{key}", row.get(key, "(missing)"), "a text", HINT)
        texts[key] = row[key]
    values, cells, given = row.get("values"), row.get("cells"), row.get("learned_with")
    if not isinstance(values, list) or cells != len(values) or not MIN_CELLS <= len(values) <= MAX_CELLS:
        must = f"the length of values, within {MIN_CELLS} .. {MAX_CELLS}"
        raise InputError(path, f"{where}.cells", cells, must, HINT)
    for cell, value in enumerate(values):
        if not _is_number(value) or not abs(value) <= MAX_VALUE:
            raise InputError(
                path, f"{where}.values[{cell}]", value, f"finite and within +-{MAX_VALUE:g}", "save it again"
            )
    if not isinstance(given, Mapping) or not all(_is_number(value) for value in given.values()):
        raise InputError(path, f"{where}.learned_with", type(given).__name__, "numbers by name", HINT)
    learned_with = {str(name): float(value) for name, value in given.items()}
    return LearnedTable(texts["method"], texts["turn"], texts["unit"], learned_with, np.array(values, dtype=float))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
