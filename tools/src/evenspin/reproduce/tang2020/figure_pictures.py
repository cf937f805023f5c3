"""The figures of the paper: without an observer and with ARO as printed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.orders import order_spectrum
from evenspin.analysis.segments import RAD_S
from evenspin.report.curves import envelope
from evenspin.report.figures import Picture
from evenspin.report.style import EXPERIMENT_COLOUR, OTHER_COLOURS, subplots, to_svg
from evenspin.reproduce.tang2020.conditions import OFF
from evenspin.reproduce.tang2020.measure import TAU
from evenspin.reproduce.tang2020.pictures import (
    MAX_ORDER,
    STEP_S,
    Data,
    finish,
    method_line,
    record_of,
    runs_of,
)
from evenspin.reproduce.tang2020.result import Result, Run

Array = NDArray[np.float64]
ON = "aro"
BOTH = (OFF, ON)
SENSORS, MISALIGNED = "sensor errors, full load", "misalignment, 1000 rpm"
DETUNED = ("100 rpm, J x 0.5", "100 rpm", "100 rpm, J x 1.5", "100 rpm, J x 2")
FRICTION = ("100 rpm, B x 0.1", "100 rpm", "100 rpm, B x 10")
MAIN_ORDERS = (10, 12, 20, 24, 30, 36)
RIG_2_J, RIG_2_B, TS_S = 9e-4, 4e-3, 1e-4  # as printed
BODE_FACTORS = (0.5, 1.0, 1.5, 2.0)


def pair(result: Result, condition: str) -> tuple[Run, Run] | None:
    """(off, on), where both were run and kept."""
    off, on = (result.run(condition, method) for method in BOTH)
    if off is None or on is None or off.record is None or on.record is None:
        return None
    return off, on


def spectrum_of(run: Run) -> tuple[Array, Array]:
    """(mechanical order, speed in rpm) of the first window."""
    window = run.condition.windows_of(run.method)[0]
    part = record_of(run).between(window.start_s, window.end_s)
    return order_spectrum(part["true_speed_rad_s"] / RAD_S, part["true_theta_m_rad"], MAX_ORDER)


def shaft_torque_nm(run: Run) -> tuple[Array, Array, Array]:
    """(time, turn, torque that the machine gives to shaft and load) in the first window: load and friction, and inertia
    times acceleration."""
    window = run.condition.windows_of(run.method)[0]
    part = record_of(run).between(window.start_s, window.end_s)
    t_s, speed = part["t_s"], part["true_speed_rad_s"]
    plant = run.setup.plant
    load = run.setup.inputs.get("load_torque_nm")
    constant = (load.value[-1] if load is not None else 0.0) + plant["viscous_nms"] * speed
    torque = plant["inertia_kgm2"] * np.gradient(speed, t_s) + constant
    return t_s, part["true_theta_m_rad"] / TAU, torque


def currents_and_torque(result: Result) -> Picture | None:
    """Figure 9a, 9c, 9d, 9e."""
    found = pair(result, SENSORS)
    if found is None:
        return None
    figure, axes = subplots(3, 1, height=6.6)
    data: Data = {}
    off = found[0]
    part = record_of(off)
    window = off.condition.windows_of(off.method)[0]
    part = part.between(window.start_s, window.end_s)
    shown = part["t_s"] <= part["t_s"][0] + 0.25
    t_s = part["t_s"][shown] - part["t_s"][0]
    for colour, phase in zip(OTHER_COLOURS, "abc", strict=False):
        true = part[f"true_i{phase}_a"][shown]
        axes[0, 0].plot(t_s, true, color=colour, linewidth=0.8, linestyle=":", label=f"i_{phase}, true")
        data |= {"t_s": t_s, f"true_i{phase}_a": true}
        if phase != "c":
            measured = part[f"i{phase}_a"][shown]
            axes[0, 0].plot(t_s, measured, color=colour, linewidth=1.2, label=f"i_{phase}, measured")
            data[f"i{phase}_a"] = measured
    for run in found:
        _, turn, torque = shaft_torque_nm(run)
        last = turn >= turn[-1] - 1.0
        angle = turn[last] - turn[last][0]
        method_line(axes[1, 0], run.method, angle, torque[last])
        rpm = -record_of(run).between(*_window(run))["true_speed_rad_s"][last] / RAD_S
        method_line(axes[2, 0], run.method, angle, rpm)
        data |= {f"{run.method}_turn": angle, f"{run.method}_nm": torque[last], f"{run.method}_load_rpm": rpm}
    axes[0, 0].set(xlabel="time [s]", ylabel="current [A]", title="9a: phase currents without observer")
    axes[1, 0].set(ylabel="torque [N m]", title="9c: torque on the shaft")
    axes[2, 0].set(
        xlabel="mechanical angle [turn]", ylabel="speed [rpm]", title="9d, 9e: speed, as the load drive counts"
    )
    axes[0, 0].set(ylim=(-9.5, 12.5))
    axes[0, 0].legend(ncols=5, loc="upper right")
    axes[1, 0].legend(ncols=2)
    for panel in axes.flat:
        panel.ticklabel_format(useOffset=False)
    text = (
        "Offset of 10 % in phase a and gain error of 14 % in phase b (paper: c, which this drive does not measure). "
        "The torque sensor of the paper stands between two machines; here it is all the torque that the motor gives to "
        "shaft and load."
    )
    return Picture("figure_9a_9c_9d_9e", "Currents, torque and speed with sensor errors", text, to_svg(figure), data)


def _window(run: Run) -> tuple[float, float]:
    window = run.condition.windows_of(run.method)[0]
    return window.start_s, window.end_s


def spectra(result: Result, conditions: Sequence[str], name: str, title: str, text: str) -> Picture | None:
    """Bars of the orders, off and on, one panel for each condition."""
    found = [(condition, both) for condition in conditions if (both := pair(result, condition)) is not None]
    if not found:
        return None
    figure, axes = subplots(1, len(found), height=3.2, sharey=True)
    data: Data = {}
    for panel, (condition, both) in zip(axes.flat, found, strict=True):
        for run in both:
            order, rpm = spectrum_of(run)
            method_line(panel, run.method, order, rpm)
            data |= {f"{condition}_{run.method}_order": order, f"{condition}_{run.method}_rpm": rpm}
        panel.set(title=condition, xlabel="mechanical order [-]", xlim=(0.0, MAX_ORDER), ylim=(0.0, None))
    axes[0, 0].set_ylabel("speed ripple [rpm]")
    finish(figure, axes, len(found))
    return Picture(name, title, text, to_svg(figure), data)


def misalignment(result: Result) -> Picture | None:
    """Figure 9f."""
    found = pair(result, MISALIGNED)
    if found is None:
        return None
    figure, axes = subplots(height=3.0)
    data: Data = {}
    spans = []
    for run in found:
        part = record_of(run).between(*_window(run))
        turn, rpm = part["true_theta_m_rad"] / TAU, part["true_speed_rad_s"] / RAD_S
        last = turn >= turn[-1] - 3.0
        method_line(axes[0, 0], run.method, *envelope(turn[last] - turn[last][0], rpm[last]))
        data |= {f"{run.method}_turn": turn[last], f"{run.method}_rpm": rpm[last]}
        spans.append(run.seen[0].pp_rpm)
    half = 0.5 * spans[0] * (1.0 - 0.76)
    for level, label in ((1000.0 - half, None), (1000.0 + half, "paper: peak to peak -76 %")):
        axes[0, 0].axhline(level, color=EXPERIMENT_COLOUR, linewidth=0.9, linestyle="--", label=label)
    axes[0, 0].set(xlabel="mechanical angle [turn]", ylabel="speed [rpm]", xlim=(0.0, 3.0))
    finish(figure, axes, 1)
    text = "Speed at 1000 rpm with a misaligned coupling; dashed: where the paper's reduction of 76 % would leave ours."
    return Picture("figure_9f", "Misalignment at 1000 rpm", text, to_svg(figure), data)


def step(result: Result, condition: str, name: str, title: str, text: str) -> Picture | None:
    """Figures 11 and 12: the step, and the speed afterwards."""
    found = [run for run in runs_of(result, condition, BOTH) if run.record is not None]
    if len(found) < 2:
        return None
    figure, axes = subplots(1, 2, height=3.0)
    data: Data = {}
    reference_rpm = found[0].condition.speed_rpm
    for run in found:
        record = record_of(run)
        for panel, start_s, end_s, key in ((axes[0, 0], -0.5, 1.5, "near"), (axes[0, 1], 1.0, 3.0, "after")):
            part = record.between(STEP_S + start_s, STEP_S + end_s)
            t_s, rpm = envelope(part["t_s"] - STEP_S, part["true_speed_rad_s"] / RAD_S)
            method_line(panel, run.method, t_s, rpm)
            data |= {f"{run.method}_{key}_t_s": t_s, f"{run.method}_{key}_rpm": rpm}
    half = 1.3 * max(float(np.abs(data[f"{OFF}_after_rpm"] - reference_rpm).max()), 0.1)
    axes[0, 1].set(ylim=(reference_rpm - half, reference_rpm + half))
    for panel in axes.flat:
        panel.set(xlabel="time after the step [s]", ylabel="speed [rpm]")
    finish(figure, axes, 2)
    return Picture(name, title, text, to_svg(figure), data)


def detuned(result: Result) -> Picture | None:
    """Figure 13: spectra with wrong J (a, b) and wrong B."""
    off = pair(result, "100 rpm")
    groups = [("J", DETUNED), ("B", FRICTION)]
    if off is None or any(result.run(name, ON) is None for _, names in groups for name in names):
        return None
    figure, axes = subplots(1, 3, height=3.2)
    data: Data = {}
    order, rpm = spectrum_of(off[0])
    data |= {"off_order": order, "off_rpm": rpm}
    for panel in (axes[0, 0], axes[0, 2]):
        method_line(panel, OFF, order, rpm)
    for panel, (letter, names) in zip((axes[0, 0], axes[0, 2]), groups, strict=True):
        for index, (colour, name) in enumerate(zip(OTHER_COLOURS, names, strict=False)):
            run = result.run(name, ON)
            assert run is not None
            order, rpm = spectrum_of(run)
            label = name.removeprefix("100 rpm, ").replace("100 rpm", f"{letter} x 1")
            panel.plot(order, rpm, color=colour, linewidth=1.0, label=label)
            data |= {f"{label}_order": order, f"{label}_rpm": rpm}
            if letter == "J":
                at = np.arange(len(MAIN_ORDERS)) + 0.2 * (index - 1.5)
                bars = [run.seen[0].orders[each] for each in MAIN_ORDERS]
                axes[0, 1].bar(at, bars, 0.2, color=colour, label=label)
                data[f"{label}_main_rpm"] = np.array(bars)
    axes[0, 0].set(title="13a: wrong J", ylabel="speed ripple [rpm]")
    axes[0, 1].set(title="13b: wrong J, main orders with ARO", xticks=range(len(MAIN_ORDERS)))
    axes[0, 1].set_xticklabels(map(str, MAIN_ORDERS))
    axes[0, 2].set(title="wrong B")
    for panel in axes.flat:
        panel.set(xlabel="mechanical order [-]")
        panel.legend()
    for panel in (axes[0, 0], axes[0, 2]):
        panel.set(xlim=(0.0, MAX_ORDER))
    text = "Speed spectrum at 100 rpm with ARO whose mechanical parameters are wrong, and without an observer."
    return Picture("figure_13", "Wrong mechanical parameters", text, to_svg(figure), data)


def transfer(factor: float, f_hz: Array) -> Array:
    """(1 - a22 / z) / a23 with J times `factor`, times the true P_2(z) (equation 21 and below it), Rig 2."""
    inertia, b, ts = RIG_2_J, RIG_2_B, TS_S
    j = factor * inertia
    z = np.exp(2j * np.pi * f_hz * ts)
    inverse: Array = (j - (j - b * ts) / z) / ts
    plant: Array = ts / (inertia * z - (inertia - b * ts))
    return inverse * plant


def bode(_: Result) -> Picture:
    """Figure 14."""
    figure, axes = subplots(1, 2, height=3.2)
    f_hz = np.geomspace(0.05, 1000.0, 400)
    data: Data = {"f_hz": f_hz}
    for colour, factor in zip(OTHER_COLOURS, BODE_FACTORS, strict=False):
        response = transfer(factor, f_hz)
        db, phase = 20.0 * np.log10(np.abs(response)), np.degrees(np.unwrap(np.angle(response)))
        axes[0, 0].semilogx(f_hz, db, color=colour, label=f"J x {factor:g}")
        axes[0, 1].semilogx(f_hz, phase, color=colour)
        data |= {f"J{factor:g}_db": db, f"J{factor:g}_deg": phase}
    axes[0, 0].axhline(-6.0, color=EXPERIMENT_COLOUR, linewidth=0.9, linestyle="--", label="paper: -6 dB")
    for panel in axes.flat:
        for order in (12, 24):
            panel.axvline(order * 100.0 / 60.0, color=OTHER_COLOURS[3], linewidth=0.7, linestyle=":")
        panel.set(xlabel="frequency [Hz]")
    axes[0, 0].set(ylabel="magnitude [dB]")
    axes[0, 1].set(ylabel="phase [deg]")
    axes[0, 0].legend()
    text = "What a wrong J makes of the torque that is seen; dotted: 12th and 24th order at 100 rpm."
    return Picture("figure_14", "Torque seen with a wrong J", text, to_svg(figure), data)
