"""The paper's figures from our runs: error over the angle per turn (9 to 14), and over the motion (15, 16)."""

from __future__ import annotations

from typing import Any

import numpy as np

from evenspin.report.curves import envelope
from evenspin.report.figures import Picture
from evenspin.report.style import OTHER_COLOURS, REFERENCE_COLOUR, drawing, subplots, to_svg
from evenspin.reproduce.yeh2024.measure import START_S, TURN_RAD, TURNS, Array, turn_rows
from evenspin.reproduce.yeh2024.printed import SPEEDS_RPM
from evenspin.reproduce.yeh2024.result import Result, Run

NAMES = {"ppi": "P-PI", "silc": "SILC", "src": "SRC", "rdc": "RDC", "rdc-beyond": "RDC, beyond"}
COLOURS = {"ppi": "#8c8c8c", "silc": "#e08e0b", "src": "#1f6fb4", "rdc": "#0b8f6a", "rdc-beyond": "#7a4fb4"}
SHOWN_TURNS = (1, 2, 10)
MRAD = 1e3


def pictures(result: Result) -> list[Picture]:
    methods = [method for method in NAMES if any(run.method == method for run in result.runs)]
    with drawing():
        polar = [_polar(result, method) for method in methods]
        return [_rms(result, methods), _raw(result, methods), *polar, _motion(result, methods)]


def _polar(result: Result, method: str) -> Picture:
    """Error without its mean over the angle of the command."""
    runs = _runs(result, method)
    figure, axes = subplots(1, len(runs), height=3.9, subplot_kw={"projection": "polar"})
    data: dict[str, Array] = {}
    for panel, run in zip(axes.flat, runs, strict=True):
        curves = [(turn, *_of_turn(run, turn)) for turn in SHOWN_TURNS]
        reach = 1.5 * max(np.abs(error).max() for turn, _, error in curves if turn > 1)
        for colour, (turn, angle, error) in zip(OTHER_COLOURS, curves, strict=False):
            panel.plot(angle, error, color=colour, label=f"turn {turn}")
            key = f"{run.speed_rpm:g}rpm_turn{turn}"
            data |= {f"{key}_angle_deg": np.degrees(angle), f"{key}_error_mrad": error}
        panel.plot(np.linspace(0.0, TURN_RAD, 100), np.zeros(100), color=REFERENCE_COLOUR, linewidth=0.7)
        panel.set_ylim(-2.0 * reach, 1.1 * reach)
        panel.set_title(f"{run.speed_rpm:g} rpm")
        panel.tick_params(labelsize=6)
    _legend(figure, axes[0, 0])
    text = (
        "Angle of the command [deg]; radius: position error without its mean [mrad], the dark circle is 0. "
        "Turn 1 may leave the picture."
    )
    return Picture(f"polar_{method.replace('-', '_')}", f"Error per turn, {NAMES[method]}", text, to_svg(figure), data)


def _rms(result: Result, methods: list[str]) -> Picture:
    """RMS of every turn."""
    figure, axes = subplots(1, len(SPEEDS_RPM), height=3.2, sharey=True)
    turns = np.arange(1, TURNS + 1)
    data: dict[str, Array] = {"turn": turns.astype(float)}
    width = 0.85 / len(methods)
    for panel, rpm in zip(axes.flat, SPEEDS_RPM, strict=True):
        for index, method in enumerate(methods):
            run = result.run(method, rpm)
            if run is None:
                continue
            rms = MRAD * np.array(run.row["turn_rms"])
            at = turns + (index - (len(methods) - 1) / 2.0) * width
            panel.bar(at, rms, width, color=COLOURS[method], label=NAMES[method])
            data[f"{method}_{rpm:g}rpm_mrad"] = rms
        panel.set(title=f"{rpm:g} rpm", xlabel="turn [-]", yscale="log", xticks=turns)
        panel.grid(visible=False, axis="x")
    axes[0, 0].set_ylabel("rms without mean [mrad]")
    _legend(figure, axes[0, 0])
    text = "RMS of the position error of each turn without its mean; logarithmic. Turn 1 counts from 0.1 s."
    return Picture("rms", "Error by turns", text, to_svg(figure), data)


def _raw(result: Result, methods: list[str]) -> Picture:
    """Largest error with its mean."""
    figure, axes = subplots(1, 2, height=3.2, sharey=True)
    data: dict[str, Array] = {"speed_rpm": np.array(SPEEDS_RPM)}
    width = 0.85 / len(methods)
    groups = (("raw_max_turns_1_3", "turns 1 to 3"), ("raw_max_turn10", "turn 10"))
    for panel, (key, title) in zip(axes.flat, groups, strict=True):
        for index, method in enumerate(methods):
            runs = _runs(result, method)
            value = MRAD * np.array([run.row[key] for run in runs])
            at = np.arange(len(runs)) + (index - (len(methods) - 1) / 2.0) * width
            panel.bar(at, value, width, color=COLOURS[method], label=NAMES[method])
            data[f"{method}_{key}_mrad"] = value
        panel.set(title=title, yscale="log", xticks=range(len(SPEEDS_RPM)), xlabel="speed [rpm]")
        panel.set_xticklabels([f"{rpm:g}" for rpm in SPEEDS_RPM])
        panel.grid(visible=False, axis="x")
    axes[0, 0].set_ylabel("largest error [mrad]")
    _legend(figure, axes[0, 0])
    text = "Largest distance between command and position, nothing taken off; logarithmic."
    return Picture("raw", "Largest error", text, to_svg(figure), data)


def _motion(result: Result, methods: list[str]) -> Picture:
    """Error over time at the highest speed."""
    figure, axes = subplots(1, 1, height=3.2)
    data: dict[str, Array] = {}
    for method in methods:
        run = result.run(method, SPEEDS_RPM[-1])
        if run is not None:
            t_s, error = envelope(run.record["t_s"], MRAD * run.record["position_error_rad"])
            axes[0, 0].plot(t_s, error, color=COLOURS[method], label=NAMES[method])
            data |= {f"{method}_t_s": t_s, f"{method}_mrad": error}
    axes[0, 0].set(xlabel="time [s]", ylabel="error [mrad]", xlim=(0.0, None))
    axes[0, 0].set_yscale("symlog", linthresh=0.1)
    _legend(figure, axes[0, 0])
    title = f"The whole motion at {SPEEDS_RPM[-1]:g} rpm"
    return Picture("motion", title, "Command less position; linear within 0.1 mrad.", to_svg(figure), data)


def _of_turn(run: Run, turn: int) -> tuple[Array, Array]:
    """(angle, error without mean in mrad)."""
    rows = turn_rows(run.record, turn)
    rows = rows[run.record["t_s"][rows] >= (START_S if turn == 1 else 0.0)]
    error = MRAD * run.record["position_error_rad"][rows]
    return envelope(run.record["position_ref_rad"][rows] - (turn - 1) * TURN_RAD, error - error.mean(), 800)


def _runs(result: Result, method: str) -> list[Run]:
    found = (result.run(method, rpm) for rpm in SPEEDS_RPM)
    return [run for run in found if run is not None]


def _legend(figure: Any, axes: Any) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=len(labels), handlelength=1.6)
