"""Bode plots of a design: the closed loop, what the lead makes of it, and the stability condition."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from evenspin.design.rc import Design, frequencies, gain_bound
from evenspin.report.plotfile import check_plot_file, save_figure
from evenspin.report.style import OTHER_COLOURS, REFERENCE_COLOUR, drawing, subplots


def write_bode(path: Path, found: Design) -> None:
    """|M|, phase of z^m M, |Q (1 - k_rc z^m M)| and the bound on k_rc over frequency."""
    check_plot_file(path)
    with drawing():
        _draw(path, found)


def _draw(path: Path, found: Design) -> None:
    loop, rc = found.loop, found.rc
    f_hz = frequencies(loop.ts_s)
    closed = loop.closed(f_hz)
    q = rc.q(f_hz, loop.ts_s)
    figure, axes = subplots(2, 2, height=6.0, sharex=True)
    axes[0, 0].plot(f_hz, 20.0 * np.log10(np.abs(closed)), color=OTHER_COLOURS[0])
    axes[0, 0].set(ylabel="|M| [dB]", title="Closed speed loop", ylim=(-40.0, 6.0))
    for colour, lead in zip(OTHER_COLOURS, _leads(found), strict=False):
        ahead = closed * np.exp(2j * np.pi * f_hz * loop.ts_s * lead)
        style = {"color": colour, "label": f"m = {lead}", "linewidth": 1.8 if lead == rc.lead else 1.0}
        axes[0, 1].plot(f_hz, np.degrees(np.unwrap(np.angle(ahead))), **style)
        axes[1, 0].plot(f_hz, np.abs(q * (1.0 - rc.gain * found.lambda_max * ahead)), **style)
        axes[1, 1].plot(f_hz, gain_bound(ahead, q) / found.lambda_max, **style)
    axes[0, 1].set(ylabel="phase of z^m M [deg]", title="Phase with lead", ylim=(-180.0, 180.0))
    axes[0, 1].axhspan(-90.0, 90.0, color="#0b8f6a", alpha=0.06)
    axes[1, 0].set(ylabel="|Q (1 - k_rc z^m M)| [-]", title="Stable below 1", xlabel="frequency [Hz]")
    axes[1, 0].axhline(1.0, color=REFERENCE_COLOUR, linestyle="--", linewidth=0.9)
    axes[1, 1].set(ylabel="bound on k_rc [-]", title="Stable below the curve", xlabel="frequency [Hz]", ylim=(0.0, 5.0))
    axes[1, 1].axhline(rc.gain, color=REFERENCE_COLOUR, linestyle="--", linewidth=0.9)
    axes[0, 1].legend(ncols=3)
    axes[0, 0].set(xscale="log", xlim=(1.0, f_hz[-1]))
    save_figure(path, figure)


def _leads(found: Design) -> list[int]:
    """The one in use, the recommended one, and their neighbours."""
    wanted = [found.rc.lead, found.recommended_lead, found.rc.lead - 2, found.rc.lead + 2, 0]
    return list(dict.fromkeys(lead for lead in wanted if lead >= 0))
