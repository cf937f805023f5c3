"""report.html: where the gap is, what explains it, how much, and what stays unexplained."""

from __future__ import annotations

import math

import numpy as np

from evenspin.balance.analysis import Analysis
from evenspin.balance.formatting import amperes
from evenspin.balance.judge_lines import missing_lines
from evenspin.balance.pictures import pictures
from evenspin.balance.regression import rms
from evenspin.balance.unexplained import unexplained_of
from evenspin.balance.verdict import Verdict
from evenspin.balance.verdict_file import gap_of, identified, is_clear
from evenspin.report.page import Page
from evenspin.tableview import TableView, number

MAIN_LINES = 3  # that are described in words
FALLS = 0.99  # of the gap: a name that takes less is reported without a falling gap
SPEED_BANDS = 5  # per direction
LABELS = {
    "inertia.inertia_as2_per_rad": ("J/Kt", "A s^2/rad"),
    "viscous_friction.viscous_as_per_rad": ("B/Kt", "A s/rad"),
    "coulomb_friction.torque_a_equiv": ("Tc/Kt", "A"),
    "load_torque.torque_a_equiv": ("load/Kt", "A"),
    "stribeck_friction.torque_a_equiv": ("Stribeck/Kt", "A"),
    "drag.torque_a_equiv": ("drag/Kt at this speed", "A"),
    "drag_beyond_model.torque_a_equiv": ("drag/Kt beyond the model", "A"),
}


def summary_of(analysis: Analysis, verdict: Verdict) -> list[str]:
    """The story in a few sentences."""
    before, after = gap_of(analysis)
    said = [f"Verdict: {', '.join(verdict.names) or _nothing(analysis, verdict)}."]
    if math.isfinite(before):
        named = [name for name in verdict.names if name != "unknown"]
        if named and after < FALLS * before:
            said.append(
                f"On stretches that were not fitted the torque balance is off by {amperes(before)} rms before and "
                f"{amperes(after)} after ({after / before:.2f} of it)."
            )
        else:
            left = unexplained_of(analysis)
            beside = f" (noise alone: {amperes(left.noise_a)})" if left is not None else ""
            said.append(
                f"On stretches that were not fitted the torque balance is off by {amperes(min(before, after))} "
                f"rms{beside}."
            )
    if any("cogging" in name for name in verdict.names) and analysis.inertia_known:
        strongest = ", ".join(
            f"order {each.line.order:g}: {amperes(each.line.amplitude_a)}"
            for each in missing_lines(analysis)[:MAIN_LINES]
        )
        said.append(f"Orders of the angle: {strongest}.")
    if analysis.controller is not None and len(analysis.controller.parts) == 2:
        plain = [part for part in analysis.controller.parts if part.plain]
        if len(plain) == 1:
            said.append(
                f"From {plain[0].start_s:.2f} to {plain[0].end_s:.2f} s the drive is uncompensated: there the current "
                "is "
                f"{analysis.controller.gain_as_per_rad:.4f} A s/rad times the speed error and nothing more."
            )
    if analysis.ripple is not None:
        said.append(
            f"With the effect the simulated drive has {analysis.ripple.simulated_rms:.2f} rad/s rms of speed ripple, "
            "the "
            f"measured {analysis.ripple.measured_rms:.2f}; without it {analysis.ripple.without_rms:.2f}."
        )
    said += [f"Left: {text}." for text in verdict.unexplained]
    return said


def _nothing(analysis: Analysis, verdict: Verdict) -> str:
    """No name is no all-clear, unless the balance is at its noise."""
    if not analysis.judges:
        return "none; this log allows no judgement"
    if is_clear(analysis, verdict):
        return "nothing that stands out is missing"
    return "no effect of the table; but something is left"


def tables_of(analysis: Analysis, verdict: Verdict) -> list[TableView]:
    tables = [_where(analysis)] if analysis.friction is not None or analysis.controller is not None else []
    tables += [_found(verdict), _shaft(analysis)]
    if analysis.angle is not None and analysis.angle.lines:
        tables.append(_orders(analysis))
    if analysis.windings:
        tables.append(_windings(analysis))
    notes = [("warning", text) for text in verdict.warnings] + [("left", text) for text in verdict.unexplained]
    notes += [("repair", text) for text in analysis.log.repairs] + [("limit", text) for text in analysis.log.limits]
    tables.append(
        TableView("What to know", "Repairs, limits, warnings, and what is left unexplained.", ("", ""), notes)
    )
    return tables


