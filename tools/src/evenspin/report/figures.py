"""The pictures of a run or of several runs of one scenario. Each comes with the numbers it shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.orders import order_amplitudes, order_spectrum
from evenspin.analysis.segments import RAD_S, Segment, segments, value_at
from evenspin.model.setup import Setup
from evenspin.report.curves import envelope
from evenspin.report.style import (
    METHOD_COLOURS,
    METHOD_NAMES,
    METHOD_WIDTHS,
    OTHER_COLOURS,
    REFERENCE_COLOUR,
    drawing,
    subplots,
    to_svg,
)
from evenspin.sim.record import Record

Array = NDArray[np.float64]
Table = Mapping[str, Sequence[float] | Array]

SPEED_INPUT = "speed_ref_rad_s"
ZOOM_S = 0.6  # what is shown after a change
MAX_PANELS = 12
MAX_ORDER = 8.0
BAR_ORDERS = tuple(range(1, 7))
REFERENCE_LINE = {"color": REFERENCE_COLOUR, "linewidth": 0.9, "linestyle": (0, (5, 3))}


@dataclass(frozen=True, slots=True)
class Curve:
    """A run to draw."""

    name: str
    record: Record


@dataclass(frozen=True, slots=True)
class Picture:
    """An SVG, what it shows, and its numbers as columns of equal length (nan where one is shorter)."""

    name: str
    title: str
    text: str
    svg: str
    data: Table


def pictures(setup: Setup, curves: Sequence[Curve]) -> list[Picture]:
    """Everything worth seeing of these runs."""
    with drawing():
        drawn = [speed_picture(setup, curves), current_picture(curves)]
        if any(segment.speed_ref_rad_s for segment in segments(setup)):
            drawn += [*zoom_pictures(setup, curves), orders_picture(setup, curves)]
    return drawn


def speed_picture(setup: Setup, curves: Sequence[Curve]) -> Picture:
    figure, axes = subplots(height=3.6)
    data: dict[str, Array] = {}
    for index, curve in enumerate(curves):
        t_s, rpm = envelope(curve.record["t_s"], curve.record["true_speed_rad_s"] / RAD_S)
        _line(axes[0, 0], index, curve.name, t_s, rpm)
        data |= {f"{curve.name}_t_s": t_s, f"{curve.name}_rpm": rpm}
    t_s, ref_rpm = reference_of(setup)
    axes[0, 0].plot(t_s, ref_rpm, label="reference", **REFERENCE_LINE)
    axes[0, 0].set(xlabel="time [s]", ylabel="speed [rpm]", xlim=(0.0, setup.duration_s))
    _legend(figure, axes[0, 0])
    data |= {"reference_t_s": t_s, "reference_rpm": ref_rpm}
    return _picture("speed", "Speed", "True speed of the rotor; the reference is dashed.", figure, data)


def current_picture(curves: Sequence[Curve]) -> Picture:
    figure, axes = subplots(height=3.0)
    data: dict[str, Array] = {}
    for index, curve in enumerate(curves):
        t_s, iq_a = envelope(curve.record["t_s"], curve.record["true_iq_a"])
        _line(axes[0, 0], index, curve.name, t_s, iq_a)
        data |= {f"{curve.name}_t_s": t_s, f"{curve.name}_iq_a": iq_a}
    axes[0, 0].set(xlabel="time [s]", ylabel="q-axis current [A]", xlim=(0.0, None))
    _legend(figure, axes[0, 0])
    return _picture("current", "q-axis current", "True current of the motor, not what its sensors say.", figure, data)


def orders_picture(setup: Setup, curves: Sequence[Curve]) -> Picture:
    """Ripple of the speed by orders in each steady state: a spectrum of one run, bars side by side of several."""
    steady = [segment for segment in segments(setup) if segment.speed_ref_rad_s][:MAX_PANELS]
    columns = min(4, len(steady))
    rows = -(-len(steady) // columns)
    figure, axes = subplots(rows, columns, height=2.1 * rows + 0.9, sharex=True, sharey=True)
    data: dict[str, Sequence[float] | Array] = {}
    for panel, segment in zip(axes.flat, steady, strict=False):
        draw = _spectrum_panel if len(curves) == 1 else _bar_panel
        data |= draw(panel, setup, curves, segment)
        speed = f"{segment.speed_ref_rad_s / RAD_S:.0f} rpm"
        panel.set(title=f"{speed}, {segment.steady_s:.1f} to {segment.end_s:.1f} s", yscale="log", ylim=(1e-3, 40.0))
    for panel in list(axes.flat)[len(steady) :]:
        panel.set_visible(False)
    _outer_labels(axes, "electrical order [-]", "speed ripple [% of mean]")
    _legend(figure, axes[0, 0])
    text = "Amplitude over the electrical turn, in the steady state before the next change; logarithmic."
    return _picture("orders", "Speed spectrum in orders", text, figure, data)


def _spectrum_panel(panel: Any, setup: Setup, curves: Sequence[Curve], segment: Segment) -> Table:
    part = curves[0].record.between(segment.steady_s, segment.end_s)
    order, amplitude = order_spectrum(part["true_speed_rad_s"], _electrical(setup, part), MAX_ORDER)
    pct = 100.0 * amplitude / abs(part["true_speed_rad_s"].mean())
    _line(panel, 0, curves[0].name, order, np.maximum(pct, 1e-5))
    panel.set(xlim=(0.0, MAX_ORDER), xticks=range(int(MAX_ORDER) + 1))
    key = f"{curves[0].name}_{segment.start_s:g}s"
    return {f"{key}_order": order, f"{key}_pct": pct}


def _bar_panel(panel: Any, setup: Setup, curves: Sequence[Curve], segment: Segment) -> Table:
    data: dict[str, Array] = {f"{segment.start_s:g}s_order": np.array(BAR_ORDERS, dtype=float)}
    width = 0.8 / len(curves)
    for index, curve in enumerate(curves):
        part = curve.record.between(segment.steady_s, segment.end_s)
        speed = part["true_speed_rad_s"]
        pct = 100.0 * order_amplitudes(speed, _electrical(setup, part), BAR_ORDERS) / abs(speed.mean())
        at = np.array(BAR_ORDERS) + (index - (len(curves) - 1) / 2.0) * width
        label = METHOD_NAMES.get(curve.name, curve.name)
        panel.bar(at, np.maximum(pct, 1e-5), width, color=_colour(index, curve.name), label=label)
        data[f"{curve.name}_{segment.start_s:g}s_pct"] = pct
    panel.set_xticks(BAR_ORDERS)
    panel.grid(visible=False, axis="x")
    return data


def zoom_pictures(setup: Setup, curves: Sequence[Curve]) -> list[Picture]:
    """The time after the start, after each load step and after each speed step, close up."""
    pieces = segments(setup)
    speed = [piece for piece in pieces if SPEED_INPUT in piece.changed]
    load = [piece for piece in pieces if piece not in speed and any("load" in name for name in piece.changed)]
    start, steps = [piece for piece in speed if piece.start_s == 0.0], [p for p in speed if p.start_s > 0.0]
    groups = (
        ("start", "Start", "The first 0.6 s.", start),
        ("load_steps", "Load steps", "Overshoot and dip after each change of the load.", load),
        ("speed_steps", "Speed steps", "After each change of the reference.", steps),
    )
    return [_zoom(setup, curves, *group) for group in groups if group[3]]


def _zoom(
    setup: Setup, curves: Sequence[Curve], name: str, title: str, text: str, pieces: Sequence[Segment]
) -> Picture:
    pieces = pieces[:MAX_PANELS]
    columns = 1 if len(pieces) == 1 else 2
    rows = -(-len(pieces) // columns)
    figure, axes = subplots(rows, columns, height=2.4 * rows + 0.5)
    data: dict[str, Array] = {}
    for panel, piece in zip(axes.flat, pieces, strict=False):
        end_s = min(piece.start_s + ZOOM_S, piece.end_s)
        reference_rpm = piece.speed_ref_rad_s / RAD_S
        for index, curve in enumerate(curves):
            part = curve.record.between(max(piece.start_s - 0.05, 0.0), end_s)
            after_s, rpm = part["t_s"] - piece.start_s, part["true_speed_rad_s"] / RAD_S
            _line(panel, index, curve.name, after_s, rpm)
            key = f"{curve.name}_{piece.start_s:g}s"
            data |= {f"{key}_t_s": part["t_s"], f"{key}_rpm": rpm}
        panel.axhline(reference_rpm, label="reference", **REFERENCE_LINE)
        panel.set(title=f"t = {piece.start_s:g} s, {reference_rpm:.0f} rpm", xlim=(-0.05 * (piece.start_s > 0), ZOOM_S))
    for panel in list(axes.flat)[len(pieces) :]:
        panel.set_visible(False)
    _outer_labels(axes, "time after the change [s]", "speed [rpm]")
    _legend(figure, axes[0, 0])
    return _picture(name, title, text, figure, data)


def reference_of(setup: Setup) -> tuple[Array, Array]:
    """The speed reference as a line, rpm."""
    curve = setup.inputs.get(SPEED_INPUT)
    if curve is None:
        return np.array([0.0, setup.duration_s]), np.zeros(2)
    times = sorted({0.0, setup.duration_s, *curve.t_s, *(max(t - 1e-9, 0.0) for t in curve.t_s)})
    return np.array(times), np.array([value_at(curve, t) for t in times]) / RAD_S


def _electrical(setup: Setup, record: Record) -> Array:
    return setup.plant["pole_pairs"] * record["true_theta_m_rad"]


def _line(axes: Any, index: int, name: str, x: Array, y: Array, **options: Any) -> None:
    style = {"color": _colour(index, name), "linewidth": METHOD_WIDTHS.get(name, 1.0)}
    axes.plot(x, y, label=METHOD_NAMES.get(name, name), **(style | options))


def _colour(index: int, name: str) -> str:
    return METHOD_COLOURS.get(name, OTHER_COLOURS[index % len(OTHER_COLOURS)])


def _legend(figure: Any, axes: Any) -> None:
    """One legend for all panels, above them."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=len(labels), handlelength=1.6)


def _outer_labels(axes: Any, x: str, y: str) -> None:
    """Labels on the outer panels only; a panel above an empty place is an outer one."""
    for row, line in enumerate(axes):
        for column, panel in enumerate(line):
            below = axes[row + 1][column] if row + 1 < len(axes) else None
            if below is None or not below.get_visible():
                panel.set_xlabel(x)
                panel.tick_params(labelbottom=True)
            if column == 0:
                panel.set_ylabel(y)


def _picture(name: str, title: str, text: str, figure: Any, data: Table) -> Picture:
    return Picture(name, title, text, to_svg(figure), data)
