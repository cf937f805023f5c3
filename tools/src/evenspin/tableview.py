"""A table for people: on the terminal and in a report."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from rich.console import Console

LONG_CELL = 40  # longer text may be broken
STYLES = {"good": "green", "bad": "bold red", "": ""}


@dataclass(frozen=True, slots=True)
class TableView:
    """`marks` gives each row a class (good, bad or nothing); the first `left` columns are text."""

    title: str
    text: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    marks: Sequence[str] = ()
    left: int = 2


def number(value: float | None, digits: int = 3) -> str:
    """As many significant digits; in powers of ten only where that is no longer than decimals; a dash for nothing."""
    if value is None or not math.isfinite(value):
        return "-"
    if value == 0.0:
        return "0"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    if decimals > digits + 3:
        return f"{value:.{digits - 1}e}"
    return f"{value:.{decimals}f}"


def print_table(view: TableView, console: Console) -> None:
    """Print it with rich. Where it does not fit in, nothing is cut: texts are wrapped, columns are continued below
    under the first ones again, or each row becomes a block of its own. Into a file or a pipe it is as wide as it
    needs."""
    from rich.text import Text

    if not console.is_terminal:
        wide = console.width
        console.width = max(wide, _uncut(view))
        _print_columns(view, console, range(len(view.header)), None)
        console.width = wide
    else:
        widths = _widths(view)
        key = range(_key_columns(view))
        fitted = _fit(view, widths, console.width)
        parts = _parts(widths, key, console.width)
        if fitted is not None:
            _print_columns(view, console, range(len(widths)), fitted)
        elif parts is not None:
            for number, part in enumerate(parts):
                _print_columns(view, console, part, widths, continued=number > 0)
        else:
            _print_blocks(view, console)
    if view.text:
        console.print(Text(view.text), style="dim")


# ---- how wide

GAP = 2  # columns between two cells
LEAST_TEXT = 18  # a text is not wrapped narrower than this
MOST_LINES = 6  # of a cell; beyond it a block of its own is easier to read


def _widths(view: TableView) -> list[int]:
    """What each column needs on one line."""
    return [max(len(name), *(len(row[i]) for row in view.rows), 1) for i, name in enumerate(view.header)]


def _uncut(view: TableView) -> int:
    """The width of a whole table of rich with its borders in which no name and no number is cut."""
    borders = 3 * len(view.header) + 2
    return borders + sum(min(width, LONG_CELL) for width in _widths(view))


def _least(view: TableView, index: int) -> int:
    """How narrow a column may be: a number and a name keep their line, a text may be wrapped between words."""
    cells = [view.header[index], *(row[index] for row in view.rows)]
    words = max((len(word) for cell in cells for word in cell.split()), default=1)
    is_text = any(len(cell) > LEAST_TEXT and " " in cell for cell in cells)
    longest = max(1, *(len(cell) for cell in cells))
    return max(words, min(longest, LEAST_TEXT)) if is_text else longest


def _room(widths: Sequence[int]) -> int:
    return sum(widths) + GAP * len(widths)


def _fit(view: TableView, widths: Sequence[int], room: int) -> list[int] | None:
    """Widths at which all columns stand side by side, or None."""
    if _room(widths) <= room:
        return list(widths)
    least = [_least(view, index) for index in range(len(widths))]
    spare = room - _room(least)
    if spare < 0:
        return None
    wanted = [wide - narrow for wide, narrow in zip(widths, least, strict=True)]
    result = [narrow + spare * more // max(1, sum(wanted)) for narrow, more in zip(least, wanted, strict=True)]
    lines = max((-(-len(row[i]) // result[i]) for row in view.rows for i in range(len(result))), default=1)
    return result if lines <= MOST_LINES else None


def _key_columns(view: TableView) -> int:
    """The columns that say which row it is; they stand in front of each part of a table that is continued."""
    return max(1, min(view.left, len(view.header) - 1))


def _parts(widths: Sequence[int], key: range, room: int) -> list[list[int]] | None:
    """The columns, in as many tables below each other as it takes, or None when one alone is too wide."""
    head = [widths[i] for i in key]
    parts: list[list[int]] = []
    for index in range(len(key), len(widths)):
        if parts and _room([*(widths[i] for i in parts[-1]), widths[index]]) <= room:
            parts[-1].append(index)
        elif _room([*head, widths[index]]) <= room:
            parts.append([*key, index])
        else:
            return None
    return parts


# ---- how it is printed


def _print_columns(
    view: TableView, console: Console, columns: Sequence[int], widths: Sequence[int] | None, *, continued: bool = False
) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    title = f"{view.title} (continued)" if continued else view.title
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD)
    if widths is not None:  # each column of the terminal counts
        table.show_edge, table.pad_edge, table.padding = False, False, (0, 1)
        table.collapse_padding = True
    for index in columns:
        longest = max((len(row[index]) for row in view.rows), default=0)
        side: Literal["left", "right"] = "left" if index < view.left else "right"
        if widths is None:
            table.add_column(Text(view.header[index]), justify=side, no_wrap=longest <= LONG_CELL)
        else:
            table.add_column(Text(view.header[index]), justify=side, width=widths[index], overflow="fold")
    for row, mark in zip(view.rows, view.marks or [""] * len(view.rows), strict=True):
        table.add_row(*(Text(row[index]) for index in columns), style=STYLES[mark])
    console.print(table)
    if widths is not None:
        console.print()


def _print_blocks(view: TableView, console: Console) -> None:
    """A row as lines of heading and value."""
    from rich.text import Text

    console.print(Text(view.title, style="bold"))
    wide = max((len(name) for name in view.header[1:]), default=0)
    for row, mark in zip(view.rows, view.marks or [""] * len(view.rows), strict=True):
        console.print(Text(row[0], style=f"bold {STYLES[mark]}".strip()), soft_wrap=False, overflow="fold")
        for name, cell in zip(view.header[1:], row[1:], strict=True):
            if cell:
                lines = textwrap.wrap(cell, max(10, console.width - wide - 4), break_on_hyphens=False)
                for number, line in enumerate(lines):
                    console.print(Text(f"  {name if number == 0 else '':<{wide}}  {line}"), overflow="fold")
    console.print()
