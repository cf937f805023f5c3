"""CSV with one header row. Nine digits: a float32 comes back as it was, and the same numbers give the same bytes."""

from __future__ import annotations

import gzip
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import InputError, did_you_mean
from evenspin.log.textfile import HINT, line_blocks, read_text
from evenspin.native.csvrows import csv_rows
from evenspin.sim.record import Record

ROWS_AT_ONCE = 4096


def write_csv(path: Path, names: Sequence[str], values: NDArray[np.float64]) -> None:
    """Write a table; a name that ends in .gz is compressed."""
    with _open_to_write(path) as file:
        file.write(f"{','.join(names)}\n".encode("ascii"))
        for start in range(0, len(values), ROWS_AT_ONCE):
            file.write(csv_rows(values[start : start + ROWS_AT_ONCE]))


def read_csv(path: Path, names: Sequence[str], units: Sequence[str]) -> Record:
    """Read these columns; the file may have more, in any order. What cannot be read is an InputError."""
    text = read_text(path)
    first = text.split("\n", 1)[0]
    header = [name.strip() for name in first.strip().split(",")]
    for name in names:
        if name not in header:
            raise InputError(path, "column", name, "in the header", did_you_mean(name, header), 1)
        if header.count(name) > 1:
            raise InputError(path, "column", name, "in the header once", "remove the other", 1)
    columns = [header.index(name) for name in names]
    parts = [_parsed(path, number, lines, header, columns) for number, lines in line_blocks(text, len(first) + 1, 2)]
    values = np.concatenate(parts) if parts else np.empty((0, len(names)))
    if not len(values):
        raise InputError(path, "rows", 0, "at least 1", HINT, 2)
    return Record(tuple(names), tuple(units), values)


def _parsed(
    path: Path, number: int, lines: Sequence[str], header: Sequence[str], columns: Sequence[int]
) -> NDArray[np.float64]:
    """These columns of some lines, of which the first has this number."""
    if not any(line.strip() for line in lines):
        return np.empty((0, len(columns)))
    try:
        values = np.loadtxt(lines, delimiter=",", ndmin=2, comments=None)
    except ValueError:
        raise _first_bad_cell(path, number, lines, header) from None
    if values.shape[1] != len(header):
        raise InputError(path, "columns", values.shape[1], f"{len(header)} as in the header", HINT, number)
    return values[:, columns]


def _first_bad_cell(path: Path, first: int, lines: Sequence[str], header: Sequence[str]) -> InputError:
    for number, line in enumerate(lines, start=first):
        cells = line.split(",")
        if line and len(cells) != len(header):
            return InputError(path, "columns", len(cells), f"{len(header)} as in the header", HINT, number)
        for name, cell in zip(header, cells, strict=False):
            if line and not _is_number(cell):
                return InputError(path, name, cell, "a number", "correct the cell", number)
    return InputError(path, "file", "(unreadable)", "a CSV file of numbers", HINT)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _open_to_write(path: Path) -> BinaryIO | gzip.GzipFile:
    return gzip.GzipFile(path, "wb", mtime=0) if path.suffix == ".gz" else path.open("wb")
