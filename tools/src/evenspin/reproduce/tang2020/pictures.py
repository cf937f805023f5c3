"""Pictures of the result: before and after, spectrum, convergence, transients, and what was learned."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.orders import order_spectrum
from evenspin.analysis.segments import RAD_S
from evenspin.report.curves import envelope
from evenspin.report.figures import Picture
from evenspin.report.style import (
    METHOD_COLOURS,
    METHOD_NAMES,
    OTHER_COLOURS,
    REFERENCE_COLOUR,
    drawing,
    subplots,
    to_svg,
)
from evenspin.reproduce.tang2020.conditions import OFF
from evenspin.reproduce.tang2020.measure import TAU
from evenspin.reproduce.tang2020.result import Result, Run
from evenspin.sim import Record

Array = NDArray[np.float64]
Data = dict[str, Array]

SHOWN = (OFF, "aro", "aro-beyond")
STEADY = (
    "100 rpm",
    "123 rpm",
    "451 rpm",
    "1000 rpm",
    "misalignment, 1000 rpm",
    "sensor errors, full load",
)
LEARNING = ("100 rpm", "451 rpm")
SPECTRA = ("100 rpm", "451 rpm", "misalignment, 1000 rpm", "sensor errors, full load")
LOAD_STEP, SPEED_STEP = "load step", "speed step"
MAX_ORDER = 40.0
TURNS_SHOWN = 1.0
STEP_S = 50.0


def pictures_of(result: Result) -> list[Picture]:
    """Those for which there are runs."""
    with drawing():
        drawn = [
            speed_picture(result),
            spectrum_picture(result),
            convergence_picture(result),
            step_picture(result, LOAD_STEP, "load_step", "Load step", "4.4 N m at 100 rpm after 50 s of learning"),
            step_picture(result, SPEED_STEP, "speed_step", "Speed step", "123 to 451 rpm after 50 s of learning"),
            memory_picture(result),
            sweep_picture(result),
        ]
    return [picture for picture in drawn if picture is not None]


def speed_picture(result: Result) -> Picture | None:
    """One mechanical turn of each condition, with the observer and without."""
    names = [name for name in STEADY if len(runs_of(result, name, SHOWN)) > 1]
    if not names:
        return None
    rows = -(-len(names) // 2)
    figure, axes = subplots(rows, 2, height=2.1 * rows + 0.6)
    data: Data = {}
    for panel, name in zip(axes.flat, names, strict=False):
        for run in runs_of(result, name, SHOWN):
            turn, rpm = _last_turn(record_of(run))
            method_line(panel, run.method, turn, rpm)
            data |= {f"{name}_{run.method}_turn": turn, f"{name}_{run.method}_rpm": rpm}
        panel.set(title=name, xlabel="mechanical angle [turn]", ylabel="speed [rpm]", xlim=(0.0, TURNS_SHOWN))
    finish(figure, axes, len(names))
    text = "True speed over the last turn of the steady state: without an observer, and after 50 s with it."
    return Picture("speed", "Speed, off and on", text, to_svg(figure), data)


def spectrum_picture(result: Result) -> Picture | None:
    names = [name for name in SPECTRA if len(runs_of(result, name, SHOWN)) > 1]
    if not names:
        return None
    rows = -(-len(names) // 2)
    figure, axes = subplots(rows, 2, height=2.3 * rows + 0.6, sharex=True)
    data: Data = {}
    for panel, name in zip(axes.flat, names, strict=False):
        for run in runs_of(result, name, SHOWN):
            window = run.condition.windows_of(run.method)[0]
            part = record_of(run).between(window.start_s, window.end_s)
            rpm, theta = part["true_speed_rad_s"] / RAD_S, part["true_theta_m_rad"]
            order, amplitude = order_spectrum(rpm, theta, MAX_ORDER)
            method_line(panel, run.method, order, np.maximum(amplitude, 1e-5))
            data |= {f"{name}_{run.method}_order": order, f"{name}_{run.method}_rpm": amplitude}
        panel.set(title=name, yscale="log", ylim=(1e-4, 20.0), xlim=(0.0, MAX_ORDER))
        panel.set(xlabel="mechanical order [-]", ylabel="speed ripple [rpm]")
    finish(figure, axes, len(names))
    text = (
        "Amplitude over the mechanical turn; order 12, 24, 36: cogging, 10, 20, 30: inverter, 5, 10: current sensors."
    )
    return Picture("spectrum", "Speed spectrum in mechanical orders", text, to_svg(figure), data)


def convergence_picture(result: Result) -> Picture | None:
    methods = ("aro", "ro", "aro-beyond")
    names = [name for name in LEARNING if runs_of(result, name, methods)]
    if not names:
        return None
    figure, axes = subplots(1, len(names), height=3.2, sharey=True)
    data: Data = {}
    for panel, name in zip(axes.flat, names, strict=True):
        for run in runs_of(result, name, methods):
            t_s, rms = envelope(run.turn_s, run.turn_rms_rpm)
            method_line(panel, run.method, t_s, rms)
            data |= {f"{name}_{run.method}_t_s": t_s, f"{name}_{run.method}_rms_rpm": rms}
        off = runs_of(result, name, (OFF,))
        if off:
            _level(panel, off[0].seen[0].rms_rpm, "off")
            _level(panel, 0.1 * off[0].seen[0].rms_rpm, "a tenth of it")
        panel.set(title=name, yscale="log", xlabel="time since switched on [s]", ylabel="speed rms of a turn [rpm]")
        panel.set(xlim=(0.0, 50.0), ylim=(5e-3, 30.0))
    finish(figure, axes, len(names))
    text = "Rms of the speed in each mechanical turn while the observer learns; it starts with an empty memory."
    return Picture("convergence", "Convergence", text, to_svg(figure), data)


def step_picture(result: Result, condition: str, name: str, title: str, text: str) -> Picture | None:
    runs = runs_of(result, condition, SHOWN)
    if len(runs) < 2:
        return None
    figure, axes = subplots(1, 2, height=3.0)
    data: Data = {}
    reference_rpm = runs[0].condition.speed_rpm
    for run in runs:
        record = record_of(run)
        near = record.between(STEP_S - 0.2, STEP_S + 1.0)
        near_s, near_rpm = near["t_s"] - STEP_S, near["true_speed_rad_s"] / RAD_S
        method_line(axes[0, 0], run.method, near_s, near_rpm)
        after = record.between(STEP_S + 0.3, STEP_S + 6.0)
        t_s, rpm = envelope(after["t_s"] - STEP_S, after["true_speed_rad_s"] / RAD_S)
        method_line(axes[0, 1], run.method, t_s, rpm)
        data |= {f"{run.method}_near_t_s": near_s, f"{run.method}_near_rpm": near_rpm}
        data |= {f"{run.method}_t_s": t_s, f"{run.method}_rpm": rpm}
    axes[0, 0].set(title="the step", xlim=(-0.2, 1.0))
    half = 1.3 * max(np.abs(data[f"{runs[0].method}_rpm"] - reference_rpm).max(), 0.1)
    axes[0, 1].set(title="afterwards", xlim=(0.3, 6.0), ylim=(reference_rpm - half, reference_rpm + half))
    for panel in axes.flat:
        panel.set(xlabel="time after the step [s]", ylabel="speed [rpm]")
    finish(figure, axes, 2)
    return Picture(name, title, f"{text}.", to_svg(figure), data)


def memory_picture(result: Result) -> Picture | None:
    """What was learned, against the torque that is there."""
    runs = runs_of(result, "100 rpm", ("aro", "aro-beyond"))
    if not runs:
        return None
    figure, axes = subplots(2, 1, height=4.4)
    theta = np.linspace(0.0, TAU, 3601)
    truth = 1e3 * true_ripple_nm(runs[0], theta)
    data: Data = {"true_angle_deg": np.degrees(theta), "true_mnm": truth}
    for panel in axes.flat:
        panel.plot(np.degrees(theta), truth, color=REFERENCE_COLOUR, linewidth=2.0, alpha=0.35, label="true ripple")
        for run in runs:
            angle, learned = memory_mnm(run)
            method_line(panel, run.method, angle, learned)
            data |= {f"{run.method}_angle_deg": angle, f"{run.method}_mnm": learned}
        panel.set(xlabel="mechanical angle [deg]", ylabel="torque [mN m]")
    axes[0, 0].set(xlim=(0.0, 360.0))
    axes[1, 0].set(xlim=(0.0, 60.0))
    finish(figure, axes, 2)
    text = "Disturbance torque in the memory after 55 s at 100 rpm, and the torque ripple of the simulated motor."
    return Picture("memory", "Learned memory", text, to_svg(figure), data)


def sweep_picture(result: Result) -> Picture | None:
    if not result.sweep:
        return None
    points = result.sweep
    rpm = np.array([point.speed_rpm for point in points])
    off = np.array([sum(point.off_rpm) / 2.0 for point in points])
    on, rests = np.array([point.on_rpm for point in points]), np.array([point.rests for point in points])
    figure, axes = subplots(height=3.2)
    panel = axes[0, 0]
    method_line(panel, OFF, rpm, off)
    method_line(panel, "aro-beyond", rpm, on, marker=".", markersize=4)
    panel.plot(rpm[rests], on[rests], "o", color=OTHER_COLOURS[3], label="learning pauses", markersize=5)
    panel.set(xlabel="speed [rpm]", ylabel="speed ripple [rpm rms]", yscale="log", xlim=(0.0, rpm.max() * 1.02))
    finish(figure, axes, 1)
    text = "At the marked speeds the rounding of the encoder repeats from turn to turn; there nothing is learned."
    data = {"speed_rpm": rpm, "off_rpm": off, "on_rpm": on, "rests": rests.astype(float)}
    return Picture("sweep", "Sweep", text, to_svg(figure), data)


def true_ripple_nm(run: Run, theta_rad: Array) -> Array:
    """The torque of the effect torque_ripple; positive drives forward."""
    lines = run.setup.effects["torque_ripple"]
    total = np.zeros_like(theta_rad)
    for k in range(1, 7):
        order, amplitude_nm, phase = (lines[f"{what}_{k}{unit}"] for what, unit in _LINE)
        total -= amplitude_nm * np.sin(order * theta_rad + phase)
    return total


_LINE = (("order", ""), ("amplitude", "_nm"), ("phase", "_rad"))


def memory_mnm(run: Run) -> tuple[Array, Array]:
    """(mechanical angle, deg; learned torque without its mean, mN m)."""
    torque_per_a_nm = 1.5 * run.setup.plant["pole_pairs"] * run.setup.plant["psi_wb"]
    angle = 360.0 * np.arange(len(run.memory_a)) / len(run.memory_a)
    return angle, 1e3 * torque_per_a_nm * (run.memory_a - run.memory_a.mean())


def runs_of(result: Result, condition: str, methods: Sequence[str]) -> list[Run]:
    found = (result.run(condition, method) for method in methods)
    return [run for run in found if run is not None and (run.record is not None or len(run.memory_a))]


def record_of(run: Run) -> Record:
    assert run.record is not None
    return run.record


def _last_turn(record: Record) -> tuple[Array, Array]:
    """(turns from a whole mechanical turn on, speed in rpm) of the last complete one."""
    turn = record["true_theta_m_rad"] / TAU
    end = np.floor(turn[-1])
    kept = (turn >= end - TURNS_SHOWN) & (turn <= end)
    return turn[kept] - (end - TURNS_SHOWN), record["true_speed_rad_s"][kept] / RAD_S


def method_line(panel: Any, method: str, x: Array, y: Array, **options: Any) -> None:
    style = {"color": METHOD_COLOURS[method], "label": METHOD_NAMES[method], "linewidth": 1.0} | options
    panel.plot(x, y, **style)


def _level(panel: Any, value: float, label: str) -> None:
    panel.axhline(value, color=REFERENCE_COLOUR, linewidth=0.9, linestyle="--" if label == "off" else ":", label=label)


def finish(figure: Any, axes: Any, used: int) -> None:
    """Hide what is empty; one legend above all panels; speeds in full."""
    for panel in list(axes.flat)[used:]:
        panel.set_visible(False)
    for panel in axes.flat:
        if panel.get_yscale() == "linear":
            panel.ticklabel_format(useOffset=False)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=len(labels), handlelength=1.6)
