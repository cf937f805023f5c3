"""What a replay shows: tables for the screen and the page, pictures of every signal that moves."""

from __future__ import annotations

import numpy as np

from evenspin.replay.replayed import TIME, Replayed, state_name
from evenspin.report.chart import Chart, Line, Panel
from evenspin.report.curves import envelope
from evenspin.report.figures import Picture, picture_of
from evenspin.report.page import Page
from evenspin.report.style import OTHER_COLOURS
from evenspin.tableview import TableView

MOST_LINES = len(OTHER_COLOURS)
EARLIER_S = 0.001


def verdict_of(replayed: Replayed) -> str:
    """One line: the same, or where it differs first."""
    found = replayed.difference
    if found is None:
        return f"The firmware did the same in all {replayed.periods} PWM periods ({replayed.t_s:g} s), bit for bit."
    text = f"First difference in PWM period {found.period} ({found.t_s:g} s): {found.text}"
    if found.values:
        name, then, now = found.values[0]
        text += f"; {name} was {then!r}, is {now!r}"
        if found.kind != "DUTY":
            text += f" (stored row of period {found.row_period})"
    return f"{text}."


def tables_of(replayed: Replayed) -> list[TableView]:
    views = [_signals_table(replayed)] if len(replayed.record) else []
    if replayed.difference is not None and replayed.difference.values:
        views.append(_difference_table(replayed))
    return views


def page_of(replayed: Replayed, command: str) -> Page:
    head, fault = replayed.head, replayed.fault
    facts = (
        ("recording", replayed.path.name),
        ("of", f"{head.what}, seed {head.seed}, {'with' if head.linked else 'without'} a link"),
        ("firmware", f"{head.firmware}, {head.numeric}; recorded by {head.made_by}"),
        ("replayed", f"{replayed.periods} PWM periods, {replayed.t_s:g} s{', all of it' if replayed.whole else ''}"),
        ("result", verdict_of(replayed)),
        ("fault", f"{fault}: {fault.cause} Check first: {fault.check}" if fault else "none"),
    )
    return Page(
        title=f"Replay of {head.what}",
        summary="The firmware once more, from everything that it took in when it was recorded.",
        facts=facts,
        tables=tables_of(replayed),
        pictures=pictures_of(replayed),
        command=command,
    )


def pictures_of(replayed: Replayed) -> list[Picture]:
    """Signals that move, by unit; time from the fault, or from the end."""
    record = replayed.record
    if len(record) < 2:
        return []
    zero_s = replayed.fault.t_s if replayed.fault is not None else float(record[TIME][-1])
    t_ms = 1e3 * (record[TIME] - zero_s)
    by_unit: dict[str, list[str]] = {}
    for name, unit in zip(record.names[1:], record.units[1:], strict=True):
        column = record[name]
        if np.isfinite(column).any() and np.ptp(column[np.isfinite(column)]) > 0.0:
            by_unit.setdefault(unit, []).append(name)
    drawn = []
    for unit, names in by_unit.items():
        for part, first in enumerate(range(0, len(names), MOST_LINES)):
            drawn.append(_picture(replayed, unit, part, names[first : first + MOST_LINES], t_ms))
    return drawn


def _picture(replayed: Replayed, unit: str, part: int, names: list[str], t_ms: np.ndarray) -> Picture:
    lines: list[Line] = []
    data: dict[str, np.ndarray] = {}
    for name, colour in zip(names, OTHER_COLOURS, strict=False):
        x, y = envelope(t_ms, replayed.record[name])
        lines.append(Line(name, x, y, colour))
        data |= {f"{name}_t_ms": x, name: y}
    since = "fault" if replayed.fault is not None else "end"
    panel = Panel(lines, f"time from the {since} [ms]", unit or "-", group="time")
    label = {"": "states and counts", "unit": "correction"}.get(unit, unit)
    key = "".join(c if c.isalnum() else "_" for c in label)
    more = f", {part + 1}" if part else ""
    return picture_of(f"{key}_{part + 1}", f"{label}{more}", ", ".join(names), Chart([panel]), data)


def _signals_table(replayed: Replayed) -> TableView:
    record, fault = replayed.record, replayed.fault
    at = len(record) - 1 if fault is None else int(np.searchsorted(record[TIME], fault.t_s - 1e-9))
    earlier = max(0, at - round(EARLIER_S * replayed.head.pwm_hz))
    rows = [
        [name, unit, _shown(name, record[name][earlier]), _shown(name, record[name][at])]
        for name, unit in zip(record.names, record.units, strict=True)
    ]
    here = "at the fault" if fault is not None else "at the end"
    return TableView("Signals", f"All of them, 1 ms before and {here}.", ("signal", "unit", "1 ms before", here), rows)


def _difference_table(replayed: Replayed) -> TableView:
    found = replayed.difference
    assert found is not None
    rows = [[name, repr(then), repr(now), f"{now - then:.3g}"] for name, then, now in found.values]
    where = "" if found.row_period is None else f" Signals: as stored in period {found.row_period}."
    return TableView(
        "First difference",
        f"From PWM period {found.period} on: {found.text}.{where}",
        ("signal", "recorded", "replayed", "difference"),
        rows,
        ["bad"] * len(rows),
        1,
    )


def _shown(name: str, value: float) -> str:
    return state_name(value) if name == "state" else f"{value:.7g}"
