"""The pictures of a run or of several runs of one scenario. Each comes with the numbers it shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.orders import order_spectrum
from evenspin.analysis.segments import RAD_S, Segment, segments, value_at
from evenspin.model.setup import Setup
from evenspin.report.curves import envelope
from evenspin.report.style import (
    METHOD_COLOURS,
    METHOD_NAMES,
    OTHER_COLOURS,
    REFERENCE_COLOUR,
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
    drawn = [speed_picture(setup, curves), current_picture(curves)]
    if any(segment.speed_ref_rad_s for segment in segments(setup)):
        drawn += [orders_picture(setup, curves), *zoom_pictures(setup, curves)]
    return drawn


def speed_picture(setup: Setup, curves: Sequence[Curve]) -> Picture:
    figure, axes = subplots(height=3.6)
    data: dict[str, Array] = {}
    for index, curve in enumerate(curves):
        t_s, rpm = envelope(curve.record["t_s"], curve.record["true_speed_rad_s"] / RAD_S)
        _line(axes[0, 0], index, curve.name, t_s, rpm)
        data |= {f"{curve.name}_t_s": t_s, f"{curve.name}_rpm": rpm}
    t_s, ref_rpm = reference_of(setup)
    axes[0, 0].plot(t_s, ref_rpm, color=REFERENCE_COLOUR, linewidth=0.9, linestyle=(0, (5, 3)), label="reference")
    axes[0, 0].set(xlabel="time [s]", ylabel="speed [rpm]", xlim=(0.0, setup.duration_s))
    _legend(axes[0, 0])
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
    _legend(axes[0, 0])
    return _picture("current", "q-axis current", "True current of the motor, not what its sensors say.", figure, data)


def orders_picture(setup: Setup, curves: Sequence[Curve]) -> Picture:
    """Spectrum of the speed in each steady state that ends a speed or the run."""
    steady = [segment for segment in segments(setup) if segment.speed_ref_rad_s][:MAX_PANELS]
    columns = min(4, len(steady))
    rows = -(-len(steady) // columns)
    figure, axes = subplots(rows, columns, height=2.1 * rows + 0.6, sharex=True, sharey=True)
    data: dict[str, Array] = {}
    for panel, segment in zip(axes.flat, steady, strict=False):
        label = f"{segment.speed_ref_rad_s / RAD_S:.0f} rpm, {segment.steady_s:.1f} to {segment.end_s:.1f} s"
        for index, curve in enumerate(curves):
            order, pct = _spectrum(setup, curve.record, segment)
            _line(panel, index, curve.name, order, np.maximum(pct, 1e-5), linewidth=1.2)
            key = f"{curve.name}_{segment.start_s:g}s"
            data |= {f"{key}_order": order, f"{key}_pct": pct}
        panel.set(title=label, yscale="log", xlim=(0.0, MAX_ORDER), ylim=(1e-3, 40.0))
        panel.set_xticks(range(0, int(MAX_ORDER) + 1))
    for panel in list(axes.flat)[len(steady) :]:
        panel.set_visible(False)
    _outer_labels(axes, "electrical order [-]", "speed ripple [% of mean]")
    _legend(axes[0, 0])
    text = "Amplitude over the electrical turn, in the steady state before the next change."
    return _picture("orders", "Speed spectrum in orders", text, figure, data)


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
        panel.axhline(reference_rpm, color=REFERENCE_COLOUR, linewidth=0.9, linestyle=(0, (5, 3)))
        panel.set(title=f"t = {piece.start_s:g} s, {reference_rpm:.0f} rpm", xlim=(-0.05 * (piece.start_s > 0), ZOOM_S))
    for panel in list(axes.flat)[len(pieces) :]:
        panel.set_visible(False)
    _outer_labels(axes, "time after the change [s]", "speed [rpm]")
    _legend(axes[0, 0])
    return _picture(name, title, text, figure, data)


def reference_of(setup: Setup) -> tuple[Array, Array]:
    """The speed reference as a line, rpm."""
    curve = setup.inputs.get(SPEED_INPUT)
    if curve is None:
        return np.array([0.0, setup.duration_s]), np.zeros(2)
    times = sorted({0.0, setup.duration_s, *curve.t_s, *(max(t - 1e-9, 0.0) for t in curve.t_s)})
    return np.array(times), np.array([value_at(curve, t) for t in times]) / RAD_S


def _spectrum(setup: Setup, record: Record, segment: Segment) -> tuple[Array, Array]:
    part = record.between(segment.steady_s, segment.end_s)
    speed = part["true_speed_rad_s"]
    order, amplitude = order_spectrum(speed, setup.plant["pole_pairs"] * part["true_theta_m_rad"], MAX_ORDER)
    return order, 100.0 * amplitude / abs(speed.mean())


def _line(axes: Any, index: int, name: str, x: Array, y: Array, **options: Any) -> None:
    colour = METHOD_COLOURS.get(name, OTHER_COLOURS[index % len(OTHER_COLOURS)])
    axes.plot(x, y, color=colour, label=METHOD_NAMES.get(name, name), **options)


def _legend(axes: Any) -> None:
    axes.legend(loc="best", ncols=5, handlelength=1.6)


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
