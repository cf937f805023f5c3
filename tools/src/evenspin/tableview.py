"""A table for people: on the terminal and in a report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

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
    """Three significant digits, never in powers of ten; a dash where there is nothing."""
    if value is None or not math.isfinite(value):
        return "-"
    if value == 0.0:
        return "0"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:.{min(decimals, 6)}f}"


def print_table(view: TableView, console: Console) -> None:
    """Print it with rich."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(title=view.title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD)
    for index, name in enumerate(view.header):
        longest = max((len(row[index]) for row in view.rows), default=0)
        side = "left" if index < view.left else "right"
        table.add_column(Text(name), justify=side, no_wrap=longest <= LONG_CELL)
    marks = view.marks or [""] * len(view.rows)
    for row, mark in zip(view.rows, marks, strict=True):
        table.add_row(*map(Text, row), style=STYLES[mark])
    console.print(table)
    if view.text:
        console.print(view.text, style="dim")
