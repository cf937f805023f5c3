"""Two runs beside each other: what was set differently, every steady state and motion, curves over each other."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.analysis.segments import RAD_S
from evenspin.errors import InputError
from evenspin.log.csvfile import read_csv
from evenspin.report.chart import Chart, Line, Panel
from evenspin.report.curves import envelope
from evenspin.report.figures import TIME, Picture, picture_of
from evenspin.report.page import Page
from evenspin.report.style import OTHER_COLOURS
from evenspin.sim import Record
from evenspin.tableview import TableView, number

SUMMARY, TRUTH = "summary.json", "truth.csv"
SPEED_KEYS = {
    "speed_rms_rpm": "rms rpm",
    "n1_pct": "n1 %",
    "n2_pct": "n2 %",
    "overshoot_rpm": "over rpm",
    "dip_rpm": "dip rpm",
    "settled_s": "settled s",
}
POSITION_KEYS = {
    "error_rms_mrad": "error rms mrad",
    "error_max_mrad": "largest mrad",
    "speed_rms_rpm": "speed rms rpm",
    "settled_s": "settled s",
}
SAME_S, SAME_RPM = 1e-3, 0.01
TRUTH_UNITS = {"t_s": "s", "true_speed_rad_s": "rad/s", "true_iq_a": "A"}
HINT = "`evenspin run SCENARIO --out DIR` makes one"


@dataclass(frozen=True, slots=True)
class RunFolder:
    """What `evenspin run` left behind."""

    path: Path
    summary: Mapping[str, Any]

    def truth(self) -> Record:
        return read_csv(self.path / TRUTH, tuple(TRUTH_UNITS), tuple(TRUTH_UNITS.values()))


def read_run(path: Path) -> RunFolder:
    for name in (SUMMARY, TRUTH):
        if not (path / name).is_file():
            raise InputError("diff", "RUN", path, f"a folder of `evenspin run`; {name} is not in it", HINT)
    try:
        summary = json.loads((path / SUMMARY).read_text(encoding="utf-8"))
        missing = [key for key in ("segments", "drive", "plant", "effects", "method", "scenario") if key not in summary]
    except (ValueError, TypeError, OSError):
        raise InputError(path / SUMMARY, "file", "(unreadable)", "the summary of a run", HINT) from None
    if missing:
        raise InputError(path / SUMMARY, missing[0], None, "in the summary of a run", "make the run again")
    return RunFolder(path, summary)


def settings_table(one: RunFolder, other: RunFolder) -> TableView:
    """Parameters, numbers of the machine and effects that differ."""
    rows = [(name, _shown(a), _shown(b)) for name, a, b in _differences(one.summary, other.summary)]
    text = "What was set differently." if rows else "Both runs have the same settings."
    return TableView("Settings", text, ("name", "A", "B"), rows, left=3)


def _differences(one: Mapping[str, Any], other: Mapping[str, Any]) -> Iterator[tuple[str, Any, Any]]:
    for name in ("scenario", "numeric", "seed", "duration_s", "log_rate_hz"):
        if one.get(name) != other.get(name):
            yield name, one.get(name), other.get(name)
    for group in ("drive", "plant"):
        for name in dict.fromkeys([*one[group], *other[group]]):
            if one[group].get(name) != other[group].get(name):
                yield f"{group}.{name}", one[group].get(name), other[group].get(name)
    for effect in dict.fromkeys([*one["effects"], *other["effects"]]):
        a, b = one["effects"].get(effect, {}), other["effects"].get(effect, {})
        for name in dict.fromkeys([*a, *b]):
            if a.get(name) != b.get(name):
                yield f"effects.{effect}.{name}", a.get(name), b.get(name)


def _shown(value: Any) -> str:
    return "-" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value).lower()


def measures(one: RunFolder, other: RunFolder) -> list[dict[str, Any]]:
    """Steady states and motions that both have: where, and each number of A and of B."""
    found = []
    for kind, keys in (("motions", POSITION_KEYS), ("segments", SPEED_KEYS)):
        for a, b in _pairs(one.summary.get(kind, ()), other.summary.get(kind, ())):
            if kind == "segments" and one.summary.get("motions") and not a["speed_ref_rpm"]:
                continue
            at = {"kind": kind, "start_s": a["start_s"], "speed_ref_rpm": a["speed_ref_rpm"]}
            found.append(at | {key: (a.get(key), b.get(key)) for key in keys})
    return found


def _pairs(
    one: Sequence[Mapping[str, Any]], other: Sequence[Mapping[str, Any]]
) -> Iterator[tuple[Mapping[str, Any], Mapping[str, Any]]]:
    for a in one:
        for b in other:
            near = abs(a["start_s"] - b["start_s"]) < SAME_S + 2e-3 * a["start_s"]
            if near and abs(a["speed_ref_rpm"] - b["speed_ref_rpm"]) <= SAME_RPM * max(1.0, abs(a["speed_ref_rpm"])):
                yield a, b
                break


def tables_of(one: RunFolder, other: RunFolder) -> list[TableView]:
    rows = []
    for each in measures(one, other):
        keys = POSITION_KEYS if each["kind"] == "motions" else SPEED_KEYS
        place = (number(each["start_s"]), number(each["speed_ref_rpm"]))
        rows += [(*place, text, *_cells(each[key])) for key, text in keys.items() if None not in each[key]]
    text = "What both runs have at the same time and speed." if rows else "They have nothing in common."
    measured = TableView("Steady states and changes", text, ("from s", "rpm", "what", "A", "B", "B/A"), rows, left=3)
    return [settings_table(one, other), measured]


def _cells(pair: tuple[float | None, float | None]) -> tuple[str, str, str]:
    a, b = pair
    ratio = b / a if a and b is not None and math.isfinite(b / a) else None
    return number(a), number(b), number(ratio)


def pictures_of(one: RunFolder, other: RunFolder) -> list[Picture]:
    """Speed and current of both, and what lies between them."""
    records = [(side, run.truth()) for side, run in (("A", one), ("B", other))]
    drawn = []
    for name, title, column, scale, label in (
        ("speed", "Speed", "true_speed_rad_s", 1.0 / RAD_S, "speed [rpm]"),
        ("current", "q-axis current", "true_iq_a", 1.0, "q-axis current [A]"),
    ):
        lines: list[Line] = []
        data: dict[str, Any] = {}
        for index, (side, record) in enumerate(records):
            t_s, value = envelope(record["t_s"], scale * record[column])
            lines.append(Line(side, t_s, value, OTHER_COLOURS[index]))
            data |= {f"{side}_t_s": t_s, f"{side}_{column}": value}
        (_, a), (_, b) = records
        if len(a) == len(b) and np.allclose(a["t_s"], b["t_s"]):
            t_s, value = envelope(a["t_s"], scale * (b[column] - a[column]))
            apart = [Line("B less A", t_s, value, OTHER_COLOURS[3])]
            panels = [Panel(lines, "time [s]", label, group=TIME), Panel(apart, "time [s]", "B less A", group=TIME)]
        else:
            panels = [Panel(lines, "time [s]", label, group=TIME)]
        drawn.append(picture_of(name, title, "Of the true machine.", Chart(panels, 1, 250.0), data))
    return drawn


def page_of(one: RunFolder, other: RunFolder, command: str) -> Page:
    facts = [
        (side, f"{run.path}: {run.summary['scenario']}, {run.summary['method']}")
        for side, run in (("A", one), ("B", other))
    ]
    summary = "The same numbers of two runs, and their curves over each other."
    return Page("Two runs", summary, facts, tables_of(one, other), pictures_of(one, other), command)


def as_json(one: RunFolder, other: RunFolder) -> dict[str, Any]:
    found = [
        {key: {"a": value[0], "b": value[1]} if isinstance(value, tuple) else value for key, value in each.items()}
        for each in measures(one, other)
    ]
    settings = {name: {"a": a, "b": b} for name, a, b in _differences(one.summary, other.summary)}
    return {"a": str(one.path), "b": str(other.path), "settings": settings, "measures": found}
