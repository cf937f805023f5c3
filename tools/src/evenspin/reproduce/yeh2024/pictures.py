"""Pictures of the motions with the paper's numbers in them: error over the angle per turn (figures 9 to 14), over the
motion (15), and its largest and mean (16)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from evenspin.report.curves import envelope
from evenspin.report.figures import Picture
from evenspin.report.style import EXPERIMENT_COLOUR, OTHER_COLOURS, REFERENCE_COLOUR, drawing, subplots, to_svg
from evenspin.reproduce.yeh2024.measure import MRAD, START_S, TURN_RAD, TURNS, Array, turn_rows
from evenspin.reproduce.yeh2024.printed import SPEEDS_RPM, at_most, paper
from evenspin.reproduce.yeh2024.result import Result, Run

NAMES = {"ppi": "P-PI", "silc": "SILC", "src": "SRC", "rdc": "RDC", "rdc-beyond": "RDC, beyond"}
COLOURS = {"ppi": "#8c8c8c", "silc": "#e08e0b", "src": "#1f6fb4", "rdc": "#0b8f6a", "rdc-beyond": "#7a4fb4"}
SHOWN_TURNS = (1, 2, 10)
FROM_COMMAND = ("rdc",)  # whose MAX of turn 1 the paper counts from the command on
PRINTED: dict[str, Any] = {"color": EXPERIMENT_COLOUR, "marker": "D", "linestyle": "none", "markersize": 4, "zorder": 5}
LIMIT: dict[str, Any] = {"color": EXPERIMENT_COLOUR, "linestyle": "--", "linewidth": 1.0}


def pictures(result: Result) -> list[Picture]:
    methods = [method for method in NAMES if any(run.method == method for run in result.runs)]
    with drawing():
        polar = [polar_picture(result, method) for method in methods]
        return [rms_picture(result, methods), raw_picture(result, methods), *polar, motion_picture(result, methods)]


def _radii(panel: Any) -> None:
    """Few numbers, away from where a motion begins, on a ground of their own."""
    from matplotlib.ticker import MaxNLocator

    panel.yaxis.set_major_locator(MaxNLocator(4))
    panel.set_rlabel_position(292.5)
    for label in panel.get_yticklabels():
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8})


def polar_picture(result: Result, method: str) -> Picture:
    """Error without its mean over the angle of the command: turn 1 as large as it is, turns 2 and 10 close up."""
    runs = _runs(result, method)
    figure, axes = subplots(2, len(runs), height=7.4, subplot_kw={"projection": "polar"})
    data: dict[str, Array] = {}
    circle = np.linspace(0.0, TURN_RAD, 100)
    for column, run in enumerate(runs):
        curves = [(turn, *_of_turn(run, turn)) for turn in SHOWN_TURNS]
        for colour, (turn, angle, error) in zip(OTHER_COLOURS, curves, strict=False):
            for row in (0, 1):
                if turn == 1 or row == 1:
                    shown = {"label": f"turn {turn}"} if row == 1 else {}
                    axes[row, column].plot(angle, error, color=colour, **shown)
            key = f"{run.speed_rpm:g}rpm_turn{turn}"
            data |= {f"{key}_angle_deg": np.degrees(angle), f"{key}_error_mrad": error}
        first = max(float(np.abs(curves[0][2]).max()), MRAD * (paper(method, "max_turn1", run.speed_rpm) or 0.0))
        close = 1.5 * max(float(np.abs(error).max()) for turn, _, error in curves if turn > 1)
        keys = (
            ("max_turn1", first),
            ("max_turn10", max(close, MRAD * (paper(method, "max_turn10", run.speed_rpm) or 0.0))),
        )
        for row, (key, reach) in enumerate(keys):
            panel = axes[row, column]
            panel.plot(circle, np.zeros(100), color=REFERENCE_COLOUR, linewidth=0.7)
            value = paper(method, key, run.speed_rpm)
            if value is not None:
                label = "paper: MAX of the turn" if row == 0 and column == 0 else None
                panel.plot(circle, np.full(100, MRAD * value), label=label, **LIMIT)
                data[f"{run.speed_rpm:g}rpm_paper_{key}_mrad"] = np.array([MRAD * value])
            panel.set_ylim(-2.0 * reach, 1.1 * reach)
            panel.set_title(f"{run.speed_rpm:g} rpm, {'turn 1' if row == 0 else 'close up'} [mrad]")
            panel.tick_params(labelsize=6)
            _radii(panel)
    handles, labels = axes[1, 0].get_legend_handles_labels()
    more, words = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles + more, labels + words, loc="outside upper right", ncols=4, handlelength=1.6)
    start = "from the command on" if method in FROM_COMMAND else "from 0.1 s"
    text = (
        "Angle of the command [deg]; radius: position error without its mean [mrad], the dark circle is 0. Above: the "
        f"whole of turn 1, {start}; below: close up, where turn 1 may leave the picture."
    )
    return Picture(f"polar_{method.replace('-', '_')}", f"Error per turn, {NAMES[method]}", text, to_svg(figure), data)


def rms_picture(result: Result, methods: Sequence[str]) -> Picture:
    """RMS of every turn, and what the paper prints of them."""
    figure, axes = subplots(1, len(SPEEDS_RPM), height=3.6, sharey=True)
    turns = np.arange(1, TURNS + 1)
    data: dict[str, Array] = {"turn": turns.astype(float)}
    width = 0.85 / len(methods)
    for panel, rpm in zip(axes.flat, SPEEDS_RPM, strict=True):
        said: list[str] = []
        for index, method in enumerate(methods):
            run = result.run(method, rpm)
            if run is None:
                continue
            rms = MRAD * np.array(run.row["turn_rms"])
            at = turns + (index - (len(methods) - 1) / 2.0) * width
            panel.bar(at, rms, width, color=COLOURS[method], label=NAMES[method])
            data[f"{method}_{rpm:g}rpm_mrad"] = rms
            points = _printed_rms(method, rpm, rms[0])
            if points:
                # Where only a reduction is printed, it is that of our turn 1.
                panel.plot([at[turn - 1] for turn in points], list(points.values()), label="paper", **PRINTED)
            for key, x in (("turn1_rms", at[0]), ("turn10_rms", at[-1])):
                limit = at_most(method, key)
                if limit is not None:
                    panel.plot([x - 0.45, x + 0.45], [MRAD * limit] * 2, label="paper: at most", **LIMIT)
            said = _said(run) if len(methods) == 1 else []
        panel.set(title="\n".join([f"{rpm:g} rpm", *said]), xlabel="turn [-]", yscale="log", xticks=turns)
        panel.grid(visible=False, axis="x")
    axes[0, 0].set_ylabel("rms without mean [mrad]")
    _legend(figure, axes[0, 0])
    text = (
        "RMS of the position error of each turn without its mean; logarithmic. Turn 1 counts from 0.1 s. Diamonds: the "
        "paper, where it prints a reduction that of our turn 1."
    )
    return Picture("rms", "Error by turns", text, to_svg(figure), data)


def _printed_rms(method: str, rpm: float, first_mrad: float) -> dict[int, float]:
    """Turn: what the paper prints of its rms, mrad."""
    found = {}
    for turn, key, reduced in (
        (1, "turn1_rms", ""),
        (2, "", "turn2_reduction_pct"),
        (10, "turn10_rms", "turn10_reduction_pct"),
    ):
        value, reduction = paper(method, key, rpm), paper(method, reduced, rpm)
        if value is not None:
            found[turn] = MRAD * value
        elif reduction is not None:
            found[turn] = first_mrad * (1.0 - 0.01 * reduction)
    return found


def _said(run: Run) -> list[str]:
    """Reductions, ours and the paper's."""
    said = []
    for turn in (2, 10):
        key = f"turn{turn}_reduction_pct"
        theirs = paper(run.method, key, run.speed_rpm)
        if theirs is not None:
            said.append(f"turn {turn}: -{run.row[key]:.0f} %, paper -{theirs:.0f} %")
    return said


