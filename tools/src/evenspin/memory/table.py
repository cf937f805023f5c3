"""The learned table and its two forms of file.

NAME.csv    cell, theta_m_rad, disturbance_a (and disturbance_nm when the torque constant is known)
NAME.json   {"format": "evenspin angle memory 1", "cells": 720, "unit": "A", "turn": "mechanical",
             "torque_per_a_nm": 0.4455, "disturbance_a": [...]}

The table is the disturbance torque over one mechanical turn, as ampere of q current, positive where it drives forward;
the drive subtracts it from its reference. Cell i stands for the angle 2 pi i / cells.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import MISSING, InputError, reason
from evenspin.log import read_csv, write_csv

Array = NDArray[np.float64]

FORMAT = "evenspin angle memory 1"
SUFFIXES = (".csv", ".json")
MAX_BYTES = 10_000_000
MIN_CELLS, MAX_CELLS = 4, 6144  # what a drive can hold
MAX_A = 1e4
HINT = "`evenspin run --method aro --save-memory FILE` writes one"


@dataclass(frozen=True, slots=True)
class AngleTable:
    """Disturbance torque over the mechanical angle, A of q current."""

    disturbance_a: Array
    torque_per_a_nm: float | None = None

    @property
    def cells(self) -> int:
        return len(self.disturbance_a)

    @property
    def theta_m_rad(self) -> Array:
        return 2.0 * np.pi * np.arange(self.cells) / self.cells

    @property
    def empty(self) -> bool:
        return not self.disturbance_a.any()

    def orders(self) -> Array:
        """Amplitude of each mechanical order from 0 (the mean), A."""
        lines = np.abs(np.fft.rfft(self.disturbance_a)) / self.cells
        lines[1:] *= 2.0
        if self.cells % 2 == 0:
            lines[-1] /= 2.0
        return lines

    def summary(self) -> dict[str, Any]:
        """The table in numbers, for a script."""
        table = self.disturbance_a
        lines = self.orders()
        strongest = sorted(np.argsort(lines[1:])[::-1][:6] + 1)
        content: dict[str, Any] = {
            "cells": self.cells,
            "unit": "A",
            "empty": self.empty,
            "mean_a": float(table.mean()),
            "rms_a": float(table.std()),
            "min_a": float(table.min()),
            "max_a": float(table.max()),
            "orders_a": {str(order): float(lines[order]) for order in strongest},
        }
        if self.torque_per_a_nm is not None:
            content["torque_per_a_nm"] = self.torque_per_a_nm
            content["orders_nm"] = {str(order): float(lines[order]) * self.torque_per_a_nm for order in strongest}
        return content


def check_table_file(path: Path, option: str) -> None:
    """Refuse a place that cannot be written, before any work is done."""
    if path.suffix not in SUFFIXES:
        raise InputError(option, "file", str(path), "a name that ends in .csv or .json", "rename it")
    if path.is_dir() or not path.parent.is_dir():
        raise InputError(option, "file", str(path), "a file in an existing folder", "choose another place")


def write_table(path: Path, table: AngleTable) -> None:
    """Write it completely or not at all."""
    with replaced(path) as staging:
        _write(staging, table)


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A file beside it that takes its place when it is complete."""
    check_table_file(path, str(path))
    with tempfile.NamedTemporaryFile(
        dir=path.parent, prefix=f".{path.name}.", suffix=path.suffix, delete=False
    ) as file:
        staging = Path(file.name)
    try:
        yield staging
        staging.chmod(0o644)
        os.replace(staging, path)
    finally:
        staging.unlink(missing_ok=True)