def _where(analysis: Analysis) -> TableView:
    """Where the gap is, largest first."""
    rows: list[tuple[float, tuple[str, str, str, str]]] = []
    if analysis.friction is not None:
        found = analysis.friction
        speed = found.motion.speed_rad_s
        edges = np.linspace(0.0, float(np.max(np.abs(speed[found.validation_rows]))) + 1e-9, SPEED_BANDS + 1)
        for sign, word in ((1.0, "forward"), (-1.0, "backward")):
            for low, high in zip(edges[:-1], edges[1:], strict=True):
                inside = found.validation_rows & (sign * speed >= low) & (sign * speed < high)
                if np.count_nonzero(inside) > 20:
                    before_a, after_a = rms(found.before[inside]), rms(found.after[inside])
                    place = f"{word}, {low:.0f} to {high:.0f} rad/s"
                    rows.append((before_a, ("torque balance", place, f"{1e3 * before_a:.1f}", f"{1e3 * after_a:.1f}")))
    if analysis.controller is not None:
        for part in analysis.controller.parts:
            place = f"{part.start_s:.2f} to {part.end_s:.2f} s, " + ("uncompensated" if part.plain else "compensated")
            said = f"speed {part.speed_ripple_rad_s:.2f} rad/s", f"beside the controller {1e3 * part.added_a:.0f} mA"
            rows.append((part.speed_ripple_rad_s, ("ripple rms", place, *said)))
    ranked = [row for _, row in sorted(rows, key=lambda each: -each[0])]
    text = "Residue on the validation stretches by speed and direction, mA rms, and ripple of each part, largest first."
    return TableView("Where the gap is", text, ("what", "where", "before", "after"), ranked)


def _found(verdict: Verdict) -> TableView:
    rows, marks = [], []
    for name in verdict.names:
        numbers = ", ".join(f"{key} = {value:.4g}" for key, value in verdict.parameters.get(name, {}).items())
        takes = verdict.takes_a.get(name)
        rows.append((name, f"named; {numbers}" if numbers else "named", "-" if takes is None else f"{1e3 * takes:.1f}"))
        marks.append("good" if name != "unknown" else "bad")
    for name, why in verdict.against:
        rows.append((name, why, "-"))
        marks.append("")
    for name, _, why in verdict.alternatives:
        rows.append((name, f"not excluded: {why}", "-"))
        marks.append("")
    text = "Every effect of the table that a torque balance can see, with the evidence for or against it."
    return TableView("What explains it", text, ("effect", "evidence", "takes mA rms"), rows, marks)


def _shaft(analysis: Analysis) -> TableView:
    rows = []
    for key, each in identified(analysis).items():
        name, unit = LABELS.get(key, (key, "A"))
        rows.append((name, unit, f"{each['value']:.4g}", f"{each['half']:.2g}"))
    text = (
        "+-: half of the 95 % interval. It counts stretches of the log, not rows, because the residual is coloured; it "
        "includes noise of the angle, for half a row between the samples of current and angle, and for what one "
        "machine differs by from log to log."
    )
    return TableView("The shaft, in ampere equivalents", text, ("", "unit", "value", "+-"), rows)


def _orders(analysis: Analysis) -> TableView:
    assert analysis.angle is not None
    meaning = analysis.windings[0].meaning if analysis.windings else {}
    rows = [
        (
            f"{each.line.order:g}",
            meaning.get(int(each.line.order), "-"),
            number(1e3 * each.line.amplitude_a) if analysis.inertia_known else "-",
            number(1e3 * each.half_a),
            number(1e3 * each.noise_a),
            f"{100.0 * each.agree:.0f}",
            "yes" if each.validated else "no",
        )
        for each in analysis.angle.lines
    ]
    text = "Strongest first. A line counts when all parts of the log have it with like amplitude and phase."
    header = ("order", "would be", "mA", "+- mA", "noise mA", "halves differ %", "in both")
    return TableView("Orders of the angle", text, header, rows)


def _windings(analysis: Analysis) -> TableView:
    rows = [(f"{w.slots}", f"{w.pole_pairs}", f"{100.0 * w.covered:.0f}", f"{w.score:.2f}") for w in analysis.windings]
    text = (
        "Slots and pole pairs that would make these orders, best first. The scores differ little: the name plate, or "
        "the back-EMF "
        "of one turn by hand (pole pairs = periods per turn), decides."
    )
    return TableView(
        "Which machine makes such orders", text, ("slots", "pole pairs", "covers %", "score"), rows, left=0
    )


def page_of(analysis: Analysis, verdict: Verdict, command: str) -> Page:
    facts = [
        ("log", analysis.log.path.name),
        ("rows", f"{len(analysis.log.t_s)}, {1e3 * analysis.log.period_s:.4g} ms apart"),
        ("kind", "the speed sweeps" if analysis.sweeps else "the speed stays near one level"),
        (
            "model",
            analysis.nominal.machine.name if analysis.nominal is not None else "none: everything in ampere equivalents",
        ),
    ]
    if analysis.lag.known:
        facts.append(("speed estimate", f"{1e3 * analysis.lag.delay_s:.2f} ms later than the angle; corrected"))
    if analysis.current_later_s:
        facts.append(("current", f"logged {1e3 * analysis.current_later_s:.2f} ms later than the angle; corrected"))
    summary = " ".join(summary_of(analysis, verdict))
    return Page("Gap: torque balance", summary, facts, tables_of(analysis, verdict), pictures(analysis), command)