def raw_picture(result: Result, methods: Sequence[str]) -> Picture:
    """Figure 16: largest error with its mean, and that mean."""
    groups = (
        ("raw_max_turns_1_3", "MAX, turns 1 to 3"),
        ("raw_max_turn10", "MAX, turn 10"),
        ("avg_turn10", "AVG, turn 10"),
    )
    figure, axes = subplots(1, len(groups), height=3.2, sharey=True)
    data: dict[str, Array] = {"speed_rpm": np.array(SPEEDS_RPM)}
    width = 0.85 / len(methods)
    for panel, (key, title) in zip(axes.flat, groups, strict=True):
        for index, method in enumerate(methods):
            runs = _runs(result, method)
            value = MRAD * np.abs([run.row[key] for run in runs])
            at = np.arange(len(runs)) + (index - (len(methods) - 1) / 2.0) * width
            panel.bar(at, value, width, color=COLOURS[method], label=NAMES[method])
            data[f"{method}_{key}_mrad"] = value
            theirs = [(x, paper(method, key, run.speed_rpm)) for x, run in zip(at, runs, strict=True)]
            known = [(x, MRAD * each) for x, each in theirs if each is not None]
            if known:
                panel.plot(*zip(*known, strict=True), label="paper", **PRINTED)
            limit = at_most(method, key)
            if limit is not None:
                panel.plot([at[0] - width, at[-1] + width], [MRAD * limit] * 2, label="paper: at most", **LIMIT)
        panel.set(title=title, yscale="log", xticks=range(len(SPEEDS_RPM)), xlabel="speed [rpm]", ylim=(1e-3, 1e3))
        panel.set_xticklabels([f"{rpm:g}" for rpm in SPEEDS_RPM])
        panel.grid(visible=False, axis="x")
    axes[0, 0].set_ylabel("error [mrad]")
    _legend(figure, axes[0, 0], axes[0, 2])
    text = "Largest distance between command and position, nothing taken off, and its mean in turn 10; logarithmic."
    return Picture("raw", "Largest error and its mean", text, to_svg(figure), data)


