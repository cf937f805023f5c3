"""The numbers of a grid over its axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from evenspin.grid.result import Grid, table_of
from evenspin.report.chart import POINTS, Chart, Line, Panel
from evenspin.report.figures import Picture, picture_of
from evenspin.report.page import Page
from evenspin.report.style import METHOD_COLOURS, OTHER_COLOURS

MOST_LINES = 10
MOST_PANELS = 12
TITLES = {
    "speed_rms_rpm": ("Speed ripple, rms", "ripple [rpm rms]"),
    "overshoot_rpm": ("Overshoot", "overshoot [rpm]"),
    "dip_rpm": ("Dip", "dip [rpm]"),
    "settled_s": ("Settling", "settled after [s]"),
    "n1_pct": ("First electrical order", "ripple [% of mean]"),
    "n2_pct": ("Second electrical order", "ripple [% of mean]"),
    "error_rms_mrad": ("Position error, rms without mean", "error [mrad rms]"),
    "error_max_mrad": ("Largest position error", "error [mrad]"),
}


def page_of(grid: Grid, command: str) -> Page:
    bad = [row for row in grid.rows if row["outcome"] != "ran"]
    facts = [("scenario", grid.scenario)]
    facts += [(name, ", ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in values))
              for name, values in grid.axes.items()]  # fmt: skip
    facts += [("set in every run", ", ".join(f"{name} = {value}" for name, value in grid.fixed.items()) or "nothing")]
    facts += [("did not run", f"{len(bad)} rows; the first: {bad[0]['why']}" if bad else "none")]
    return Page(
        title=f"Sweep of {grid.scenario}",
        summary="Every combination of these values, simulated with the firmware; sweep.csv has every column.",
        facts=facts,
        tables=[table_of(grid)],
        pictures=pictures(grid),
        command=command,
    )


def pictures(grid: Grid) -> list[Picture]:
    """One picture for each measure, over the axis of numbers with most values; a panel for each steady state."""
    over = abscissa(grid)
    return [_picture(grid, over, measure) for measure in grid.measures] if over else []


def abscissa(grid: Grid) -> str:
    """The axis that goes to the right; "" where none has numbers."""
    numeric = {
        name: len(values)
        for name, values in grid.axes.items()
        if len(values) > 1 and all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
    }
    return max(numeric, key=lambda name: numeric[name], default="")


def _picture(grid: Grid, over: str, measure: str) -> Picture:
    others = [name for name in grid.axes if name != over]
    places = list(dict.fromkeys((row["start_s"], row["speed_ref_rpm"]) for row in grid.rows if "start_s" in row))
    data: dict[str, Any] = {}
    panels = []
    for start_s, rpm in places[:MOST_PANELS]:
        here = [row for row in grid.rows if row.get("start_s") == start_s and row.get(measure) is not None]
        lines = _lines(here, over, others, measure, data, f"{start_s:g}s")
        if lines:
            title = f"from {start_s:g} s, {rpm:.4g} rpm" if len(places) > 1 else ""
            panels.append(Panel(lines, over, TITLES[measure][1], title, group=over))
    columns = 1 if len(panels) == 1 else 2
    text = f"Over {over}; a line for each combination of {', '.join(others)}." if others else f"Over {over}."
    return picture_of(measure, TITLES[measure][0], text, Chart(panels, columns, 260.0), data)


def _lines(
    rows: Sequence[Mapping[str, Any]], over: str, others: Sequence[str], measure: str, data: dict[str, Any], key: str
) -> list[Line]:
    found: list[Line] = []
    keys = list(dict.fromkeys(tuple(row[name] for name in others) for row in rows))
    for index, values in enumerate(keys[:MOST_LINES]):
        mine = sorted((row[over], row[measure]) for row in rows if tuple(row[name] for name in others) == values)
        x, y = np.array([each[0] for each in mine], dtype=float), np.array([each[1] for each in mine], dtype=float)
        label = ", ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in values) or measure
        colour = METHOD_COLOURS.get(label, OTHER_COLOURS[index % len(OTHER_COLOURS)])
        kind = POINTS if math.isclose(float(len(x)), 1.0) else "line"
        found.append(Line(label, x, y, colour, 1.4, kind=kind))
        data |= {f"{label}_{key}_{over}": x, f"{label}_{key}_{measure}": y}
    return found
