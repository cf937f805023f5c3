"""Gain and phase of measured responses over the frequency."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from evenspin.report.plotfile import save_figure
from evenspin.report.style import OTHER_COLOURS, REFERENCE_COLOUR, drawing, subplots


def write_bode(
    path: Path, f_hz: Sequence[float], curves: Sequence[tuple[str, Sequence[complex], Sequence[bool]]]
) -> None:
    """Each curve: name with unit, values, and whether a point is good; the others are drawn hollow."""
    with drawing():
        figure, axes = subplots(2, 1, width=8.0, height=6.0, sharex=True)
        f = np.asarray(f_hz)
        for colour, (name, values, good) in zip(OTHER_COLOURS, curves, strict=False):
            value = np.asarray(values)
            level, phase = 20.0 * np.log10(np.abs(value)), np.full(len(f), np.nan)
            there = np.isfinite(level)
            phase[there] = np.degrees(np.unwrap(np.angle(value[there])))
            for axis, y in ((axes[0, 0], level), (axes[1, 0], phase)):
                axis.plot(f, y, color=colour, label=name)
                for which, fill in ((np.asarray(good), colour), (~np.asarray(good), "none")):
                    axis.scatter(f[which], y[which], s=14, edgecolors=colour, facecolors=fill, zorder=3)
        axes[0, 0].axhline(0.0, color=REFERENCE_COLOUR, linestyle="--", linewidth=0.9)
        axes[1, 0].axhline(-180.0, color=REFERENCE_COLOUR, linestyle="--", linewidth=0.9)
        axes[0, 0].set(
            ylabel="gain [dB]", xscale="log", title="Frequency response; hollow: coherence below 0.95, or cut"
        )
        axes[1, 0].set(ylabel="phase [deg]", xlabel="frequency [Hz]")
        axes[0, 0].legend(ncols=3)
        save_figure(path, figure)