def motion_picture(result: Result, methods: Sequence[str]) -> Picture:
    """Figure 15: error over time at every speed, the first three turns and the tenth."""
    figure, axes = subplots(len(SPEEDS_RPM), 2, height=6.6, sharey=True)
    data: dict[str, Array] = {}
    for row, rpm in enumerate(SPEEDS_RPM):
        for column, turns in enumerate(((1, 2, 3), (TURNS,))):
            panel = axes[row, column]
            for method in methods:
                run = result.run(method, rpm)
                if run is None:
                    continue
                rows = np.concatenate([turn_rows(run.record, turn) for turn in turns])
                t_s, error = envelope(run.record["t_s"][rows], MRAD * run.record["position_error_rad"][rows], 600)
                panel.plot(t_s, error, color=COLOURS[method], label=NAMES[method])
                data |= {f"{method}_{rpm:g}rpm_{turns[-1]}_t_s": t_s, f"{method}_{rpm:g}rpm_{turns[-1]}_mrad": error}
            panel.set_yscale("symlog", linthresh=0.1)
            panel.set_title(f"{rpm:g} rpm, {'turns 1 to 3' if column == 0 else 'turn 10'}")
        axes[row, 0].set_ylabel("error [mrad]")
    for panel in axes[-1]:
        panel.set_xlabel("time [s]")
    _legend(figure, axes[0, 0])
    return Picture(
        "motion", "Error over the motion", "Command less position; linear within 0.1 mrad.", to_svg(figure), data
    )


def _of_turn(run: Run, turn: int) -> tuple[Array, Array]:
    """(angle, error without mean in mrad)."""
    rows = turn_rows(run.record, turn)
    start_s = START_S if turn == 1 and run.method not in FROM_COMMAND else 0.0
    rows = rows[run.record["t_s"][rows] >= start_s]
    error = MRAD * run.record["position_error_rad"][rows]
    return envelope(run.record["position_ref_rad"][rows] - (turn - 1) * TURN_RAD, error - error.mean(), 800)


def _runs(result: Result, method: str) -> list[Run]:
    found = (result.run(method, rpm) for rpm in SPEEDS_RPM)
    return [run for run in found if run is not None]


def _legend(figure: Any, *panels: Any) -> None:
    """Each label once."""
    found = {
        label: handle for panel in panels for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    figure.legend(found.values(), found.keys(), loc="outside upper right", ncols=len(found), handlelength=1.6)