def _write(path: Path, table: AngleTable) -> None:
    if path.suffix == ".json":
        content: dict[str, Any] = {"format": FORMAT, "cells": table.cells, "unit": "A", "turn": "mechanical"}
        if table.torque_per_a_nm is not None:
            content["torque_per_a_nm"] = table.torque_per_a_nm
        values = [float(f"{value:.9g}") for value in table.disturbance_a]
        path.write_text(json.dumps(content | {"disturbance_a": values}, indent=1) + "\n", encoding="utf-8")
        return
    columns = {
        "cell": np.arange(table.cells, dtype=float),
        "theta_m_rad": table.theta_m_rad,
        "disturbance_a": table.disturbance_a,
    }
    if table.torque_per_a_nm is not None:
        columns["disturbance_nm"] = table.torque_per_a_nm * table.disturbance_a
    write_csv(path, list(columns), np.column_stack(list(columns.values())))


def read_table(path: Path) -> AngleTable:
    """Whatever the file is, the answer is a table or an InputError."""
    if path.suffix not in SUFFIXES:
        raise InputError(path, "file", str(path), "a file .csv or .json", HINT)
    try:
        size = path.stat().st_size
    except OSError as error:
        value = MISSING if isinstance(error, FileNotFoundError) else error.strerror
        raise InputError(path, "file", value, "an existing file", HINT) from None
    if size > MAX_BYTES:
        raise InputError(path, "size", f"{size} bytes", f"at most {MAX_BYTES} bytes", "is this the right file?")
    table = _read_json(path) if path.suffix == ".json" else _read_csv(path)
    if not MIN_CELLS <= table.cells <= MAX_CELLS:
        raise InputError(path, "cells", table.cells, f"within {MIN_CELLS} .. {MAX_CELLS}", HINT)
    bad = np.flatnonzero(~(np.abs(table.disturbance_a) <= MAX_A))
    if len(bad):
        cell = int(bad[0])
        amps = float(table.disturbance_a[cell])
        raise InputError(path, f"cell {cell}", amps, f"finite and within +-{MAX_A:g} A", "correct the cell")
    return table


def _read_csv(path: Path) -> AngleTable:
    record = read_csv(path, ("cell", "disturbance_a"), ("", "A"))
    wrong = np.flatnonzero(record["cell"] != np.arange(len(record)))
    if len(wrong):
        row = int(wrong[0])
        raise InputError(path, "cell", float(record["cell"][row]), f"{row}: each cell once, in order", HINT, row + 2)
    torque_per_a_nm = None
    if "disturbance_nm" in path.open(encoding="utf-8").readline():
        torque = read_csv(path, ("disturbance_nm",), ("N m",))["disturbance_nm"]
        torque_per_a_nm = _ratio(torque, record["disturbance_a"])
    return AngleTable(np.array(record["disturbance_a"]), torque_per_a_nm)


def _ratio(torque_nm: Array, current_a: Array) -> float | None:
    """The torque constant with which the file was written; None when nothing was learned."""
    at = int(np.argmax(np.abs(current_a)))
    ratio = torque_nm[at] / current_a[at] if current_a[at] else 0.0
    return float(f"{ratio:.6g}") if np.isfinite(ratio) and ratio > 0.0 else None


def _read_json(path: Path) -> AngleTable:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(path, "file", reason(error), "JSON", HINT) from None
    if not isinstance(content, Mapping) or content.get("format") != FORMAT:
        given = content.get("format", MISSING) if isinstance(content, Mapping) else MISSING
        raise InputError(path, "format", given, f'"{FORMAT}"', HINT)
    values, cells, ratio = content.get("disturbance_a"), content.get("cells"), content.get("torque_per_a_nm")
    if not isinstance(values, list) or not all(_is_number(value) for value in values):
        raise InputError(path, "disturbance_a", type(values).__name__, "a list of numbers", HINT)
    if cells != len(values):
        raise InputError(path, "cells", cells, f"{len(values)}, the length of disturbance_a", "correct one of the two")
    if content.get("unit") != "A":
        raise InputError(path, "unit", content.get("unit", MISSING), '"A"', HINT)
    if ratio is not None and not (_is_number(ratio) and 0.0 < ratio < 1e6):
        raise InputError(path, "torque_per_a_nm", ratio, "a number above 0", "correct it or remove it")
    return AngleTable(np.array(values, dtype=float), float(ratio) if ratio is not None else None)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
