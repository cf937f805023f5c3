"""The pictures of a run or of several runs of one scenario. Each comes with the numbers it shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.orders import order_amplitudes, order_spectrum, strongest_orders
from evenspin.analysis.segments import RAD_S, Segment, segments, value_at
from evenspin.model.setup import Setup
from evenspin.report.chart import BARS, Chart, Line, Panel, chart_json
from evenspin.report.curves import envelope
from evenspin.report.style import METHOD_COLOURS, METHOD_NAMES, METHOD_WIDTHS, OTHER_COLOURS, REFERENCE_COLOUR
from evenspin.report.svg import svg_of
from evenspin.sim.record import Record

Array = NDArray[np.float64]
Table = Mapping[str, Sequence[float] | Array]

SPEED_INPUT = "speed_ref_rad_s"
TIME = "time"  # panels over the time of the whole run
ZOOM_S = 0.6  # what is shown after a change
STEP_S = 1e-6  # how long a step of the reference is drawn
MAX_PANELS = 12
MAX_ORDER, MOST_ORDER = 8.0, 60.0  # electrical; up to the second where there are lines
BAR_ORDERS, BARS_WIDE = tuple(range(1, 7)), 0.8
LEAST_PCT, RIPPLE_PCT = 1e-5, (1e-3, 40.0)


@dataclass(frozen=True, slots=True)
class Curve:
    """A run to draw."""

    name: str
    record: Record


@dataclass(frozen=True, slots=True)
class Picture:
    """An SVG, what it shows, and its numbers as columns of equal length (nan where one is shorter). `chart`: the same
    as JSON (report/chart.py), for a page on which it can be zoomed; empty where there is only the SVG."""

    name: str
    title: str
    text: str
    svg: str
    data: Table
    chart: str = ""


def picture_of(name: str, title: str, text: str, chart: Chart, data: Table) -> Picture:
    return Picture(name, title, text, svg_of(chart, name), data, chart_json(chart))


def pictures(setup: Setup, curves: Sequence[Curve]) -> list[Picture]:
    """Everything worth seeing of these runs."""
    drawn = [speed_picture(setup, curves), current_picture(setup, curves)]
    if any(segment.speed_ref_rad_s for segment in segments(setup)):
        drawn += [*zoom_pictures(setup, curves), orders_picture(setup, curves)]
    return drawn


def speed_picture(setup: Setup, curves: Sequence[Curve]) -> Picture:
    panel, data = speed_panel(setup, curves)
    text = "True speed of the rotor; the reference is dashed."
    return picture_of("speed", "Speed", text, Chart([panel], height_px=320.0), data)


def speed_panel(setup: Setup, curves: Sequence[Curve]) -> tuple[Panel, dict[str, Array]]:
    """Speed over the whole run."""
    lines: list[Line] = []
    data: dict[str, Array] = {}
    for index, curve in enumerate(curves):
        t_s, rpm = envelope(curve.record["t_s"], curve.record["true_speed_rad_s"] / RAD_S)
        lines.append(_line(index, curve.name, t_s, rpm))
        data |= {f"{curve.name}_t_s": t_s, f"{curve.name}_rpm": rpm}
    t_s, ref_rpm = reference_of(setup)
    lines.append(_reference(t_s, ref_rpm))
    data |= {"reference_t_s": t_s, "reference_rpm": ref_rpm}
    return Panel(lines, "time [s]", "speed [rpm]", x_range=(0.0, setup.duration_s), group=TIME), data


def current_picture(setup: Setup, curves: Sequence[Curve]) -> Picture:
    panel, data = current_panel(setup, curves)
    text = "True current of the motor, not what its sensors say."
    return picture_of("current", "q-axis current", text, Chart([panel]), data)


def current_panel(setup: Setup, curves: Sequence[Curve]) -> tuple[Panel, dict[str, Array]]:
    """q current over the whole run."""
    lines: list[Line] = []
    data: dict[str, Array] = {}
    for index, curve in enumerate(curves):
        t_s, iq_a = envelope(curve.record["t_s"], curve.record["true_iq_a"])
        lines.append(_line(index, curve.name, t_s, iq_a))
        data |= {f"{curve.name}_t_s": t_s, f"{curve.name}_iq_a": iq_a}
    return Panel(lines, "time [s]", "q-axis current [A]", x_range=(0.0, setup.duration_s), group=TIME), data


def orders_picture(setup: Setup, curves: Sequence[Curve]) -> Picture:
    """Ripple of the speed by orders in each steady state: a spectrum of one run, bars side by side of several."""
    panels, data = order_panels(setup, curves)
    text = "Amplitude over the electrical turn, in the steady state before the next change; logarithmic."
    return picture_of("orders", "Speed spectrum in orders", text, Chart(panels, min(4, len(panels)), 225.0), data)


def order_panels(
    setup: Setup, curves: Sequence[Curve], marks: Callable[[Segment], Sequence[Line]] | None = None
) -> tuple[list[Panel], dict[str, Sequence[float] | Array]]:
    """One for each steady state; `marks`: what is drawn over it. Where the bar of a curve stands: `bar_places`."""
    steady = [segment for segment in segments(setup) if segment.speed_ref_rad_s][:MAX_PANELS]
    highest = highest_order(setup, curves[0].record, steady) if len(curves) == 1 else MAX_ORDER
    panels = []
    data: dict[str, Sequence[float] | Array] = {}
    for segment in steady:
        lines, numbers = (
            _spectrum(setup, curves[0], segment, highest) if len(curves) == 1 else _bars(setup, curves, segment)
        )
        data |= numbers
        speed = f"{segment.speed_ref_rad_s / RAD_S:.0f} rpm"
        ends = (0.0, highest) if len(curves) == 1 else (BAR_ORDERS[0] - 0.6, BAR_ORDERS[-1] + 0.6)
        panels.append(
            Panel(
                [*lines, *(marks(segment) if marks is not None else ())],
                "electrical order [-]",
                "speed ripple [% of mean]",
                f"{speed}, {segment.steady_s:.1f} to {segment.end_s:.1f} s",
                ends,
                RIPPLE_PCT,
                log_y=True,
                x_ticks=None if len(curves) == 1 else BAR_ORDERS,
                group="order",
            )
        )
    return panels, data


def bar_places(index: int, curves: int) -> Array:
    """Where the bars of a curve among several stand, by BAR_ORDERS."""
    return np.array(BAR_ORDERS) + (index - (curves - 1) / 2.0) * BARS_WIDE / curves


def highest_order(setup: Setup, record: Record, steady: Sequence[Segment]) -> float:
    """The electrical order up to which a spectrum is drawn: MAX_ORDER, or one more than the highest of its lines."""
    found = [MAX_ORDER]
    for segment in steady:
        part = record.between(segment.steady_s, segment.end_s)
        lines = strongest_orders(part["true_speed_rad_s"], _electrical(setup, part), most=MOST_ORDER)
        found += [float(np.ceil(order + 1.0)) for order, _ in lines]
    return max(found)


def _spectrum(setup: Setup, curve: Curve, segment: Segment, highest: float) -> tuple[list[Line], Table]:
    part = curve.record.between(segment.steady_s, segment.end_s)
    order, amplitude = order_spectrum(part["true_speed_rad_s"], _electrical(setup, part), highest)
    pct = 100.0 * amplitude / abs(part["true_speed_rad_s"].mean())
    key = f"{curve.name}_{segment.start_s:g}s"
    line = _line(0, curve.name, order, np.maximum(pct, LEAST_PCT))
    return [line], {f"{key}_order": order, f"{key}_pct": pct}


def _bars(setup: Setup, curves: Sequence[Curve], segment: Segment) -> tuple[list[Line], Table]:
    lines: list[Line] = []
    data: dict[str, Array] = {f"{segment.start_s:g}s_order": np.array(BAR_ORDERS, dtype=float)}
    width = BARS_WIDE / len(curves)
    for index, curve in enumerate(curves):
        part = curve.record.between(segment.steady_s, segment.end_s)
        speed = part["true_speed_rad_s"]
        pct = 100.0 * order_amplitudes(speed, _electrical(setup, part), BAR_ORDERS) / abs(speed.mean())
        at = bar_places(index, len(curves))
        name = METHOD_NAMES.get(curve.name, curve.name)
        lines.append(Line(name, at, np.maximum(pct, LEAST_PCT), _colour(index, curve.name), kind=BARS, bar_width=width))
        data[f"{curve.name}_{segment.start_s:g}s_pct"] = pct
    return lines, data


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
    panels = []
    data: dict[str, Array] = {}
    for piece in pieces[:MAX_PANELS]:
        panel, numbers = after_panel(curves, piece)
        panels.append(panel)
        data |= numbers
    return picture_of(name, title, text, Chart(panels, 1 if len(panels) == 1 else 2, 240.0), data)


def after_panel(curves: Sequence[Curve], piece: Segment) -> tuple[Panel, dict[str, Array]]:
    """The speed after one change."""
    before_s = 0.05 * (piece.start_s > 0)
    lines: list[Line] = []
    data: dict[str, Array] = {}
    for index, curve in enumerate(curves):
        part = curve.record.between(max(piece.start_s - 0.05, 0.0), min(piece.start_s + ZOOM_S, piece.end_s))
        rpm = part["true_speed_rad_s"] / RAD_S
        lines.append(_line(index, curve.name, part["t_s"] - piece.start_s, rpm))
        key = f"{curve.name}_{piece.start_s:g}s"
        data |= {f"{key}_t_s": part["t_s"], f"{key}_rpm": rpm}
    wanted = piece.speed_ref_rad_s / RAD_S
    lines.append(_reference(np.array([-before_s, ZOOM_S]), np.array([wanted, wanted])))
    title = f"t = {piece.start_s:g} s, {wanted:.0f} rpm"
    return Panel(lines, "time after the change [s]", "speed [rpm]", title, (-before_s, ZOOM_S), group="after"), data


def reference_of(setup: Setup) -> tuple[Array, Array]:
    """The speed reference as a line, rpm."""
    curve = setup.inputs.get(SPEED_INPUT)
    if curve is None:
        return np.array([0.0, setup.duration_s]), np.zeros(2)
    times = sorted({0.0, setup.duration_s, *curve.t_s, *(max(t - STEP_S, 0.0) for t in curve.t_s)})
    return np.array(times), np.array([value_at(curve, t) for t in times]) / RAD_S


def _electrical(setup: Setup, record: Record) -> Array:
    return setup.plant["pole_pairs"] * record["true_theta_m_rad"]


def _line(index: int, name: str, x: Array, y: Array) -> Line:
    return Line(METHOD_NAMES.get(name, name), x, y, _colour(index, name), METHOD_WIDTHS.get(name, 1.0))


def _reference(x: Array, y: Array) -> Line:
    return Line("reference", x, y, REFERENCE_COLOUR, 0.9, dashed=True)


def _colour(index: int, name: str) -> str:
    return METHOD_COLOURS.get(name, OTHER_COLOURS[index % len(OTHER_COLOURS)])
