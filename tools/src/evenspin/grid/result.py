"""All numbers of a grid: a row for each run and each of its steady states or motions."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evenspin.errors import EvenspinError
from evenspin.tableview import TableView, number

# What a table shows, of what there is.
SHOWN = {
    "start_s": "from s",
    "speed_ref_rpm": "rpm",
    "speed_rms_rpm": "rms rpm",
    "n1_pct": "n1 %",
    "n2_pct": "n2 %",
    "order_per_turn": "order",
    "order_rpm": "its rpm",
    "overshoot_rpm": "over rpm",
    "settled_s": "settled s",
    "to_turn": "to turn",
    "error_rms_mrad": "error rms mrad",
    "error_max_mrad": "largest mrad",
}
SPEED_MEASURES = ("speed_rms_rpm", "overshoot_rpm", "dip_rpm", "settled_s", "n1_pct", "n2_pct")
POSITION_MEASURES = ("error_rms_mrad", "error_max_mrad", "speed_rms_rpm", "settled_s")
MOST_ROWS = 60  # on the screen


@dataclass(frozen=True, slots=True)
class Grid:
    """`axes`: names and values; `fixed`: what else was changed; `rows`: the axes, `outcome`, and numbers by name."""

    scenario: str
    axes: Mapping[str, tuple[Any, ...]]
    fixed: Mapping[str, Any]
    rows: Sequence[Mapping[str, Any]]

    @property
    def columns(self) -> list[str]:
        names = dict.fromkeys(name for row in self.rows for name in row)
        return [name for name in names if name != "why"] + (["why"] if "why" in names else [])

    @property
    def measures(self) -> list[str]:
        """What is worth a picture."""
        known = POSITION_MEASURES if "error_rms_mrad" in self.columns else SPEED_MEASURES
        return [name for name in known if any(row.get(name) is not None for row in self.rows)]

    @property
    def ran(self) -> int:
        """Rows of runs to which nothing happened."""
        return sum(row["outcome"] == "ran" for row in self.rows)

    def column(self, name: str) -> list[Any]:
        """One column; None where a row does not have it."""
        return [row.get(name) for row in self.rows]

    def to_pandas(self) -> Any:
        """A frame with a row for each run and each of its steady states or motions. Needs pandas."""
        import_name = "pandas"
        try:
            import pandas
        except ImportError as error:
            raise EvenspinError(f"{import_name}: is not installed ({error}); pip install {import_name}") from None
        return pandas.DataFrame({name: self.column(name) for name in self.columns})


def csv_text(grid: Grid) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(grid.columns)
    for row in grid.rows:
        writer.writerow([_csv_cell(row.get(name)) for name in grid.columns])
    return out.getvalue()


def _csv_cell(value: Any) -> Any:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.9g}" if isinstance(value, float) else "" if value is None else value


def need_parquet() -> Any:
    """Before any work is done."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise EvenspinError(f"--parquet: pyarrow is not installed ({error}); pip install pyarrow") from None
    return pyarrow


def write_parquet(path: Path, grid: Grid) -> None:
    arrow = need_parquet()
    columns = {name: _one_kind(grid.column(name)) for name in grid.columns}
    arrow.parquet.write_table(arrow.table(columns), path)


def _one_kind(values: list[Any]) -> list[Any]:
    """A column of Parquet has one type."""
    known = [value for value in values if value is not None]
    if any(isinstance(value, str) for value in known):
        return [None if value is None else str(value) for value in values]
    if any(isinstance(value, float) for value in known):
        return [None if value is None else float(value) for value in values]
    return values


def table_of(grid: Grid) -> TableView:
    shown = [name for name in SHOWN if name in grid.columns]
    header = (*grid.axes, *(SHOWN[name] for name in shown), "outcome")
    rows, marks = [], []
    for row in grid.rows:
        cells = [_word(row[name]) for name in grid.axes]
        rows.append((*cells, *(number(row.get(name)) for name in shown), row["outcome"]))
        marks.append("" if row["outcome"] == "ran" else "bad")
    text = f"{len(rows)} rows, one for each run and each of its steady states or motions; sweep.csv has all columns."
    if len(rows) > MOST_ROWS:
        text = f"The first {MOST_ROWS} of " + text
    return TableView(
        f"Sweep of {grid.scenario}", text, header, rows[:MOST_ROWS], marks[:MOST_ROWS], left=len(grid.axes)
    )


def _word(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else str(value)
