"""The learned table over the angle and in orders."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from evenspin.memory.table import AngleTable
from evenspin.report.figures import Picture
from evenspin.report.plotfile import save_figure
from evenspin.report.style import METHOD_COLOURS, drawing, subplots, to_svg

MAX_ORDER = 60


def memory_picture(table: AngleTable) -> Picture:
    """For a report."""
    with drawing():
        figure, data = _draw(table)
        svg = to_svg(figure)
    text = "Disturbance torque that the observer has learned, as q current; positive drives forward."
    return Picture("memory", "Learned memory", text, svg, data)


def write_plot(path: Path, table: AngleTable) -> None:
    """For a file: .svg, .png or .pdf."""
    with drawing():
        figure, _ = _draw(table)
        save_figure(path, figure)


def _draw(table: AngleTable) -> tuple[Any, dict[str, Any]]:
    figure, axes = subplots(1, 2, height=3.0, width_ratios=(2, 1))
    angle_deg, lines = np.degrees(table.theta_m_rad), table.orders()
    order = np.arange(len(lines))
    axes[0, 0].plot(angle_deg, table.disturbance_a, color=METHOD_COLOURS["aro"])
    axes[0, 0].set(xlabel="mechanical angle [deg]", ylabel="disturbance torque [A]", xlim=(0.0, 360.0))
    axes[0, 1].bar(order[1 : MAX_ORDER + 1], lines[1 : MAX_ORDER + 1], color=METHOD_COLOURS["aro"])
    axes[0, 1].set(xlabel="mechanical order [-]", ylabel="amplitude [A]")
    if table.torque_per_a_nm is not None:
        ratio = 1e3 * table.torque_per_a_nm
        scale = (lambda a: a * ratio, lambda t: t / ratio)
        axes[0, 0].secondary_yaxis("right", functions=scale).set_ylabel("[mN m]")
    data = {"angle_deg": angle_deg, "disturbance_a": table.disturbance_a, "order": order, "amplitude_a": lines}
    return figure, data
