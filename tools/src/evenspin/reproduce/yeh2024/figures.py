"""All figures of the paper: which command draws each, and what it shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from evenspin.report.figures import Picture
from evenspin.report.style import EXPERIMENT_COLOUR, OTHER_COLOURS, drawing, subplots, to_svg
from evenspin.reproduce.paper import Figure, Gallery, Statement, at_most, printed_number, printed_reduction
from evenspin.reproduce.yeh2024 import pictures, printed
from evenspin.reproduce.yeh2024.measure import MRAD, TURN_RAD, Row, max_range_deg
from evenspin.reproduce.yeh2024.result import Result
from evenspin.reproduce.yeh2024.result import gather as run_these
from evenspin.sim.many import Progress
from evenspin.tableview import number

BLOCKS, BENCH = "block diagram", "photograph"
MODELLED = "cogging"  # the experiment of identification
LINES = ((24.0082, 0.140, 1.275), (4.0592, 0.022, 0.521))  # printed: cycles per turn, N m, rad
FROM_0 = (
    "which start the paper takes is not printed, and no one start fits all three methods; ours 0.1 s after the command"
)
K_VP = "k_vp and T_i are derived from turn 1 of P-PI; a softer velocity loop (0.7 A s/rad) gives 7.3, 11.4, 15.6"
FALLING = "still falls: no gain in 0.1 to 0.3 and lead in 0 to 24 samples gives both the printed turn 2 and turn 10"
BETTER = "leaves less: a bench has what a simulation has not"
REASONS = {
    ("silc", "turn10_rms"): FALLING,
    ("silc", "turn10_reduction_pct"): FALLING,
    ("src", "turn2_reduction_pct"): BETTER,
    ("src", "turn10_reduction_pct"): BETTER,
    ("silc", "max_turn10"): FALLING,
    ("silc", "max_turn1"): FROM_0,
    ("src", "max_turn10"): BETTER,
    ("src", "max_turn1"): FROM_0,
    ("rdc", "max_turn1"): FROM_0,
    ("rdc", "max_turn1_from_0"): K_VP,
    ("rdc", "raw_max_turns_1_3"): K_VP,
    ("rdc", "max_reduction_pct"): BETTER,
}
NAMES = {
    "turn1_rms": "rms of turn 1 [mrad]",
    "turn10_rms": "rms of turn 10 [mrad]",
    "max_turn1": "MAX of turn 1 [mrad]",
    "max_turn1_from_0": "MAX of turn 1 from the command on [mrad]",
    "max_turn10": "MAX of turn 10 [mrad]",
    "turn2_reduction_pct": "reduction, turn 2 [%]",
    "turn10_reduction_pct": "reduction, turn 10 [%]",
    "max_reduction_pct": "reduction of MAX, turn 1 to 10 [%]",
    "raw_max_turns_1_3": "raw MAX, turns 1 to 3 [mrad]",
    "avg_turn10": "AVG of turn 10 [mrad]",
}


def _numbers(result: Result, method: str, keys: Sequence[str]) -> list[Statement]:
    """Every printed number of these, by key and speed."""
    said = []
    for key in keys:
        for rpm in printed.SPEEDS_RPM:
            run = result.run(method, rpm)
            if run is None:
                continue
            factor = 1.0 if key.endswith("_pct") else MRAD
            ours, theirs = factor * abs(run.row[key]), printed.paper(method, key, rpm)
            limit = printed.at_most(method, key)
            what = f"{method} at {rpm:g} rpm: {NAMES[key]}"
            reason = REASONS.get((method, key), "")
            if theirs is not None and key.endswith("_pct"):
                said.append(printed_reduction(what, ours, theirs, reason=reason))
            elif theirs is not None:
                said.append(printed_number(what, ours, factor * theirs, digits=4, reason=reason))
            elif limit is not None:
                said.append(at_most(what, ours, factor * limit))
    return said


def _identified(result: Result) -> list[Statement]:
    """Figures 6 to 8."""
    if result.fit is None or result.fit.spectrum is None:
        return []
    said = []
    for line, (cycles, amplitude_nm, phase_rad) in zip(result.fit.spectrum.lines, LINES, strict=False):
        for what, ours, theirs, digits in (
            ("cycles per turn", line.cycles.value, cycles, 6),
            ("amplitude [N m]", line.amplitude_nm.value, amplitude_nm, 3),
            ("phase [rad]", line.phase_rad.value, phase_rad, 4),
        ):
            said.append(printed_number(f"line {cycles:.2f}: {what}", ours, theirs, digits=digits))
    return said


def _row(result: Result, method: str, rpm: float) -> Row | None:
    run = result.run(method, rpm)
    return None if run is None else run.row


def silc_turns(result: Result) -> list[Statement]:
    said = _numbers(result, "silc", ("turn1_rms", "turn2_reduction_pct", "turn10_reduction_pct", "turn10_rms"))
    for rpm in printed.SPEEDS_RPM:
        row = _row(result, "silc", rpm)
        if row is not None:
            fifth, last = MRAD * row["turn_rms"][4], MRAD * row["turn_rms"][9]
            ours = f"{number(fifth)} / {number(last)}"
            what = f"silc at {rpm:g} rpm: rms of turns 5 / 10 [mrad]"
            said.append(Statement(what, ours, "converged by turn 5", fifth < 1.2 * last, FALLING))
    return said


def rdc_turns(result: Result) -> list[Statement]:
    said = _numbers(result, "rdc", ("turn1_rms", "turn10_rms"))
    for rpm in printed.SPEEDS_RPM:
        row = _row(result, "rdc", rpm)
        if row is not None:
            second, last = MRAD * row["turn_rms"][1], MRAD * row["turn_rms"][9]
            ours = f"{number(second)} / {number(last)}"
            what = f"rdc at {rpm:g} rpm: rms of turns 2 / 10 [mrad]"
            said.append(Statement(what, ours, "converged by turn 2", second < 1.2 * last))
    return said


def rdc_polar(result: Result) -> list[Statement]:
    """Figure 14, and how far the start reaches."""
    said = _numbers(result, "rdc", ("max_turn1", "max_turn1_from_0", "max_reduction_pct"))
    reach = []
    for rpm in printed.SPEEDS_RPM:
        run = result.run("rdc", rpm)
        first, reduction = printed.paper("rdc", "max_turn1", rpm), printed.paper("rdc", "max_reduction_pct", rpm)
        if run is not None and first is not None and reduction is not None:
            reach.append(max_range_deg(run.record, first * (1.0 - 0.01 * reduction)))
    if len(reach) == len(printed.SPEEDS_RPM):
        holds = 15.0 * 0.8 <= min(reach) and max(reach) <= 30.0 * 1.2
        reason = (
            "from where on the paper counts is not printed; here until the error stays below its own MAX of turn 10"
        )
        text = ", ".join(f"{angle:.0f}" for angle in reach)
        said.append(Statement("reach of the start at 10, 15, 20 rpm [deg]", text, "15 to 30", holds, reason))
    return said


def motion(result: Result) -> list[Statement]:
    """Figure 15."""
    said = []
    for rpm in printed.SPEEDS_RPM:
        rows = [_row(result, method, rpm) for method in ("silc", "src", "rdc")]
        if any(row is None for row in rows):
            continue
        raw = [MRAD * row["raw_max_turns_1_3"] for row in rows if row is not None]
        last = [MRAD * row["raw_max_turn10"] for row in rows if row is not None]
        for what, values in (("turns 1 to 3", raw), ("turn 10", last)):
            ours = " / ".join(number(value) for value in values)
            holds = values[2] < 0.1 * min(values[:2])
            said.append(
                Statement(f"{rpm:g} rpm, {what}: MAX of SILC / SRC / RDC [mrad]", ours, "RDC 90 % lower", holds)
            )
    return said


def _modelled(result: Result) -> Picture | None:
    """Figures 6 to 8: torque over the last turn, its spectrum, and the model of two lines."""
    if result.fit is None or result.fit.spectrum is None:
        return None
    found = result.fit.spectrum
    figure, axes = subplots(2, 1, height=5.6)
    last = found.theta_rad >= found.theta_rad[-1] - TURN_RAD
    turn = found.theta_rad[last] / TURN_RAD
    turn = turn - turn[0]
    measured, fit = found.torque_nm[last], found.fit_nm[last]
    mean = float(fit.mean())
    axes[0, 0].plot(
        turn, measured - mean, color=OTHER_COLOURS[0], linewidth=0.8, label="estimated, mean in cells of the angle"
    )
    axes[0, 0].plot(turn, fit - mean, color=OTHER_COLOURS[3], linewidth=1.2, label="model of two lines")
    axes[0, 0].set(
        xlabel="angle [turn]", ylabel="torque [N m]", title="6, 8: one turn", xlim=(0.0, 1.0), ylim=(-0.2, 0.25)
    )
    shown = found.order <= 40.0
    axes[1, 0].plot(found.order[shown], found.amplitude_nm[shown], color=OTHER_COLOURS[0], label="spectrum")
    cycles, size = ([line[k] for line in LINES] for k in (0, 1))
    style = {"color": EXPERIMENT_COLOUR, "marker": "D", "linestyle": "none", "markersize": 5}
    axes[1, 0].plot(cycles, size, label="paper: 0.140 N m at 24.008, 0.022 N m at 4.059", **style)
    axes[1, 0].set(xlabel="cycles per turn [-]", ylabel="torque [N m]", title="7: spectrum over the angle")
    for panel in axes.flat:
        panel.legend(loc="upper right")
    data = {
        "turn": turn,
        "torque_nm": measured - mean,
        "model_nm": fit - mean,
        "cycles": found.order[shown],
        "amplitude_nm": found.amplitude_nm[shown],
        "paper_cycles": np.array(cycles),
        "paper_nm": np.array(size),
    }
    text = (
        "Torque over the angle from a slow run at 3 rpm, friction taken off. The simulated machine has the printed "
        "lines; shown is what identification finds of them."
    )
    return Picture("figure_6_7_8", "Disturbance over the angle, and its model", text, to_svg(figure), data)


def _of(draw: Callable[[Result], Picture], methods: Sequence[str]) -> Callable[[Result], Picture | None]:
    """In the style of the house, where all of these methods were run."""

    def within(result: Result) -> Picture | None:
        if any(result.run(method, rpm) is None for method in methods for rpm in printed.SPEEDS_RPM):
            return None
        with drawing():
            return draw(result)

    return within


def _modelled_in_style(result: Result) -> Picture | None:
    with drawing():
        return _modelled(result)


def _turns(number_of: str, method: str, says: Callable[[Result], Sequence[Statement]]) -> Figure[Result]:
    draw = _of(lambda result: pictures.rms_picture(result, [method]), (method,))
    return Figure((number_of,), f"error by turns, {pictures.NAMES[method]}", draw, says, (method,))


def _polar(number_of: str, method: str, says: Callable[[Result], Sequence[Statement]]) -> Figure[Result]:
    draw = _of(lambda result: pictures.polar_picture(result, method), (method,))
    return Figure((number_of,), f"turns 1, 2 and 10, {pictures.NAMES[method]}", draw, says, (method,))


THREE = ("silc", "src", "rdc")
GALLERY: Gallery[Result] = Gallery(
    "yeh2024",
    (
        Figure(
            ("6", "7", "8"), "disturbance over the angle and its model", _modelled_in_style, _identified, (MODELLED,)
        ),
        _turns("9", "silc", silc_turns),
        _polar("10", "silc", lambda result: _numbers(result, "silc", ("max_turn1", "max_turn10"))),
        _turns("11", "src", lambda result: _numbers(result, "src", ("turn2_reduction_pct", "turn10_reduction_pct"))),
        _polar("12", "src", lambda result: _numbers(result, "src", ("max_turn1", "max_turn10"))),
        _turns("13", "rdc", rdc_turns),
        _polar("14", "rdc", rdc_polar),
        Figure(
            ("15",),
            "error over the motion",
            _of(lambda result: pictures.motion_picture(result, THREE), THREE),
            motion,
            THREE,
        ),
        Figure(
            ("16",),
            "largest error and its mean",
            _of(lambda result: pictures.raw_picture(result, THREE), THREE),
            lambda result: [s for m in THREE for s in _numbers(result, m, ("raw_max_turns_1_3", "avg_turn10"))],
            THREE,
        ),
    ),
    {**dict.fromkeys(("1", "2", "3", "4"), BLOCKS), "5": BENCH},
)


def gather(figures: Sequence[Figure[Result]], numeric: str, progress: Progress) -> Result:
    """The motions and experiments that these figures need."""
    needed = {name for figure in figures for name in figure.needs}
    methods = [method for method in THREE if method in needed]
    return run_these(numeric, methods, (), (MODELLED,) if MODELLED in needed else (), progress)
