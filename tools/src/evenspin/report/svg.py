"""A chart as an <svg> element, without a plotting library: dozens of panels take milliseconds.

Colours are attributes, so that a file opens in any program, and every part has a class by which a page may change them.
The same chart always gives the same text.
"""

from __future__ import annotations

import math
from html import escape

import numpy as np
from numpy.typing import NDArray

from evenspin.report.chart import BARS, POINTS, Chart, Line, Panel
from evenspin.report.style import REFERENCE_COLOUR
from evenspin.report.ticks import decade_ticks, linear_ticks, padded, tick_texts

Array = NDArray[np.float64]

WIDTH = 960.0
LEFT, RIGHT, TOP, BOTTOM, LEGEND, TITLE = 64.0, 10.0, 8.0, 42.0, 24.0, 18.0
PX_PER_X_TICK, PX_PER_Y_TICK, PX_PER_LETTER = 90.0, 45.0, 7.0
INK, SOFT, GRID = "#1c2126", "#5d6873", "#dde2e7"
FONT = "system-ui, 'DejaVu Sans', sans-serif"
LEAST_POSITIVE = 1e-12


def svg_of(chart: Chart, name: str) -> str:
    """The whole chart: one legend above, then the panels in rows. `name` keeps it apart from others on its page."""
    rows = -(-len(chart.panels) // chart.columns)
    height = TOP + LEGEND + rows * chart.height_px
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="es-chart" viewBox="0 0 {WIDTH:g} {height:g}" '
        f'width="{WIDTH:g}" height="{height:g}" font-family="{FONT}" font-size="12">',
        f'<rect class="es-back" width="{WIDTH:g}" height="{height:g}" fill="#ffffff"/>',
        *_legend(chart),
    ]
    wide = WIDTH / chart.columns
    for index, panel in enumerate(chart.panels):
        row, column = divmod(index, chart.columns)
        parts += _panel(
            panel, f"{name}-{index}", column * wide, TOP + LEGEND + row * chart.height_px, wide, chart.height_px
        )
    return "\n".join([*parts, "</svg>\n"])


def _legend(chart: Chart) -> list[str]:
    """Each label once, from the right."""
    lines = {line.label: line for panel in chart.panels for line in panel.lines if line.label}
    parts: list[str] = []
    x = WIDTH - RIGHT
    for line in reversed(lines.values()):
        x -= PX_PER_LETTER * len(line.label)
        parts.append(_text(x, TOP + 10, line.label, "start", INK, "es-ink"))
        x -= 30
        dash = ' stroke-dasharray="5 3"' if line.dashed else ""
        if line.kind == POINTS:
            dot = f'cx="{x + 12:.1f}" cy="{TOP + 6:g}" r="{1.5 * line.width:g}" fill="{line.colour}"'
            parts.append(f"<circle {dot}/>")
            x -= 14
            continue
        parts.append(
            f'<line class="{_class(line)}" x1="{x:.1f}" x2="{x + 24:.1f}" y1="{TOP + 6:g}" y2="{TOP + 6:g}" '
            f'stroke="{line.colour}" stroke-width="{max(line.width, 1.5):g}"{dash}/>'
        )
        x -= 14
    return parts


