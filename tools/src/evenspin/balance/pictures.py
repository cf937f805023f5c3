"""The pictures of a torque balance, each with its numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.analysis import Analysis
from evenspin.report.curves import envelope
from evenspin.report.figures import Picture
from evenspin.report.style import OTHER_COLOURS, REFERENCE_COLOUR, drawing, subplots, to_svg

Array = NDArray[np.float64]

DOTS = 2500
BINS = 24
SHOWN_S = 1.0
BEFORE, AFTER = OTHER_COLOURS[1], OTHER_COLOURS[0]


def pictures(analysis: Analysis) -> list[Picture]:
    with drawing():
        drawn = []
        if analysis.friction is not None:
            drawn.append(_balance_over_speed(analysis))
        if analysis.angle is not None:
            drawn += [_order_spectrum(analysis), _balance_over_angle(analysis)]
        if analysis.controller is not None:
            drawn.append(_parts(analysis))
        if analysis.ripple is not None:
            drawn += [_ripple_in_time(analysis), _ripple_in_orders(analysis)]
    return drawn


def _balance_over_speed(analysis: Analysis) -> Picture:
    found = analysis.friction
    assert found is not None
    rows = np.flatnonzero(found.validation_rows)
    rows = rows[:: max(1, len(rows) // DOTS)]
    speed = found.motion.speed_rad_s
    figure, axes = subplots(1, 2, height=3.6, sharey=True)
    data: dict[str, Any] = {"speed_rad_s": speed[rows]}
    for panel, residue, name, colour in (
        (axes[0, 0], found.before, "before", BEFORE),
        (axes[0, 1], found.after, "after", AFTER),
    ):
        panel.plot(speed[rows], 1e3 * residue[rows], ".", markersize=1.5, alpha=0.4, color=colour)
        centre, mean = _binned(speed[found.validation_rows], residue[found.validation_rows])
        panel.plot(centre, 1e3 * mean, color=REFERENCE_COLOUR, linewidth=1.6, label="mean")
        panel.set(title=f"{name}: {1e3 * float(np.sqrt(np.mean(residue[found.validation_rows] ** 2))):.1f} mA rms")
        panel.set_xlabel("speed [rad/s]")
        data |= {f"{name}_ma": 1e3 * residue[rows], f"{name}_bin_rad_s": centre, f"{name}_bin_ma": 1e3 * mean}
    axes[0, 0].set_ylabel("not explained [mA of q current]")
    text = "What the balance leaves on the validation stretches, against speed: before and after what was found."
    return Picture("balance_speed", "Torque balance against speed", text, to_svg(figure), data)


def _binned(x: Array, y: Array) -> tuple[Array, Array]:
    edges = np.linspace(x.min(), x.max(), BINS + 1)
    cell = np.clip(np.digitize(x, edges) - 1, 0, BINS - 1)
    used = [i for i in range(BINS) if np.count_nonzero(cell == i) > 5]
    centre = 0.5 * (edges[:-1] + edges[1:])
    return centre[used], np.array([y[cell == i].mean() for i in used])


def _order_spectrum(analysis: Analysis) -> Picture:
    angle = analysis.angle
    assert angle is not None
    spectrum = angle.spectrum
    whole = spectrum.order % 1.0 == 0.0
    figure, axes = subplots(height=3.2)
    panel = axes[0, 0]
    panel.vlines(spectrum.order[whole], 0.0, 1e3 * spectrum.amplitude_a[whole], color=AFTER, label="whole orders")
    panel.vlines(
        spectrum.order[~whole], 0.0, 1e3 * spectrum.amplitude_a[~whole], color=BEFORE, label="half orders: noise"
    )
    for each in angle.lines[:6]:
        panel.annotate(
            f"{each.line.order:g}",
            (each.line.order, 1e3 * spectrum.amplitude_a[spectrum.order == each.line.order][0]),
            ha="center",
            va="bottom",
            fontsize=8,
        )
    panel.set(
        xlabel="mechanical order [1/turn]",
        ylabel="amplitude [mA of q current]",
        xlim=(0, angle.highest + 1),
        ylim=(0, None),
    )
    panel.legend()
    text = "Torque balance over the angle. Nothing on the shaft repeats at half orders, so they show the noise."
    if not analysis.inertia_known:
        text += " J/Kt is not known here, so heights are not torque."
    data = {"order": spectrum.order, "amplitude_a": spectrum.amplitude_a, "noise_a": spectrum.noise_a}
    return Picture("orders", "Spectrum in orders of the angle", text, to_svg(figure), data)


def _balance_over_angle(analysis: Analysis) -> Picture:
    angle = analysis.angle
    assert angle is not None and angle.motion.theta_rad is not None
    rows = np.flatnonzero(angle.validation_rows)
    rows = rows[:: max(1, len(rows) // DOTS)]
    turn = np.remainder(angle.motion.theta_rad[rows] / (2.0 * np.pi), 1.0)
    figure, axes = subplots(height=3.2)
    axes[0, 0].plot(turn, 1e3 * angle.before[rows], ".", markersize=2, color=BEFORE, label="before")
    axes[0, 0].plot(turn, 1e3 * angle.after[rows], ".", markersize=2, color=AFTER, label="after")
    axes[0, 0].set(xlabel="angle [turn]", ylabel="not explained [mA of q current]", xlim=(0, 1))
    axes[0, 0].legend(markerscale=4)
    data = {"turn": turn, "before_a": angle.before[rows], "after_a": angle.after[rows]}
    text = "What the balance leaves on the validation stretches, over one turn."
    return Picture("balance_angle", "Torque balance over the angle", text, to_svg(figure), data)


def _parts(analysis: Analysis) -> Picture:
    found, grid = analysis.controller, analysis.grid
    assert found is not None
    figure, axes = subplots(2, 1, height=4.2, sharex=True)
    speed, iq = grid.column("speed_rad_s"), grid.column("iq_a")
    data: dict[str, Any] = {}
    for panel, value, name in ((axes[0, 0], speed, "speed_rad_s"), (axes[1, 0], iq, "iq_a")):
        t_s, thin = envelope(grid.t_s, value)
        panel.plot(t_s, thin, color=AFTER, linewidth=0.6)
        data |= {f"{name}_t_s": t_s, name: thin}
    for part in found.parts:
        name = "uncompensated" if part.plain else f"{1e3 * part.added_a:.0f} mA added beside the controller"
        axes[0, 0].text(part.start_s, axes[0, 0].get_ylim()[1], f" {name}", va="top", fontsize=8)
        for panel in axes[:, 0]:
            panel.axvline(part.start_s, color=REFERENCE_COLOUR, linewidth=0.8)
    axes[0, 0].set_ylabel("speed [rad/s]")
    axes[1, 0].set(ylabel="q current [A]", xlabel="time [s]")
    text = (
        "Where the current is the controller's gain times the speed error, nothing compensates and the ripple is in "
        "the speed; "
        "where something adds current, it has moved to the current."
    )
    return Picture("parts", "Which part is compensated", text, to_svg(figure), data)


def _ripple_in_time(analysis: Analysis) -> Picture:
    ripple = analysis.ripple
    assert ripple is not None
    shown = ripple.t_s < ripple.t_s[0] + SHOWN_S
    figure, axes = subplots(height=3.2)
    lines = (
        ("measured", ripple.measured_rad_s, REFERENCE_COLOUR),
        ("simulated, effect added", ripple.simulated_rad_s, AFTER),
        ("simulated, without", ripple.without_rad_s, BEFORE),
    )
    data: dict[str, Any] = {"t_s": ripple.t_s}
    for name, value, colour in lines:
        axes[0, 0].plot(ripple.t_s[shown], value[shown], color=colour, label=name)
        data[name.replace(", ", "_").replace(" ", "_") + "_rad_s"] = value
    axes[0, 0].set(xlabel="time [s]", ylabel="speed [rad/s]")
    axes[0, 0].legend(ncols=3)
    text = (
        f"The drive in closed loop, simulated from its reference: {ripple.simulated_rms:.2f} rad/s rms against "
        "measured "
        f"{ripple.measured_rms:.2f}. One second; the phase is free, since small errors add up from turn to turn."
    )
    return Picture("ripple", "Speed ripple, measured and simulated", text, to_svg(figure), data)


def _ripple_in_orders(analysis: Analysis) -> Picture:
    ripple = analysis.ripple
    assert ripple is not None
    names = ["all"] + [f"{k}" for k, _, _ in ripple.orders]
    measured = np.array([ripple.measured_rms] + [m for _, m, _ in ripple.orders])
    simulated = np.array([ripple.simulated_rms] + [s for _, _, s in ripple.orders])
    figure, axes = subplots(height=2.8)
    at = np.arange(len(names))
    axes[0, 0].bar(at - 0.2, measured, 0.4, color=REFERENCE_COLOUR, label="measured")
    axes[0, 0].bar(at + 0.2, simulated, 0.4, color=AFTER, label="simulated")
    axes[0, 0].set(xlabel="mechanical order (all: rms)", ylabel="speed ripple [rad/s]")
    axes[0, 0].set_xticks(at, names)
    axes[0, 0].legend()
    data = {
        "order": np.array([0.0] + [float(k) for k, _, _ in ripple.orders]),
        "measured": measured,
        "simulated": simulated,
    }
    text = "Amplitude by order of the angle; the first pair is the rms of everything."
    return Picture("ripple_orders", "Speed ripple by orders", text, to_svg(figure), data)
