"""The rows of a CSV file, as far as they can be read; a last line that is cut off is left out."""

from __future__ import annotations

import gzip
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import MISSING, InputError

Array = NDArray[np.float64]

HINT = "docs/log-format.md names columns and units"


def read_text(path: Path) -> str:
    try:
        if path.suffix == ".gz":
            with gzip.open(path, "rt", encoding="utf-8-sig") as file:
                return file.read()
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(path, "file", MISSING, "an existing file", HINT) from None
    except EOFError:
        raise InputError(path, "file", "(cut off)", "a complete .gz file", "copy it again") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, "file", str(error), "a readable CSV file", HINT) from None


def header_of(text: str) -> list[str]:
    first = text.split("\n", 1)[0]
    return [name.strip() for name in first.strip().split(",")]


def rows_of(path: Path, text: str, wanted: Sequence[int], repairs: list[str]) -> Array:
    """The columns with these numbers, a row per line."""
    width = len(header_of(text))
    lines = [line for line in text.split("\n")[1:] if line.strip()]
    if lines and _cut_off(lines[-1], width, ends=text.endswith("\n")):
        repairs.append(f"the last line (line {len(lines) + 1}) is cut off: left out")
        lines.pop()
    if not lines:
        raise InputError(path, "rows", 0, "at least one", HINT, 2)
    try:
        values = np.loadtxt(io.StringIO("\n".join(lines)), delimiter=",", ndmin=2, comments=None)
    except ValueError:
        return _row_by_row(path, lines, width, wanted)
    if values.shape[1] != width:
        raise InputError(path, "columns", values.shape[1], f"{width} as in the header", HINT, 2)
    return np.ascontiguousarray(values[:, list(wanted)])


def _cut_off(line: str, width: int, *, ends: bool) -> bool:
    """A line with too few cells, or one without its end whose last cell may have lost digits."""
    cells = line.split(",")
    return len(cells) < width or (not ends and _number(cells[-1]) is None)


def _row_by_row(path: Path, lines: Sequence[str], width: int, wanted: Sequence[int]) -> Array:
    """Slow and exact: an empty cell is not-a-number, anything else that is not a number is refused."""
    values = np.full((len(lines), len(wanted)), np.nan)
    for row, line in enumerate(lines):
        cells = line.split(",")
        if len(cells) != width:
            raise InputError(path, "columns", len(cells), f"{width} as in the header", "correct the line", row + 2)
        for place, column in enumerate(wanted):
            cell = cells[column].strip()
            number = np.nan if not cell else _number(cell)
            if number is None:
                raise InputError(path, "cell", cell, "a number", "correct the cell", row + 2)
            values[row, place] = number
    return values


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
