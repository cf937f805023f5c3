"""What a trial leaves: before, predicted and after as a table, as JSON and as a page, and the recordings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from numpy.typing import NDArray

from evenspin.bench.config import shortest
from evenspin.correct.proposal import Proposal
from evenspin.correct.quantities import RPM
from evenspin.correct.report import percent, proposal_tables
from evenspin.correct.trial import Row, Trial, shown
from evenspin.log.case import write_case, write_json
from evenspin.native import Field, tables
from evenspin.report.chart import Chart, Line, Panel
from evenspin.report.curves import envelope
from evenspin.report.figures import Picture, picture_of
from evenspin.report.page import Chapter, Page, write_page
from evenspin.report.style import OTHER_COLOURS
from evenspin.tableview import TableView, number

RESULT, BEFORE = "result.json", "before.toml"
COLOURS = {"before": OTHER_COLOURS[1], "after": OTHER_COLOURS[0]}


def trial_tables(trial: Trial) -> list[TableView]:
    """Before, predicted, after; then what the drive has now."""
    rows, marks = [], []
    for row in trial.rows:
        p = row.correction.predicted
        rows.append(
            (
                row.correction.name,
                f"{row.correction.spoils.what} [{row.correction.spoils.unit}]",
                number(row.before),
                f"{number(p.corrected)} ({number(p.low)} .. {number(p.high)})",
                number(row.after),
                percent(row.reduction),
                percent(row.of_effect),
                "yes" if row.kept else f"no: {row.why}",
            )
        )
        marks.append("good" if row.kept else "bad")
    text = (
        "less: of the quantity as measured. of the effect: of what stands above a healthy machine, as simulated. A "
        "correction that leaves more than 95 % is taken back."
    )
    if math.isfinite(trial.uneven[0]) and math.isfinite(trial.uneven[1]):
        text += (
            f" All ripple of the speed, rms: {number(trial.uneven[0])} before, {number(trial.uneven[1])} r/min after."
        )
    header = ("correction", "what is measured", "before", "predicted", "after", "less %", "of the effect %", "kept")
    results = TableView("Before, predicted, after", text, header, rows, marks)
    fields = tables().params
    values = [
        (name, shown(fields[name], old), shown(fields[name], trial.values[name]), fields[name].unit)
        for name, old in trial.values_before.items()
    ]
    return [results, TableView("Parameters in the drive", "", ("parameter", "before", "now", "unit"), values, left=1)]


def trial_summary(trial: Trial, saved: bool) -> str:
    """One or two sentences."""
    kept = [row for row in trial.rows if row.kept]
    back = [row.correction.name for row in trial.rows if not row.kept]
    parts = []
    if kept:
        whats = ", ".join(
            f"{row.correction.name} ({number(row.before)} to {number(row.after)} {row.correction.spoils.unit})"
            for row in kept
        )
        where = "saved" if saved else "not saved: gone with the power"
        parts.append(f"The drive keeps the correction of {whats}; {where}.")
    if back:
        parts.append(f"Taken back, because it did not help: {', '.join(back)}.")
    return " ".join(parts) or "There was nothing to try."


def trial_json(trial: Trial, saved: bool) -> dict[str, Any]:
    return {
        "corrections": [_row_json(row) for row in trial.rows],
        "kept": list(trial.kept),
        "saved": saved,
        "parameters_before": {name: float(shortest(v)) for name, v in trial.values_before.items()},
        "parameters": {name: float(shortest(v)) for name, v in trial.values.items()},
        "unevenness_rpm": {"before": _real(trial.uneven[0]), "after": _real(trial.uneven[1])},
        "runs": {name: list(run.records) for name, run in trial.runs.items()},
    }


def _row_json(row: Row) -> dict[str, Any]:
    c, p = row.correction, row.correction.predicted
    return {
        "name": c.name,
        "effects": list(c.effects),
        "what": c.spoils.what,
        "unit": c.spoils.unit,
        "before": _real(row.before),
        "predicted": _real(p.corrected),
        "predicted_low": _real(p.low),
        "predicted_high": _real(p.high),
        "healthy": _real(p.healthy),
        "predicted_without": _real(p.without),
        "after": _real(row.after),
        "reduction": _real(row.reduction),
        "reduction_of_effect": _real(row.of_effect),
        "predicted_change_over_measured": _real(row.agreement),
        "kept": row.kept,
        "taken_back_because": row.why,
    }


def _real(value: float) -> float | None:
    return float(f"{value:.6g}") if math.isfinite(value) else None


def write_trial(folder: Path, trial: Trial, proposal: Proposal, command: str, saved: bool) -> None:
    """result.json, before.toml, report.html, and a case folder for each run; into an existing folder."""
    write_json(folder / RESULT, trial_json(trial, saved))
    (folder / BEFORE).write_text(before_toml(trial.values_before, tables().params), encoding="utf-8")
    for name, run in trial.runs.items():
        (folder / name).mkdir()
        write_case(folder / name, run.meta, run.records)
    write_page(folder, trial_page(trial, proposal, command, saved))


def before_toml(values: Mapping[str, float], fields: Mapping[str, Field]) -> str:
    """As `evenspin bench config push` takes it: what the drive had before."""
    document = tomlkit.document()
    document.add(tomlkit.comment("What the drive had before. `evenspin bench config push` writes it back."))
    table = tomlkit.table()
    for name, value in values.items():
        kind = fields[name].kind
        table[name] = (
            fields[name].to_text(value)
            if kind == "choice"
            else bool(value)
            if kind == "flag"
            else int(value)
            if kind == "integer"
            else shortest(value)
        )
    document["drive"] = table
    return tomlkit.dumps(document)


def trial_page(trial: Trial, proposal: Proposal, command: str, saved: bool) -> Page:
    return Page(
        title=f"Corrected in the drive: {proposal.case}",
        summary=trial_summary(trial, saved),
        facts=[("verdict", ", ".join(proposal.verdict) or "nothing is missing")],
        tables=[],
        pictures=[],
        command=command,
        chapters=trial_chapters(trial, proposal),
    )


def trial_chapters(trial: Trial, proposal: Proposal) -> list[Chapter]:
    """What was measured, then what was proposed."""
    measured = Chapter(
        "Before, predicted, after",
        "The same experiments on the drive, without and with the corrections.",
        [*trial_tables(trial), *_pictures(trial)],
    )
    return [measured, Chapter("What was proposed", "", proposal_tables(proposal))]


def _pictures(trial: Trial) -> list[Picture]:
    last = next((run for name, run in reversed(list(trial.runs.items())) if name != "before"), None)
    if last is None:
        return []
    found = []
    for name, record in trial.runs["before"].records.items():
        if name not in last.records or not record["speed_ref_rad_s"].any():
            continue
        drawn: list[Line] = []
        data: dict[str, NDArray[np.float64]] = {}
        for when, each in (("before", record), ("after", last.records[name])):
            off = (each["speed_rad_s"] - each["speed_ref_rad_s"]) / RPM
            t_s, rpm = envelope(each["t_s"], off)
            drawn.append(Line(when, t_s, rpm, COLOURS[when]))
            data |= {f"{when}_t_s": t_s, f"{when}_rpm": rpm}
        least = float(np.percentile(np.abs(data["before_rpm"]), 97)) or 1.0
        panel = Panel(drawn, "time [s]", "speed less reference [r/min]", y_range=(-1.5 * least, 1.5 * least))
        text = "Speed less its reference, without and with the corrections. Peaks of steps are cut off."
        found.append(picture_of(f"speed-{name}", f"Speed error: {name}", text, Chart([panel]), data))
    return found
