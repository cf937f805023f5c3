"""The figures of the paper that need no run of a set: its controllers, fal, and the settling at 300 rpm."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.blocks import fal, lagrange, lambda_
from evenspin.design.rc import Repetitive, gain_db
from evenspin.design.source import loop_of
from evenspin.model import Setup, builtin_scenario
from evenspin.model.setup import InputCurve
from evenspin.native import tables
from evenspin.report.figures import Picture
from evenspin.report.style import OTHER_COLOURS, REFERENCE_COLOUR, subplots, to_svg
from evenspin.sim import simulate

Array = NDArray[np.float64]
TS_S = 1e-3
K_RC = 0.525  # with it the printed gains come out
RPM = np.pi / 30.0
PAPER = {"color": REFERENCE_COLOUR, "marker": "x", "linestyle": "none", "markersize": 6}
PRINTED_DB = ((20.83, 36.7), (20.47, 12.5))  # figure 4
SETTLE_RPM = 300.0
SETTLE_S = 2.5


def combs() -> Picture:
    """Figures 3, 4 and 10: |1 + G_RC|."""
    cases = (
        ("CRC, N = 50, 300 rpm", 50.0, True),
        ("CRC, N = 48, 307 rpm", 48.86, True),
        ("FORC, 307 rpm", 48.86, False),
    )
    rc = Repetitive(gain=K_RC)
    peaks = [n / (period * TS_S) for period in (48.0, 48.86, 50.0) for n in (1, 2, 3)]
    f_hz = np.sort(np.concatenate([np.linspace(5.0, 65.0, 1201), peaks]))
    figure, axes = subplots(1, len(cases), height=3.2, sharey=True)
    data: dict[str, Array] = {"f_hz": f_hz}
    for panel, (name, period, whole) in zip(axes.flat, cases, strict=True):
        db = gain_db(rc, period, f_hz, TS_S, whole=whole)
        panel.plot(f_hz, db, color=OTHER_COLOURS[0])
        if period == 48.86 and whole:
            panel.plot(*zip(*PRINTED_DB, strict=True), label="paper", **PAPER)
            panel.legend()
        elif not whole:
            panel.axvline(20.47, color=REFERENCE_COLOUR, linewidth=0.8, linestyle=":", label="paper: peak at 20.47 Hz")
            panel.legend()
        at = 1.0 / (period * TS_S)
        value = float(gain_db(rc, period, np.array([at]), TS_S, whole=whole)[0])
        where = {"xytext": (6, 0), "textcoords": "offset points", "fontsize": 7}
        panel.annotate(f"{value:.1f} dB at {at:.2f} Hz", (at, value), **where)
        panel.set(title=name, xlabel="frequency [Hz]", ylim=(-10.0, 45.0))
        data[f"{name.split(',')[0].lower()}_{period:g}_db"] = db
    axes[0, 0].set_ylabel("|1 + G_RC| [dB]")
    text = "Gain that repetitive control adds, k_rc 0.525; crosses: printed 36.7 and 12.5 dB."
    return Picture("figure_3_4_10", "Gain of CRC and FORC", text, to_svg(figure), data)


def delays() -> Picture:
    """Figures 7 and 8: z^-F by Lagrange interpolation."""
    figure, axes = subplots(1, 4, height=3.0)
    f_hz = np.linspace(0.0, 500.0, 251)
    z = np.exp(2j * np.pi * f_hz * TS_S)
    data: dict[str, Array] = {"f_hz": f_hz}
    for order in (1, 2, 3):
        for colour, fraction in zip(OTHER_COLOURS, (0.1, 0.3, 0.5, 0.7, 0.9), strict=True):
            response = np.sum([a * z**-k for k, a in enumerate(lagrange(order, fraction))], axis=0)
            axes[0, order - 1].plot(f_hz, np.abs(response), color=colour, label=f"F = {fraction:g}")
            data[f"n{order}_F{fraction:g}"] = np.abs(response)
            if order == 2:
                phase = np.degrees(np.unwrap(np.angle(response)))
                axes[0, 3].plot(f_hz, phase, color=colour)
                data[f"n2_F{fraction:g}_deg"] = phase
        axes[0, order - 1].set(title=f"n = {order}", xlabel="frequency [Hz]", ylim=(0.0, 1.6))
    axes[0, 3].set(title="n = 2, phase", xlabel="frequency [Hz]", ylabel="[deg]")
    axes[0, 0].set_ylabel("magnitude [-]")
    axes[0, 0].legend()
    text = (
        "As printed: F within 0 .. 1. With n = 3 and a point more on one side it amplifies; the "
        "drive's order 3 lies around its place and does not."
    )
    return Picture("figure_7_8", "Fractional delay", text, to_svg(figure), data)


def fal_curves() -> Picture:
    """Figures 12 to 14."""
    figure, axes = subplots(1, 3, height=3.0)
    e = np.linspace(-3.0, 3.0, 301)
    data: dict[str, Array] = {"e": e}
    bent = np.array([fal(float(x), 0.6, 0.4) for x in e])
    axes[0, 0].plot(e, bent, color=OTHER_COLOURS[0], label="fal(e, 0.6, 0.4)")
    axes[0, 0].plot(e, e, color=REFERENCE_COLOUR, linewidth=0.8, label="y = e")
    data["fal"] = bent
    for colour, delta in zip(OTHER_COLOURS, (0.2, 0.4, 0.6, 0.8), strict=False):
        values = np.array([lambda_(float(x), 0.6, delta) for x in e])
        axes[0, 1].plot(e, values, color=colour, label=f"delta = {delta:g}")
        data[f"lambda_delta{delta:g}"] = values
    for colour, alpha in zip(OTHER_COLOURS, (0.2, 0.4, 0.6, 0.8), strict=False):
        values = np.array([lambda_(float(x), alpha, 0.4) for x in e])
        axes[0, 2].plot(e, values, color=colour, label=f"alpha = {alpha:g}")
        data[f"lambda_alpha{alpha:g}"] = values
    axes[0, 1].plot([0.0], [1.4], label="paper: 1.4", **PAPER)
    titles = ("fal", "lambda, alpha = 0.6", "lambda, delta = 0.4")
    for panel, title in zip(axes.flat, titles, strict=True):
        panel.set(title=title, xlabel="e [unit]")
        panel.legend()
    text = "The largest lambda at alpha 0.6 and delta 0.4 is 0.4^-0.4 = 1.4427; the paper says 1.4."
    return Picture("figure_12_13_14", "fal and its gain", text, to_svg(figure), data)


def phase() -> Picture:
    """Figure 16: z^m M."""
    setup = builtin_scenario("guo2024/first").setup
    loop = loop_of(setup.plant, setup.drive)
    f_hz = np.geomspace(1.0, 499.0, 400)
    closed = loop.closed(f_hz)
    figure, axes = subplots(1, 2, height=3.2)
    axes[0, 0].semilogx(f_hz, 20.0 * np.log10(np.abs(closed)), color=OTHER_COLOURS[0])
    axes[0, 0].axhline(20.0 * np.log10(1.31), label="paper: largest |M| 1.31", color=REFERENCE_COLOUR, linestyle=":")
    data: dict[str, Array] = {"f_hz": f_hz, "m_db": 20.0 * np.log10(np.abs(closed))}
    for m in range(8):
        phase = np.degrees(np.unwrap(np.angle(closed * np.exp(2j * np.pi * f_hz * TS_S * m))))
        shown = np.where(np.abs(phase) < 200.0, phase, np.nan)
        axes[0, 1].semilogx(f_hz, shown, label=f"m = {m}", color=OTHER_COLOURS[m % 5], linestyle="-" if m < 5 else "--")
        data[f"m{m}_deg"] = phase
    for level in (-27.4, 27.4):
        axes[0, 1].axhline(level, color=REFERENCE_COLOUR, linestyle=":", linewidth=0.8)
    axes[0, 0].set(xlabel="frequency [Hz]", ylabel="|M| [dB]")
    axes[0, 1].set(xlabel="frequency [Hz]", ylabel="phase of z^m M [deg]", ylim=(-200.0, 200.0))
    axes[0, 0].legend()
    axes[0, 1].legend(ncols=2)
    text = (
        "Dotted: the paper's 1.31 and 27.4 deg up to 40 Hz, which come out of a loop in r/min with other "
        "inertia; here 1.20 and 34 deg with m = 5."
    )
    return Picture("figure_16", "z^m M", text, to_svg(figure), data)


@dataclass(frozen=True, slots=True)
class Settling:
    """One start to 300 rpm; `since_s`: when it is near, infinite when never; `peak_rpm`: the overshoot."""

    t_s: Array
    rpm: Array
    since_s: float
    peak_rpm: float


@functools.cache
def leads() -> Mapping[str, Settling]:
    return {f"m = {m}": _settle(settling_setup(rc_lead=float(m))) for m in (0, 2, 3, 4, 5, 6, 7, 8)}


@functools.cache
def gains() -> Mapping[str, Settling]:
    return {f"k_rc = {k:g}": _settle(settling_setup(rc_gain=k)) for k in (0.2, 0.4, 0.6, 0.8, 1.0)}


def _settle(setup: Setup) -> Settling:
    record = simulate(setup, ("t_s", "true_speed_rad_s"))
    rpm = record["true_speed_rad_s"] / RPM
    return Settling(record["t_s"], rpm, settled_s(record["t_s"], rpm), float(rpm.max() - SETTLE_RPM))


def _settling(found: Mapping[str, Settling], name: str, title: str, text: str) -> Picture:
    figure, axes = subplots(2, -(-len(found) // 2), height=4.4, sharex=True, sharey=True)
    data: dict[str, Array] = {}
    for panel, (label, one) in zip(axes.flat, found.items(), strict=False):
        panel.plot(one.t_s, one.rpm, color=OTHER_COLOURS[0], linewidth=0.7)
        said = f"{one.since_s:.2f} s" if np.isfinite(one.since_s) else "does not settle"
        panel.set(title=f"{label}: {said}", ylim=(150.0, 480.0))
        data |= {"t_s": one.t_s, f"{label.replace(' ', '_')}_rpm": one.rpm}
    for panel in list(axes.flat)[len(found) :]:
        panel.set_visible(False)
    for row in axes:
        row[0].set_ylabel("speed [rpm]")
    for panel in axes[-1]:
        panel.set_xlabel("time [s]")
    return Picture(name, title, text, to_svg(figure), data)


def settled_s(t_s: Array, rpm: Array, within_rpm: float = 1.5) -> float:
    """Since when the speed stays near its reference; infinite when it does not."""
    outside = np.flatnonzero(np.abs(rpm - SETTLE_RPM) > within_rpm)
    if not outside.size:
        return 0.0
    return float(t_s[outside[-1]]) if outside[-1] + 1 < len(t_s) else float("inf")


def settling_setup(**drive: float) -> Setup:
    """FORC from rest to 300 rpm under 1 A."""
    method = tables().params["method"].to_number("forc")
    setup = builtin_scenario("guo2024/second").with_changes({"method": method, **drive})
    speed = InputCurve((0.0,), (SETTLE_RPM * RPM,))
    inputs = {**setup.inputs, "speed_ref_rad_s": speed, "load_brake_nm": _first(setup.inputs["load_brake_nm"])}
    return replace(setup, inputs=inputs, duration_s=SETTLE_S)


def _first(curve: InputCurve) -> InputCurve:
    return InputCurve(curve.t_s[:1], curve.value[:1])


def leads_picture() -> Picture:
    text = (
        "FORC at 300 rpm; behind the colon when it has settled to 1.5 rpm. The paper finds m = 5 best, here 5 or 6 are."
    )
    return _settling(leads(), "figure_21", "Phase lead m", text)


def gains_picture() -> Picture:
    text = (
        "FORC at 300 rpm; behind the colon when it has settled to 1.5 rpm. As in the paper, more gain "
        "settles sooner and overshoots more."
    )
    return _settling(gains(), "figure_22", "Learning gain k_rc", text)
