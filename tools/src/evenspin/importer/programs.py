"""Units that the recordings of well-known drives have without printing them."""

from __future__ import annotations

import re
from collections.abc import Collection

TURNS, TURNS_PER_S, DEGREES = "turn", "turn/s", "deg"

# Names as these programs call their signals, and no other does. ODrive counts turns since 0.5.1.
NAMED = (
    (re.compile(r"(?:^|\.)(?:pos_estimate|pos_rel|pos_abs|input_pos|pos_setpoint)\Z"), TURNS),  # ODrive
    (re.compile(r"(?:^|\.)(?:vel_estimate|pos_vel_mapper\.vel|input_vel|vel_setpoint)\Z"), TURNS_PER_S),  # ODrive
    (re.compile(r"encoder_position\Z"), DEGREES),  # VESC
)
# Names that others use, too: together they are one program's.
SETS = (
    (frozenset({"position", "velocity", "q_current"}), {"position": TURNS, "velocity": TURNS_PER_S}),  # moteus
    (frozenset({"position", "velocity", "q_curr"}), {"position": TURNS, "velocity": TURNS_PER_S}),  # moteus
)


def unit_by_program(name: str, names: Collection[str]) -> str:
    """The unit of a column of this name among these names; "" when no program is known by it."""
    lower = name.strip().lower()
    for pattern, unit in NAMED:
        if pattern.search(lower):
            return unit
    together = {other.strip().lower() for other in names}
    for needed, units in SETS:
        if needed <= together and lower in units:
            return units[lower]
    return ""
