"""Tables, JSON and the drive file of a tuning."""

from __future__ import annotations

import math
from typing import Any

from evenspin.model.machine import Machine
from evenspin.native import tables
from evenspin.tableview import TableView, number
from evenspin.tune.loops import Margins
from evenspin.tune.methods import Verdict
from evenspin.tune.tuning import Tuning, bandwidths

RPM = math.pi / 30.0


def tables_of(machine: Machine, found: Tuning) -> list[TableView]:
    views = [_margins(machine, found), _trials(found)]
    if found.methods:
        views.append(_methods(found))
    return views


def _margins(machine: Machine, found: Tuning) -> TableView:
    wide = bandwidths(machine.plant, found.drive)
    gains = found.gains

    def row(name: str, hz: float, margins: Margins) -> tuple[str, ...]:
        gain = "-" if not math.isfinite(margins.gain_db) else f"{margins.gain_db:.1f}"
        return (
            name,
            number(hz),
            f"{margins.phase_deg:.0f}",
            gain,
            number(1e3 * margins.delay_s),
            number(margins.distance),
        )

    rows = [row(f"current, {axis} axis", wide["current"], margins) for axis, margins in gains.current.items()]
    rows.append(row("current, worst case", wide["current"], gains.current_worst))
    rows.append(row("speed", wide["speed"], gains.speed))
    rows.append(row(f"speed, worst case: {gains.worst_case}", wide["speed"], gains.speed_worst))
    text = "Delay: what the loop takes in addition. Distance: from -1. Worst case: of [range], else of data sheets."
    header = ("loop", "bandwidth Hz", "phase deg", "gain dB", "delay ms", "distance")
    return TableView(f"{machine.name}, {found.goal.name}", text, header, rows, left=1)


def _trials(found: Tuning) -> TableView:
    rows, marks = [], []
    for trial in found.trials:
        for response in trial.responses[1:]:
            s = response.stretch
            dip = f"dip {number(response.dip_rad_s / RPM)}" if s.load_nm or s.name == "load off" else ""
            over = f"overshoot {number(response.overshoot_rad_s / RPM)}" if not dip else ""
            settled = "-" if not response.reached else number(1e3 * response.settled_s)
            speed = f"{s.reference_rad_s / RPM:.4g}"
            rows.append((trial.name, s.name, speed, f"{over}{dip}", settled, number(response.peak_a)))
            marks.append("good" if trial.good else "bad")
    text = " ".join(found.problems) or "Simulated with the firmware; currents stay within the limits of the drive."
    header = ("machine", "what", "to rpm", "rpm", "within 2 % after ms", "peak A")
    return TableView("Start, load step, reversal, full speed", text, header, rows, marks, left=2)


def _methods(found: Tuning) -> TableView:
    rows = [_method(verdict) for verdict in (*found.methods, *found.positions)]
    bad = ("harms", "cannot")
    marks = [
        "bad" if v.word in bad else "good" if v.word == "helps" else "" for v in (*found.methods, *found.positions)
    ]
    text = "Ripple, rms, under a torque of 2 % of the rated one per electrical turn and 1 % of its sixth order."
    return TableView("Methods", text, ("method", "verdict", "rpm", "without", "with", "unit", ""), rows, marks, left=2)


def _method(verdict: Verdict) -> tuple[str, ...]:
    cells = (number(verdict.without), number(verdict.with_it)) if verdict.without else ("-", "-")
    return (verdict.method, verdict.word, f"{verdict.speed_rad_s / RPM:.4g}", *cells, verdict.unit, verdict.text)


def drive_text(machine: Machine, found: Tuning, command: str) -> str:
    """The file: parameters with what they came from, margins and verdicts at the top."""
    from evenspin.bench.schema import own_schema
    from evenspin.motor.files import drive_toml

    gains = found.gains
    head = [
        f"Made by `{command}` for {machine.name}, goal {found.goal.name}: {found.goal.text}.",
        f"Current loop: phase margin {gains.current['q'].phase_deg:.0f}, worst "
        f"{gains.current_worst.phase_deg:.0f} deg. "
        f"Speed loop: {gains.speed.phase_deg:.0f} deg, distance from -1 {gains.speed.distance:.2f}, worst "
        f"{gains.speed_worst.distance:.2f}.",
    ]
    head += [f"NOT GOOD: {problem}" for problem in found.problems]
    for verdict in (*found.methods, *found.positions):
        if verdict.word in ("no use", "harms", "cannot"):
            head.append(f"{verdict.method}: {verdict.word}{f': {verdict.text}' if verdict.text else ''}")
    comments = dict(found.comments)
    if found.repetitive.reason == "":
        comments["rc_gain"] = f"stable below {found.repetitive.bound:.3g} at every speed, with fal at its largest gain"
    return drive_toml(found.drive, comments, head, own_schema().hash)


def as_json(machine: Machine, found: Tuning) -> dict[str, Any]:
    def verdict(v: Verdict) -> dict[str, Any]:
        ripple = {"speed_rad_s": v.speed_rad_s, "without": v.without, "with": v.with_it, "unit": v.unit}
        return {"method": v.method, "verdict": v.word, **ripple, "text": v.text}

    return {
        "model": machine.name,
        "goal": found.goal.name,
        "good": found.good,
        "problems": found.problems,
        "bandwidth_hz": bandwidths(machine.plant, found.drive),
        "margins": {
            **{f"current_{axis}": m.as_json() for axis, m in found.gains.current.items()},
            "current_worst": found.gains.current_worst.as_json(),
            "speed": found.gains.speed.as_json(),
            "speed_worst": found.gains.speed_worst.as_json() | {"case": found.gains.worst_case},
        },
        "rc_gain_bound": found.repetitive.bound,
        "top_speed_rad_s": found.top_rad_s,
        "trials": [
            {
                "machine": trial.name, "good": trial.good, "problems": list(trial.problems), "peak_a": trial.peak_a,
                "stretches": [
                    {
                        "what": r.stretch.name, "speed_rad_s": r.stretch.reference_rad_s, "mean_rad_s": r.mean_rad_s,
                        "overshoot_rad_s": r.overshoot_rad_s, "dip_rad_s": r.dip_rad_s, "settled_s": r.settled_s,
                    }
                    for r in trial.responses[1:]
                ],
            }
            for trial in found.trials
        ],
        "methods": [verdict(v) for v in found.methods],
        "position_methods": [verdict(v) for v in found.positions],
        "drive": {name: _plain(name, value) for name, value in found.drive.items()},
    }  # fmt: skip


def _plain(name: str, value: float) -> Any:
    from evenspin.motor.files import plain

    return plain(tables().params[name], value)
