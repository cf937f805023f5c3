"""Text tables: any delimiter, decimal point or comma, a row of units, lines before the header, or no header at all.

The file is read in pieces: its text does not have to fit into memory. What is kept is one float per cell.
"""

from __future__ import annotations

import csv
import gzip
import io
import re
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import IO

import numpy as np

from evenspin.errors import MISSING, InputError
from evenspin.importer.table import MOST_COLUMNS, Array, RawColumn, RawTable
from evenspin.importer.units import looks_like_unit, split_unit

Progress = Callable[[float], None]

HEAD_CHARACTERS = 200_000  # in which the header has to end
PIECE = 1 << 23  # characters parsed at a time
MOST_CELLS = 300_000_000  # 2.4 GB of floats
MOST_UNPACKED = 8_000_000_000  # characters
HINT = "docs/import.md says which files can be read"
DELIMITERS = ("\t", ";", ",", "|", " ")
CLOCK = re.compile(r"^(?:(?P<date>\d{4}-\d\d-\d\d)[T ])?(?P<h>\d{1,2}):(?P<m>\d\d)(?::(?P<s>\d\d(?:[.,]\d+)?))?Z?$")
MISSING_CELLS = frozenset({"", "-", "--", "na", "n/a", "nan", "null", "none", "nil", "#n/a"})


@dataclass(frozen=True, slots=True)
class Dialect:
    """How the lines of a file are to be read; `first` is the number of the first row of data, from 0."""

    delimiter: str
    decimal_comma: bool
    first: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    repeated: bool  # several delimiters in a row count as one
    quoted: bool


def read_delimited(path: Path, progress: Progress | None = None) -> RawTable:
    """Read a whole text table; whatever the file is, the answer is a table or an InputError."""
    try:
        with _opened(path) as file:
            head = file.read(HEAD_CHARACTERS)
            if "\0" in head:
                raise InputError(path, "file", "(binary)", "a text table or a known format", HINT)
            whole = len(head) < HEAD_CHARACTERS
            dialect = dialect_of(path, head if whole else head[: head.rfind("\n") + 1])
            blocks = list(_blocks(path, file, head, dialect, progress))
    except FileNotFoundError:
        raise InputError(path, "file", MISSING, "an existing file", HINT) from None
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise InputError(path, "file", f"(damaged: {error})", "an undamaged .gz file", "copy it again") from None
    except UnicodeDecodeError as error:
        raise InputError(path, "file", f"(byte {error.start} is no text)", "a text table", HINT) from None
    except OSError as error:
        raise InputError(path, "file", error.strerror or str(error), "a readable file", HINT) from None
    values = np.concatenate(blocks) if blocks else np.empty((0, len(dialect.names)))
    columns = [
        RawColumn(name, unit, np.ascontiguousarray(values[:, i]))
        for i, (name, unit) in enumerate(zip(dialect.names, dialect.units, strict=True))
    ]
    kept = tuple(c for c in columns if c.name or np.isfinite(c.values).any())
    return RawTable(path, _words(dialect), kept)


def dialect_of(path: Path, head: str) -> Dialect:
    """Find delimiter, decimal sign, header and units from the first lines of a file."""
    lines = head.splitlines()
    found = None
    for delimiter in DELIMITERS:
        for comma in (False, True) if delimiter != "," else (False,):
            start, width = _first_data(lines, delimiter, comma)
            # Of two readings the one with more columns is right; on equal terms the earlier delimiter.
            if width >= 2 and (found is None or width > found[1]):
                found = (start, width, delimiter, comma)
    if found is None:
        shown = next((line for line in lines if line.strip()), "(empty)")
        raise InputError(path, "file", shown, "a table with at least two columns of numbers", HINT)
    start, width, delimiter, comma = found
    if width > MOST_COLUMNS:
        raise InputError(path, "columns", width, f"at most {MOST_COLUMNS}", HINT)
    above = [_cells(line, delimiter) for line in lines[max(0, start - 3) : start]]
    above = [cells for cells in above if len(cells) == width and any(cells)]
    quoted = any('"' in line for line in lines[start : start + 20])
    names, units = _header(above, width)
    return Dialect(delimiter, comma, start, names, units, delimiter == " ", quoted)


def _first_data(lines: Sequence[str], delimiter: str, comma: bool) -> tuple[int, int]:
    """Number of the first row of data and its width: the first of three rows (or of what there is) of equal width."""
    widths = [_width(line, delimiter, comma) for line in lines[:2000]]
    filled = [i for i, line in enumerate(lines[:2000]) if line.strip()]
    for place, i in enumerate(filled):
        following = [widths[j] for j in filled[place : place + 3]]
        if widths[i] >= 2 and all(w == widths[i] for w in following):
            return i, widths[i]
    return 0, 0


def _width(line: str, delimiter: str, comma: bool) -> int:
    """How many cells a row of data has; 0 when it is none."""
    cells = _cells(line, delimiter)
    numbers = [_number(cell, comma) for cell in cells]
    if any(number is None for number in numbers) or all(np.isnan(n) for n in numbers if n is not None):
        return 0
    return len(cells)


def _cells(line: str, delimiter: str) -> list[str]:
    line = line.strip("\r\n")
    if delimiter == " ":
        return line.split()
    if '"' in line:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])]
    return [cell.strip() for cell in line.split(delimiter)]


