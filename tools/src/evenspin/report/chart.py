"""What a picture shows, in numbers: panels of lines, points and bars with labelled axes. `svg` draws it, and the page
of a report draws it again where it can be zoomed."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.report.style import REFERENCE_COLOUR

Array = NDArray[np.float64]
Range = tuple[float, float]

LINE, POINTS, BARS = "line", "points", "bars"


@dataclass(frozen=True, slots=True)
class Line:
    """`x` and `y` of one length; nan interrupts a line. `bar_width`: of BARS, in units of x. What has the colour of a
    reference is drawn in the ink of the page, light or dark."""

    label: str
    x: Array
    y: Array
    colour: str
    width: float = 1.0
    dashed: bool = False
    kind: str = LINE
    bar_width: float = 0.0


@dataclass(frozen=True, slots=True)
class Panel:
    """One pair of axes. Panels of the same `group` have the same x: cursor and zoom go through all of them."""

    lines: Sequence[Line]
    x_label: str
    y_label: str
    title: str = ""
    x_range: Range | None = None
    y_range: Range | None = None
    log_y: bool = False
    x_ticks: Sequence[float] | None = None
    group: str = ""


@dataclass(frozen=True, slots=True)
class Chart:
    """Panels in rows of `columns`; `height_px` of each panel with its labels."""

    panels: Sequence[Panel]
    columns: int = 1
    height_px: float = 260.0


def chart_json(chart: Chart) -> str:
    """For the page, which may stand within <script>: no character of it ends that element."""
    panels = [
        {
            "title": panel.title,
            "x": panel.x_label,
            "y": panel.y_label,
            "x_range": panel.x_range,
            "y_range": panel.y_range,
            "log": panel.log_y,
            "group": panel.group,
            "lines": [_line_json(line) for line in panel.lines],
        }
        for panel in chart.panels
    ]
    height = round(chart.height_px)
    text = json.dumps({"columns": chart.columns, "height": height, "panels": panels}, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def _line_json(line: Line) -> dict[str, Any]:
    return {
        "label": line.label,
        "colour": line.colour,
        "width": line.width,
        "dashed": line.dashed,
        "ink": line.colour == REFERENCE_COLOUR,
        "kind": line.kind,
        "bar_width": line.bar_width,
        "x": _numbers(line.x, "%.10g"),
        "y": _numbers(line.y, "%.6g"),
    }


def _numbers(values: Array, digits: str) -> list[float | None]:
    """As many digits as a screen can show; more in x, where steps are close."""
    values = np.asarray(values, dtype=float)
    rounded = np.char.mod(digits, values).astype(float) if len(values) else values
    return [value if math.isfinite(value) else None for value in rounded.tolist()]
