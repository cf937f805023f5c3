"""What was found, for the terminal and for report.html."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.driven.findable import Findable
from evenspin.driven.judge import Verdict
from evenspin.driven.read import Log, Nominal
from evenspin.driven.verdict_file import clear, gap_of, method_of
from evenspin.empirical.pictures import term_pictures, terms_view
from evenspin.empirical.term import EmpiricalTerm
from evenspin.gap.intervals import reported_parameters
from evenspin.native import tables
from evenspin.report.figures import Picture
from evenspin.report.page import Page
from evenspin.report.style import OTHER_COLOURS, drawing, subplots, to_svg
from evenspin.tableview import TableView, number
from evenspin.weakform.analysis import Explained

Array = NDArray[np.float64]

DOTS = 2500
SHOWN = 8
BEFORE, AFTER = OTHER_COLOURS[1], OTHER_COLOURS[0]


def summary_of(found: Explained, verdict: Verdict, advised: str) -> list[str]:
    before, after = gap_of(verdict.gaps)
    nothing = "nothing that stands out is missing" if clear(verdict) else "no name"
    said = [
        f"Verdict: {', '.join(map(verdict.name, verdict.names)) or nothing} (tolerances of a {found.tolerances.name})."
    ]
    if verdict.names and not verdict.unknown:
        said.append(
            f"On stretches that no fit saw the equations are off by {before:.2f} times the noise before "
            f"and {after:.2f} after."
        )
    else:
        said.append(f"On stretches that no fit saw the equations are off by {after:.2f} times the noise.")
    said += [f"Left: {text}." for text in verdict.unexplained]
    if verdict.nearest:
        said.append(
            f"Nearest: {', '.join(verdict.nearest)}; no name is given beside a cause that the table does not have."
        )
    said += [f"Note: {text}." for text in verdict.warnings]
    said.append(f"Record next: {advised}.")
    return said


def tables_of(
    found: Explained, verdict: Verdict, table: list[Findable], terms: Sequence[EmpiricalTerm] = ()
) -> list[TableView]:
    views = []
    if verdict.effects:
        views.append(_named(verdict))
    if terms:
        views.append(terms_view(terms))
    views += [_gaps(verdict), _choices(found), findable_view(table)]
    return views


def findable_view(table: list[Findable]) -> TableView:
    rows = [
        (each.effect, number(each.times) if math.isfinite(each.times) else "not", each.why)
        for each in sorted(table, key=lambda each: each.times)
    ]
    text = "Smallest size that these logs show, in units of the least size that counts as an effect."
    return TableView("What can be found", text, ("effect", "from", "why"), rows, left=1)


def _named(verdict: Verdict) -> TableView:
    rows = []
    for effect, params in verdict.effects:
        halves = {i.parameter: i.half for i in verdict.intervals[effect]}
        for key, value in reported_parameters(effect, params).items():
            unit = tables().effects[effect].params[key].unit
            rows.append(
                (
                    verdict.name(effect),
                    key,
                    number(value, 4),
                    number(halves.get(key)),
                    unit,
                    number(verdict.confidence[effect]),
                )
            )
    return TableView(
        "Missing in the model", "95 % intervals.", ("effect", "parameter", "value", "+-", "unit", "confidence"), rows
    )


def _gaps(verdict: Verdict) -> TableView:
    rows = [(g.log, g.equation, number(g.before), number(g.after), number(g.floor), g.unit) for g in verdict.gaps]
    text = "rms on stretches that no fit saw: with the model, with what was found, and of noise alone."
    return TableView("Gap", text, ("log", "equation", "before", "after", "noise", "unit"), rows)


def _choices(found: Explained) -> TableView:
    best = found.rivals[0].cost
    rows = [(" + ".join(sorted(c.names)) or "nothing", number(c.cost - best)) for c in found.rivals[:SHOWN]]
    text = "Cost beyond that of the best: a difference of 10 and more decides."
    return TableView("What explains the logs", text, ("terms", "cost"), rows, left=1)


def page_of(
    found: Explained,
    verdict: Verdict,
    table: list[Findable],
    advised: str,
    nominal: Nominal,
    logs: list[Log],
    command: str,
    terms: Sequence[EmpiricalTerm] = (),
) -> Page:
    facts = [("method", method_of(logs)), ("model", nominal.machine.name), ("tolerances", found.tolerances.name)]
    for log in logs:
        s = log.signals
        facts.append(
            (
                s.name,
                f"{len(s)} rows, {1e3 * s.period_s:.4g} ms apart; {'with' if s.has_voltages else 'without'} voltages",
            )
        )
        facts += [("repaired", text) for text in log.repairs]
        facts += [("doubt", text) for text in log.doubts]
    summary = " ".join(summary_of(found, verdict, advised))
    with drawing():
        pictures = [_over_speed(found, log) for log in range(len(logs))]
        pictures = [*term_pictures(terms), *pictures]
    return Page(
        "Gap: driven by what was measured", summary, facts, tables_of(found, verdict, table, terms), pictures, command
    )


def _over_speed(found: Explained, log: int) -> Picture:
    recording = found.recordings[log]
    windows = recording.equations.windows()
    keep = [0, *range(2, len(windows))]
    names = {0: "torque [N m]", 2: "d axis [V]", 3: "q axis [V]"}
    figure, axes = subplots(1, len(keep), height=3.4)
    data: dict[str, Any] = {}
    for column, k in enumerate(keep):
        rows = np.flatnonzero(recording.unseen[k])
        rows = rows[:: max(1, len(rows) // DOTS)]
        speed = windows[k].at_centre(recording.signals.speed_rad_s)[rows]
        panel = axes[0, column]
        for parts, label, colour in ((found.before, "before", BEFORE), (found.after, "after", AFTER)):
            panel.plot(speed, parts[log][k][rows], ".", markersize=1.8, alpha=0.5, color=colour, label=label)
            data[f"{names[k].split(' ')[0]}_{label}"] = parts[log][k][rows]
        data[f"{names[k].split(' ')[0]}_speed_rad_s"] = speed
        panel.set(xlabel="speed [rad/s]", ylabel=names[k])
    axes[0, 0].legend(markerscale=4)
    text = f"{recording.signals.name}: what each equation leaves on stretches that no fit saw, against speed."
    return Picture(f"left_{log + 1}", f"What is left in {recording.signals.name}", text, to_svg(figure), data)
