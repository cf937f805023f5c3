"""The pictures of a run in position mode: where it went, and how far it was from its command."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.segments import RAD_S
from evenspin.model.setup import Setup
from evenspin.report.chart import Chart, Line, Panel
from evenspin.report.curves import envelope
from evenspin.report.figures import TIME, Picture, picture_of
from evenspin.report.style import OTHER_COLOURS, REFERENCE_COLOUR
from evenspin.sim.record import Record

Array = NDArray[np.float64]

TURN_RAD = 2.0 * np.pi
SHOWN_TURNS = 3  # the first, one in the middle, the last


def position_pictures(setup: Setup, name: str, record: Record) -> list[Picture]:
    """Position, error and speed over time, and the error over the turn."""
    span = (0.0, setup.duration_s)
    t_s = record["t_s"]
    at, position = envelope(t_s, record["position_rad"] / TURN_RAD)
    command_at, command = envelope(t_s, record["position_ref_rad"] / TURN_RAD)
    error_at, error = envelope(t_s, 1e3 * record["position_error_rad"])
    speed_at, speed = envelope(t_s, record["true_speed_rad_s"] / RAD_S)
    wanted_at, wanted = envelope(t_s, record["velocity_ref_rad_s"] / RAD_S)
    iq_at, iq_a = envelope(t_s, record["true_iq_a"])

    def panel(lines: list[Line], label: str) -> Chart:
        return Chart([Panel(lines, "time [s]", label, x_range=span, group=TIME)])

    def drawn(x: Array, y: Array) -> Line:
        return Line(name, x, y, OTHER_COLOURS[0])

    def reference(x: Array, y: Array) -> Line:
        return Line("command", x, y, REFERENCE_COLOUR, 0.9, dashed=True)

    found = [
        picture_of(
            "position",
            "Position",
            "Encoder position; the command of the profile is dashed.",
            panel([drawn(at, position), reference(command_at, command)], "position [turn]"),
            {"t_s": at, "position_turn": position, "command_t_s": command_at, "command_turn": command},
        ),
        picture_of(
            "position_error",
            "Position error",
            "Command less encoder.",
            panel([drawn(error_at, error)], "error [mrad]"),
            {"t_s": error_at, "error_mrad": error},
        ),
    ]
    over_turn = _over_turn(record)
    found += [over_turn] if over_turn is not None else []
    found += [
        picture_of(
            "speed",
            "Speed",
            "True speed of the rotor; the command of the profile is dashed.",
            panel([drawn(speed_at, speed), reference(wanted_at, wanted)], "speed [rpm]"),
            {"t_s": speed_at, "rpm": speed, "command_t_s": wanted_at, "command_rpm": wanted},
        ),
        picture_of(
            "current",
            "q-axis current",
            "True current of the motor, not what its sensors say.",
            panel([drawn(iq_at, iq_a)], "q-axis current [A]"),
            {"t_s": iq_at, "iq_a": iq_a},
        ),
    ]
    return found


def _over_turn(record: Record) -> Picture | None:
    """The error of whole turns of the longest motion, over the angle of the command."""
    moving = np.abs(record["velocity_ref_rad_s"]) > 0.0
    edges = np.flatnonzero(np.diff(np.concatenate(([False], moving, [False])).astype(np.int8))).reshape(-1, 2)
    command = record["position_ref_rad"]
    if not len(edges):
        return None
    start, end = max(edges.tolist(), key=lambda each: abs(command[each[1] - 1] - command[each[0]]))
    travelled = np.abs(command[start:end] - command[start]) / TURN_RAD
    turns = int(travelled[-1] + 1e-6)
    if turns < 1:
        return None
    lines: list[Line] = []
    data: dict[str, Array] = {}
    for index, number in enumerate(sorted({0, turns // 2, turns - 1})[:SHOWN_TURNS]):
        rows = start + np.flatnonzero((travelled >= number) & (travelled < number + 1))
        degrees = 360.0 * (travelled[rows - start] - number)
        x, y = envelope(degrees, 1e3 * record["position_error_rad"][rows])
        lines.append(Line(f"turn {number + 1}", x, y, OTHER_COLOURS[index]))
        data |= {f"turn{number + 1}_deg": x, f"turn{number + 1}_mrad": y}
    panel = Panel(lines, "angle of the command in its turn [deg]", "error [mrad]", x_range=(0.0, 360.0))
    text = "Command less encoder, in turns of the longest motion: what does not repeat at the end was learned away."
    return picture_of("error_over_turn", "Error over the turn", text, Chart([panel]), data)