def _number(cell: str, comma: bool) -> float | None:
    text = cell.strip()
    if text.lower() in MISSING_CELLS:
        return np.nan
    if comma:
        if "." in text and "," not in text:
            return None  # a point in a file of decimal commas is no decimal sign
        text = text.replace(",", ".")
    try:
        return float(text)
    except ValueError:
        return _clock_s(text)


def _clock_s(text: str) -> float | None:
    """Seconds of a time of day, or of a date and time since 1970."""
    match = CLOCK.match(text)
    if match is None:
        return None
    day_s = 0.0
    if match["date"]:
        try:
            day_s = (datetime.fromisoformat(match["date"]) - datetime(1970, 1, 1)).total_seconds()
        except ValueError:
            return None
    seconds = float((match["s"] or "0").replace(",", "."))
    return day_s + 3600.0 * int(match["h"]) + 60.0 * int(match["m"]) + seconds


def _header(above: Sequence[Sequence[str]], width: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names and units from the lines right above the data; numbered columns when there are none."""
    if not above:
        return tuple(f"column {i + 1}" for i in range(width)), ("",) * width
    names = list(above[-1])
    units = [""] * width
    if len(above) >= 2 and all(not cell or looks_like_unit(cell) for cell in above[-1]):
        names, units = list(above[-2]), [cell.strip("[]() ") for cell in above[-1]]
    if names:
        names[0] = names[0].lstrip("#% ").strip()  # a header that is marked as a comment
    pairs = [split_unit(name) for name in names]
    return (
        tuple(name for name, _ in pairs),
        tuple(unit or printed for unit, (_, printed) in zip(units, pairs, strict=True)),
    )


def _blocks(path: Path, file: IO[str], head: str, dialect: Dialect, progress: Progress | None) -> Iterator[Array]:
    """The data in pieces of whole lines."""
    lines_before, rest = 0, head
    for _ in range(dialect.first):
        cut = rest.find("\n") + 1
        rest = rest[cut:]
        lines_before += 1
    read, cells = len(head), 0
    while True:
        more = file.read(PIECE)
        read += len(more)
        if read > MOST_UNPACKED:
            raise InputError(
                path, "file", f"more than {MOST_UNPACKED:.0f} characters", "at most that", "cut it in pieces"
            )
        text, rest = rest + more, ""
        if more:
            cut = text.rfind("\n") + 1
            text, rest = text[:cut], text[cut:]
        count = text.count("\n")
        if text.strip():
            block = _parsed(path, text, dialect, lines_before + 1, last=not more)
            cells += block.size
            if cells > MOST_CELLS:
                raise InputError(path, "cells", f"more than {MOST_CELLS}", "at most that", "leave out columns or rows")
            yield block
        lines_before += count
        if progress is not None:
            progress(float(read))
        if not more:
            return


def _parsed(path: Path, text: str, dialect: Dialect, first_line: int, *, last: bool) -> Array:
    width = len(dialect.names)
    plain = text.replace(",", ".") if dialect.decimal_comma else text
    if not dialect.quoted:
        try:
            separator = None if dialect.repeated else dialect.delimiter
            values = np.loadtxt(io.StringIO(plain), delimiter=separator, ndmin=2, comments=None)
            if values.shape[1] == width:
                return values
        except ValueError:
            pass
    return _row_by_row(path, text, dialect, first_line, last=last)


def _row_by_row(path: Path, text: str, dialect: Dialect, first_line: int, *, last: bool) -> Array:
    """Slow and exact: empty cells are NaN, times of day are seconds; a line that is cut off at the end is left out."""
    width = len(dialect.names)
    lines = text.splitlines()
    rows = []
    for offset, line in enumerate(lines):
        if not line.strip():
            continue
        cells = _cells(line, dialect.delimiter)
        numbers = [_number(cell, dialect.decimal_comma) for cell in cells]
        if len(cells) == width and None not in numbers:
            rows.append(numbers)
        elif last and offset == len(lines) - 1:
            break
        elif len(cells) != width:
            raise InputError(
                path, "columns", len(cells), f"{width} as in the header", "correct the line", first_line + offset
            )
        else:
            bad = numbers.index(None)
            hint = f"correct the cell of {dialect.names[bad]}"
            raise InputError(path, "cell", cells[bad], "a number", hint, first_line + offset)
    return np.array(rows, dtype=np.float64).reshape(len(rows), width)


def _opened(path: Path) -> IO[str]:
    raw = gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb")
    start = raw.peek(4)[:4] if hasattr(raw, "peek") else b""
    encoding = "utf-16" if start[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    if encoding == "utf-8-sig" and not _is_utf8(path):
        encoding = "cp1252"  # what Windows programs of Western Europe write; every octet is a character
    return io.TextIOWrapper(
        raw, encoding=encoding, newline=None, errors="replace" if encoding == "cp1252" else "strict"
    )


def _is_utf8(path: Path) -> bool:
    """Whether the start of the file, where the header is, is UTF-8."""
    with gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb") as file:
        start = file.read(HEAD_CHARACTERS)
    try:
        start.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        return error.start >= len(start) - 4 and len(start) == HEAD_CHARACTERS  # a character that the cut goes through
    return True


def _words(dialect: Dialect) -> str:
    names = {"\t": "tab", ";": "semicolon", ",": "comma", "|": "bar", " ": "blanks"}
    return f"text, {names[dialect.delimiter]}" + (", decimal comma" if dialect.decimal_comma else "")
