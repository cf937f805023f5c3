"""The fits: what was measured, and what was found in it."""

from __future__ import annotations

import numpy as np

from evenspin.identify.friction import Friction
from evenspin.identify.inertia import Inertia
from evenspin.identify.result import Identified
from evenspin.identify.source import TURN_RAD
from evenspin.identify.spectrum import Spectrum
from evenspin.report.figures import Picture
from evenspin.report.style import OTHER_COLOURS, REFERENCE_COLOUR, drawing, subplots, to_svg

MEASURED = {"color": OTHER_COLOURS[0], "marker": ".", "linestyle": "none"}
FOUND = {"color": OTHER_COLOURS[3], "linewidth": 1.2}
SHOWN_POINTS = 4000


def pictures(found: Identified) -> list[Picture]:
    with drawing():
        drawn = [_friction(found.friction)] if found.friction is not None else []
        drawn += [_inertia(found.inertia)] if found.inertia is not None else []
        drawn += [_spectrum(found.spectrum), _angle(found.spectrum)] if found.spectrum is not None else []
    return drawn


def _friction(found: Friction) -> Picture:
    v = np.array([point.speed_rad_s for point in found.points])
    torque = np.array([point.torque_nm for point in found.points])
    figure, axes = subplots(1, 2, height=3.4)
    slow = 6.0 * found.value("stribeck_rad_s")
    for panel, reach in zip(axes.flat, (np.abs(v).max(), min(slow, np.abs(v).max())), strict=True):
        for sign in (-1.0, 1.0):
            line = sign * np.linspace(1e-4, 1.0, 300) * reach
            panel.plot(line, found.torque_nm(line), label="model" if sign > 0 else None, **FOUND)
        shown = np.abs(v) <= reach * (1.0 + 1e-9)
        panel.plot(v[shown], torque[shown], label="mean over whole turns", **MEASURED)
        panel.set(xlabel="speed [rad/s]")
    axes[0, 0].set(ylabel="torque [N m]", title="all speeds")
    axes[0, 1].set(title="slow")
    axes[0, 0].legend()
    data = {"speed_rad_s": v, "torque_nm": torque, "model_nm": found.torque_nm(v), "residual_nm": found.residual_nm}
    return Picture("friction", "Friction", "Mean torque over whole turns at constant speed.", to_svg(figure), data)


def _inertia(found: Inertia) -> Picture:
    step = max(1, len(found.acceleration_rad_s2) // SHOWN_POINTS)
    a, torque = found.acceleration_rad_s2[::step], found.inertial_nm[::step]
    figure, axes = subplots(height=3.2)
    axes[0, 0].plot(a, torque, label="torque less friction and whole orders", markersize=2.0, **MEASURED)
    ends = np.array([a.min(), a.max()])
    axes[0, 0].plot(ends, found.inertia_kgm2.value * ends, label="J a", **FOUND)
    axes[0, 0].set(xlabel="acceleration [rad/s^2]", ylabel="torque [N m]")
    axes[0, 0].legend()
    data = {"acceleration_rad_s2": a, "torque_nm": torque}
    return Picture("inertia", "Inertia", "The slope is the inertia.", to_svg(figure), data)


def _spectrum(found: Spectrum) -> Picture:
    figure, axes = subplots(height=3.2)
    shown = found.order <= 2.5 * max(line.cycles.value for line in found.lines)
    order, amplitude = found.order[shown], 1e3 * found.amplitude_nm[shown]
    axes[0, 0].plot(order, np.maximum(amplitude, 1e-4), color=OTHER_COLOURS[0], label="spectrum")
    cycles = np.array([line.cycles.value for line in found.lines])
    size = 1e3 * np.array([line.amplitude_nm.value for line in found.lines])
    axes[0, 0].plot(cycles, size, color=OTHER_COLOURS[3], marker="o", linestyle="none", label="refined lines")
    axes[0, 0].set(xlabel="order [cycles per turn]", ylabel="torque [mN m]", yscale="log", xlim=(0.0, None))
    axes[0, 0].legend()
    data = {"order": order, "amplitude_mnm": amplitude, "line_cycles": cycles, "line_mnm": size}
    text = f"{found.turns} turns, Hann window; the lines are refined by least squares."
    return Picture("spectrum", "Spectrum over the angle", text, to_svg(figure), data)


def _angle(found: Spectrum) -> Picture:
    """The last turn: measured and model."""
    figure, axes = subplots(height=3.2)
    last = found.theta_rad >= found.theta_rad[-1] - TURN_RAD
    turn = found.theta_rad[last] / TURN_RAD
    measured, fit = 1e3 * found.torque_nm[last], 1e3 * found.fit_nm[last]
    axes[0, 0].plot(turn, measured, color=OTHER_COLOURS[0], label="mean in cells of the angle", linewidth=0.8)
    axes[0, 0].plot(turn, fit, label="lines", **FOUND)
    axes[0, 0].axhline(float(fit.mean()), color=REFERENCE_COLOUR, linewidth=0.6)
    axes[0, 0].set(xlabel="angle [turn]", ylabel="torque [mN m]")
    axes[0, 0].legend()
    data = {"turn": turn, "torque_mnm": measured, "fit_mnm": fit}
    return Picture("angle", "Torque over the last turn", "Friction is in the mean.", to_svg(figure), data)
