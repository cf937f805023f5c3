"""The figures of the paper that are drawn from the runs of a set, with its numbers in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.segments import RAD_S, Segment, segments
from evenspin.report.chart import POINTS, Chart, Line, Panel
from evenspin.report.figures import (
    SPEED_INPUT,
    ZOOM_S,
    Curve,
    Picture,
    after_panel,
    bar_places,
    current_panel,
    order_panels,
    picture_of,
    speed_panel,
)
from evenspin.report.style import EXPERIMENT_COLOUR, METHOD_COLOURS, METHOD_NAMES, METHOD_WIDTHS, SIMULATION_COLOUR
from evenspin.reproduce.guo2024.printed import printed
from evenspin.reproduce.guo2024.result import Run

Array = NDArray[np.float64]
Runs = Sequence[Run]
PI_TO_FORC = ("pi", "crc", "forc")
OVERSHOOT = ("forc", "fal-forc")
CLOSE_TURNS = 3.0  # electrical, of the q current close up


def of(runs: Runs, set_name: str, methods: Sequence[str]) -> list[Run]:
    """Those of these methods, in this order."""
    found = {run.method: run for run in runs if run.set_name == set_name}
    return [found[method] for method in methods if method in found]


def responses(runs: Runs, set_name: str, name: str, title: str) -> Picture | None:
    """Speed and q current of PI, CRC and FORC over the whole run."""
    chosen = of(runs, set_name, PI_TO_FORC)
    if not chosen:
        return None
    speed, numbers = speed_panel(chosen[0].setup, _curves(chosen))
    current, more = current_panel(chosen[0].setup, _curves(chosen))
    text = "True speed of the rotor, and true current of the motor, not what its sensors say; the reference is dashed."
    data = numbers | {f"iq_{key}": column for key, column in more.items()}
    return picture_of(name, title, text, Chart([speed, current], height_px=250.0), data)


def spectra(runs: Runs) -> Picture | None:
    """Figures 24 to 27: first and second order beside the printed ones."""
    chosen = of(runs, "first", PI_TO_FORC)
    if not chosen:
        return None

    def marks(segment: Segment) -> list[Line]:
        rpm = round(segment.speed_ref_rad_s / RAD_S)
        return _marks([run.method for run in chosen], rpm) if SPEED_INPUT in segment.changed else []

    panels, data = order_panels(chosen[0].setup, _curves(chosen), marks)
    steady = [segment for segment in segments(chosen[0].setup) if segment.speed_ref_rad_s][: len(panels)]
    first = [panel for panel, piece in zip(panels, steady, strict=True) if SPEED_INPUT in piece.changed]
    text = "Before the load step, % of the mean speed, over the electrical turn. Dots: what the paper prints."
    title = "Spectrum of the speed, 150, 203, 255 and 295 rpm"
    return picture_of("figure_24_25_26_27", title, text, Chart(first, 2, 235.0), data)


def _marks(methods: Sequence[str], rpm: float) -> list[Line]:
    lines = []
    for kind, colour in (("simulation", SIMULATION_COLOUR), ("experiment", EXPERIMENT_COLOUR)):
        x: list[float] = []
        y: list[float] = []
        for index, method in enumerate(methods):
            for order, key in enumerate(("n1_pct", "n2_pct")):
                line = printed(method, rpm, key)
                value = getattr(line, kind) if line is not None else None
                if value is not None:
                    x.append(float(bar_places(index, len(methods))[order]))
                    y.append(value)
        if x:
            lines.append(Line(f"paper, {kind}", np.array(x), np.array(y), colour, 2.4, kind=POINTS))
    return lines


def overshoots(runs: Runs, set_name: str, rpm: float, name: str, title: str) -> Picture | None:
    """FORC and fal-FORC: the whole run, and the start and the first load step with the printed peaks."""
    chosen = of(runs, set_name, OVERSHOOT)
    if not chosen:
        return None
    setup, curves = chosen[0].setup, _curves(chosen)
    whole, data = speed_panel(setup, curves)
    start, load = segments(setup)[:2]
    panels = [whole]
    for piece, key in ((start, "overshoot_start_rpm"), (load, "overshoot_load_rpm")):
        panel, numbers = after_panel(curves, piece)
        lines, said = _levels([run.method for run in chosen], rpm, key)
        title_of = f"{panel.title}; paper: {said}" if said else panel.title
        panels.append(replace(panel, lines=[*panel.lines, *lines], title=title_of))
        data |= numbers
    text = (
        "True speed. Dashed in the colour of a method: the peaks that the paper prints, of simulation and experiment."
    )
    return picture_of(name, title, text, Chart(panels, 1, 230.0), data)


def _levels(methods: Sequence[str], rpm: float, key: str) -> tuple[list[Line], str]:
    """Lines at the printed peaks, and these in words."""
    lines, said = [], []
    for method in methods:
        line = printed(method, rpm, key)
        values = [] if line is None else [x for x in (line.simulation, line.experiment) if x is not None]
        for value in values:
            ends = np.array([0.0, ZOOM_S])
            lines.append(
                Line(
                    f"paper: {METHOD_NAMES[method]}",
                    ends,
                    np.full(2, rpm + value),
                    METHOD_COLOURS[method],
                    1.2,
                    dashed=True,
                )
            )
        if values:
            said.append(f"{METHOD_NAMES[method]} {' and '.join(f'{rpm + value:g}' for value in values)} rpm")
    return lines, ", ".join(said)


def fast(runs: Runs) -> Picture | None:
    """Figure 29: 900 and 1200 rpm, and the q current close up."""
    chosen = of(runs, "third", ("pi", "forc"))
    if not chosen:
        return None
    setup, curves = chosen[0].setup, _curves(chosen)
    speed, data = speed_panel(setup, curves)
    current, more = current_panel(setup, curves)
    data |= {f"iq_{key}": column for key, column in more.items()}
    panels = [speed, current]
    for piece in segments(setup):
        if SPEED_INPUT in piece.changed:
            continue
        period_s = 2.0 * np.pi / (setup.plant["pole_pairs"] * piece.speed_ref_rad_s)
        lines = []
        for run in chosen:
            part = run.record.between(piece.end_s - CLOSE_TURNS * period_s, piece.end_s)
            turn, iq_a = (part["t_s"] - part["t_s"][0]) / period_s, part["true_iq_a"]
            width = METHOD_WIDTHS.get(run.method, 1.0)
            lines.append(Line(METHOD_NAMES[run.method], turn, iq_a, METHOD_COLOURS[run.method], width))
            key = f"{run.method}_{piece.speed_ref_rad_s / RAD_S:.0f}rpm"
            data |= {f"{key}_turn": turn, f"{key}_iq_a": iq_a}
        title = f"{piece.speed_ref_rad_s / RAD_S:.0f} rpm, after the load step"
        panels.append(
            Panel(lines, "electrical turn [-]", "q-axis current [A]", title, (0.0, CLOSE_TURNS), group="turn")
        )
    text = "Speed and q current; then the q current over three electrical turns: its second order stays."
    return picture_of("figure_29", "900 and 1200 rpm", text, Chart(panels, 1, 200.0), data)


def _curves(runs: Runs) -> list[Curve]:
    return [Curve(run.method, run.record) for run in runs]
