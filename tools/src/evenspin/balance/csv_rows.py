"""The rows of a CSV file, as far as they can be read; a last line that is cut off is left out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import InputError
from evenspin.log.textfile import line_blocks

Array = NDArray[np.float64]

HINT = "docs/log-format.md names columns and units"


def header_of(text: str) -> list[str]:
    first = text.split("\n", 1)[0]
    return [name.strip() for name in first.strip().split(",")]


def rows_of(path: Path, text: str, wanted: Sequence[int], repairs: list[str]) -> Array:
    """The columns with these numbers, a row per line."""
    header = header_of(text)
    start, end = text.find("\n") + 1, len(text.rstrip())
    if start == 0 or end <= start:
        raise InputError(path, "rows", 0, "at least one", HINT, 2)
    last = text.rfind("\n", 0, end) + 1
    if _cut_off(text[last:end], len(header), ends=text.endswith("\n")):
        repairs.append(f"the last line (line {text.count(chr(10), 0, last) + 1}) is cut off: left out")
        text = text[:last]
    parts: list[Array] = []
    for number, block in line_blocks(text, start, 2):
        lines = [(number + i, line) for i, line in enumerate(block) if line.strip()]
        if lines:
            parts.append(_block(path, lines, header, wanted))
    if not parts:
        raise InputError(path, "rows", 0, "at least one", HINT, 2)
    return np.concatenate(parts)


def _block(path: Path, lines: Sequence[tuple[int, str]], header: Sequence[str], wanted: Sequence[int]) -> Array:
    try:
        values = np.loadtxt([line for _, line in lines], delimiter=",", ndmin=2, comments=None)
    except ValueError:
        return _row_by_row(path, lines, header, wanted)
    if values.shape[1] != len(header):
        raise InputError(path, "columns", values.shape[1], f"{len(header)} as in the header", HINT, lines[0][0])
    return values[:, list(wanted)]


def _cut_off(line: str, width: int, *, ends: bool) -> bool:
    """A line with too few cells, or one without its end whose last cell may have lost digits."""
    cells = line.split(",")
    return len(cells) < width or (not ends and _number(cells[-1]) is None)


def _row_by_row(path: Path, lines: Sequence[tuple[int, str]], header: Sequence[str], wanted: Sequence[int]) -> Array:
    """Slow and exact: an empty cell is not-a-number, anything else that is not a number is refused."""
    values = np.full((len(lines), len(wanted)), np.nan)
    for row, (line_number, line) in enumerate(lines):
        cells = line.split(",")
        if len(cells) != len(header):
            must = f"{len(header)} as in the header"
            raise InputError(path, "columns", len(cells), must, "correct the line", line_number)
        for place, column in enumerate(wanted):
            cell = cells[column].strip()
            number = np.nan if not cell else _number(cell)
            if number is None:
                hint = f"correct the cell of {header[column]}"
                raise InputError(path, "cell", cell, "a number", hint, line_number)
            values[row, place] = number
    return values


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
