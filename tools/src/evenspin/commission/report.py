"""The files of a commissioning: what was found, what was before, and a page to sign."""

from __future__ import annotations

from pathlib import Path

from evenspin.bench.client import Drive
from evenspin.bench.schema import own_schema
from evenspin.commission.findings import Quality, Step
from evenspin.commission.work import Commissioned, drive_values, model_text
from evenspin.motor.files import DRIVE, MODEL, drive_toml
from evenspin.tune.gains import rounded

BEFORE, REPORT = "before.toml", "report.md"


def write_files(folder: Path, done: Commissioned, drive: Drive, before: str, command: str) -> None:
    """`before`: the parameters of the drive before the first step, as a file that can be pushed back."""
    (folder / BEFORE).write_text(before, encoding="utf-8")
    (folder / REPORT).write_text(report_text(done, drive, command), encoding="utf-8")
    if done.tuning is None or done.machine is None:
        return
    (folder / MODEL).write_text(model_text(done, "commissioned"), encoding="utf-8")
    found = done.tuning
    head = [f"Made by `{command}`: tuned for what was measured, goal {done.goal}."]
    if done.error:
        head.append(f"NOT GOOD, and not in the drive: {done.error}")
    text = drive_toml(rounded(drive_values(done)), found.comments, head, own_schema().hash)
    (folder / DRIVE).write_text(text, encoding="utf-8")


def report_text(done: Commissioned, drive: Drive, command: str) -> str:
    """A page for people: step by step, with quality, and lines to sign."""
    bounds = done.bounds
    asked = [f"{bounds.max_current_a:g} A"]
    asked += [f"{bounds.max_speed_rad_s:g} rad/s"] if bounds.max_speed_rad_s else []
    asked += [f"{bounds.max_voltage_v:g} V"] if bounds.max_voltage_v else []
    verdict = "GOOD" if done.good else "NOT GOOD"
    lines = [
        "# Commissioning",
        "",
        f"**{verdict}**" + (f": {done.error}" if done.error else ""),
        "",
        f"`{command}`, {drive.port}, {drive.info.name}, firmware {drive.info.firmware}; limits {', '.join(asked)}; "
        f"goal {done.goal}; {done.seconds:.0f} s on the bench.",
        "",
        "The drive has the values from before (`before.toml`)."
        if not done.good
        else "The drive holds the new parameters until it is switched off, or over that with `evenspin bench save`.",
        "",
    ]
    for step in done.steps:
        lines += _step(step)
    if done.tuning is not None:
        gains = done.tuning.gains
        lines += [
            "## Tuning",
            "",
            f"Phase margin of the current loop {gains.current['q'].phase_deg:.0f} deg, of the speed loop "
            f"{gains.speed.phase_deg:.0f} deg; distance from -1 in the worst case {gains.speed_worst.distance:.2f} "
            f"({gains.worst_case}).",
            "",
        ]
        for verdict_ in (*done.tuning.methods, *done.tuning.positions):
            text = f": {verdict_.text}" if verdict_.text else ""
            lines.append(f"* {verdict_.method}: {verdict_.word}{text}")
        lines.append("")
    lines += [
        "## Undo",
        "",
        "`evenspin commission --port PORT --undo DIR` puts the values of `before.toml` back.",
        "",
        "Performed by: ______________________  Date: ____________",
        "",
        "Checked by: ________________________  Date: ____________",
        "",
    ]
    return "\n".join(lines)


def _step(step: Step) -> list[str]:
    lines = [f"## {step.name}: {'good' if step.good else 'NOT GOOD'}", "", f"{step.goal}; {step.seconds:.1f} s.", ""]
    lines += ["| what | value | 95 % | unit | limits | |", "|---|---|---|---|---|---|"]
    lines += [_row(quality) for quality in step.qualities]
    lines += ["", *(f"* {note}" for note in step.notes), ""]
    return lines


def _row(quality: Quality) -> str:
    half = f"+- {quality.half:.2g}" if quality.half > 0.0 else ""
    limits = "" if quality.high >= 1e5 else f"{quality.low:.4g} .. {quality.high:.4g}"
    word = "good" if quality.good else "**NOT GOOD**"
    return f"| {quality.what} | {quality.value:.5g} | {half} | {quality.unit} | {limits} | {word} |"
