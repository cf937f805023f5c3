"""Pictures of an ARO design: how the memory converges, where the poles are, what the filters show."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from evenspin.design.aro import Design, convergence
from evenspin.report.plotfile import check_plot_file, save_figure
from evenspin.report.style import METHOD_COLOURS, OTHER_COLOURS, REFERENCE_COLOUR, drawing, subplots

SHOWN_HZ = 1000.0
MAX_TURNS = 300


def write_design(path: Path, found: Design) -> None:
    """Memory error over turns (block and theory), poles, part of a ripple that the torque measurement sees."""
    check_plot_file(path)
    with drawing():
        _draw(path, found)


def _draw(path: Path, found: Design) -> None:
    figure, axes = subplots(1, 3, height=3.4, width=12.0)
    memory, speed = found.memory, found.speed
    error, poles, seen = axes[0]
    wanted = 3.0 * memory.turns_to(math.exp(-1.0)) if memory.stable else 20.0
    turns = np.arange(np.clip(np.ceil(wanted), 5, MAX_TURNS) + 1.0)
    error.plot(turns, abs(memory.per_turn) ** turns, color=REFERENCE_COLOUR, linewidth=0.8, label="|Q - a23 L_N|^n")
    if 0.0 < memory.gain <= 1.0:  # the block takes no other
        measured = convergence(memory, len(turns) - 1)[1]
        error.plot(turns, measured, ".", markersize=3, color=METHOD_COLOURS["aro"], label="block of the firmware")
    error.set(xlabel="turns", ylabel="error of the memory [of its start]", yscale="log", title="Convergence")
    error.legend()
    angle = np.linspace(0.0, 2.0 * np.pi, 400)
    poles.plot(np.cos(angle), np.sin(angle), color=REFERENCE_COLOUR, linewidth=0.8)
    place = 2.0 * np.pi * np.arange(memory.cells) / memory.cells
    poles.plot(memory.pole * np.cos(place), memory.pole * np.sin(place), ".", markersize=2, label="memory, (16)")
    poles.plot(speed.roots.real, speed.roots.imag, "x", color=OTHER_COLOURS[1], label="speed loop, (17)")
    real = speed.real_roots
    poles.plot(real.real, real.imag, "+", color=OTHER_COLOURS[3], label="with all delays")
    poles.set(aspect="equal", xlabel="real part", ylabel="imaginary part", title="Poles")
    poles.legend(loc="lower left")
    f_hz = np.linspace(0.0, SHOWN_HZ, 400)
    seen.plot(f_hz, found.chain.gain(f_hz), color=METHOD_COLOURS["aro"], label="seen")
    seen.plot(f_hz, np.abs(1.0 - found.chain.gain(f_hz)), color=OTHER_COLOURS[3], label="stays")
    seen.set(xlabel="frequency of the ripple [Hz]", ylabel="part of the ripple", title="Torque measurement")
    seen.legend()
    save_figure(path, figure)