def _panel(panel: Panel, name: str, left: float, top: float, wide: float, high: float) -> list[str]:
    x0, x1 = left + LEFT, left + wide - RIGHT
    y0, y1 = top + (TITLE if panel.title else 4.0), top + high - BOTTOM
    low_x, high_x = panel.x_range or _extent([line.x for line in panel.lines], 0.0)
    low_y, high_y = panel.y_range or _extent([line.y for line in panel.lines], 0.05)

    def place_x(value: Array) -> Array:
        return x0 + (np.asarray(value, dtype=float) - low_x) * ((x1 - x0) / (high_x - low_x))

    def place_y(value: Array) -> Array:
        if not panel.log_y:
            return y1 - (np.asarray(value, dtype=float) - low_y) * ((y1 - y0) / (high_y - low_y))
        share = np.log10(np.maximum(value, LEAST_POSITIVE) / low_y) / math.log10(high_y / low_y)
        return y1 - share * (y1 - y0)

    parts = [_text(x0, top + 11, panel.title, "start", INK, "es-ink", weight="600")] if panel.title else []
    x_ticks = list(panel.x_ticks or linear_ticks(low_x, high_x, int((x1 - x0) / PX_PER_X_TICK)))
    y_ticks = (
        decade_ticks(low_y, high_y) if panel.log_y else linear_ticks(low_y, high_y, int((y1 - y0) / PX_PER_Y_TICK))
    )
    for x, text in zip(place_x(np.array(x_ticks)), tick_texts(x_ticks), strict=True):
        parts += [_grid(x, x, y0, y1), _text(x, y1 + 15, text, "middle", SOFT, "es-soft", size=11)]
    for y, text in zip(place_y(np.array(y_ticks)), tick_texts(y_ticks), strict=True):
        parts += [_grid(x0, x1, y, y), _text(x0 - 6, y + 4, text, "end", SOFT, "es-soft", size=11)]
    parts.append(
        f'<clipPath id="{name}"><rect x="{x0:g}" y="{y0:g}" width="{x1 - x0:g}" height="{y1 - y0:g}"/></clipPath>'
    )
    parts.append(f'<g clip-path="url(#{name})" fill="none" stroke-linejoin="round">')
    for line in panel.lines:
        x, y = place_x(line.x), np.clip(place_y(line.y), y0 - high, y1 + high)
        parts.append(_bars(line, x, y, y1, (x1 - x0) / (high_x - low_x)) if line.kind == BARS else _drawn(line, x, y))
    parts.append("</g>")
    parts.append(f'<path class="es-axis" d="M{x0:g} {y0:g}V{y1:g}H{x1:g}" fill="none" stroke="{SOFT}"/>')
    middle_y = (y0 + y1) / 2.0
    parts.append(_text((x0 + x1) / 2.0, y1 + 33, panel.x_label, "middle", INK, "es-ink"))
    parts.append(_text(left + 14, middle_y, panel.y_label, "middle", INK, "es-ink", turn=True))
    return parts


def _drawn(line: Line, x: Array, y: Array) -> str:
    """A line, interrupted where a number is missing, or points."""
    known = np.isfinite(x) & np.isfinite(y)
    if line.kind == POINTS:
        path = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(x[known].tolist(), y[known].tolist(), strict=True))
        style = f'stroke-width="{3.0 * line.width:g}" stroke-linecap="round"'
    else:
        path = "".join(_run(x[part], y[part]) for part in _runs(known))
        style = f'stroke-width="{line.width:g}"' + (' stroke-dasharray="5 3"' if line.dashed else "")
    return f'<path class="{_class(line)}" d="{path}" stroke="{line.colour}" {style}/>'


def _run(x: Array, y: Array) -> str:
    pairs = np.column_stack((x, y)).ravel().tolist()
    return "M" + (("%.2f %.2f " * len(x)) % tuple(pairs))


def _runs(known: NDArray[np.bool_]) -> list[slice]:
    """Stretches without a gap."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], known, [False])).astype(np.int8)))
    return [slice(a, b) for a, b in edges.reshape(-1, 2).tolist()]


def _bars(line: Line, x: Array, y: Array, foot: float, px_per_x: float) -> str:
    wide = line.bar_width * px_per_x
    places = zip(x.tolist(), y.tolist(), strict=True)
    path = "".join(f"M{a - wide / 2:.2f} {foot:.2f}V{b:.2f}h{wide:.2f}V{foot:.2f}Z" for a, b in places if b < foot)
    return f'<path class="es-bars" d="{path}" fill="{line.colour}" stroke="none"/>'


def _class(line: Line) -> str:
    return "es-ref" if line.colour == REFERENCE_COLOUR else "es-line"


def _grid(x1: float, x2: float, y1: float, y2: float) -> str:
    return f'<path class="es-grid" d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}" stroke="{GRID}"/>'


def _text(
    x: float,
    y: float,
    text: str,
    anchor: str,
    colour: str,
    kind: str,
    *,
    size: int = 0,
    weight: str = "",
    turn: bool = False,
) -> str:
    more = (f' font-size="{size}"' if size else "") + (f' font-weight="{weight}"' if weight else "")
    more += f' transform="rotate(-90 {x:.1f} {y:.1f})"' if turn else ""
    at = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"'
    return f'<text class="{kind}" {at} fill="{colour}"{more}>{escape(text)}</text>'


def _extent(columns: list[Array], share: float) -> tuple[float, float]:
    """From the smallest to the largest number, with some room."""
    finite = [column[np.isfinite(column)] for column in (np.asarray(each, dtype=float) for each in columns)]
    values = np.concatenate(finite) if finite else np.empty(0)
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    return padded(low, high, share) if share or not high > low else (low, high)
