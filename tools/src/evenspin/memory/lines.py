"""What the angle observer has learned, as lines of the model that rdc and speed_model_ff feed forward.

The table is the torque that drives forward over the angle; a line is the torque that the drive adds,
L sin(n theta + phi), so it is the order n of the table with the other sign.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from evenspin.errors import InputError
from evenspin.memory.table import AngleTable


def lines_of(table: AngleTable, where: Path, count: int) -> dict[str, float]:
    """Parameters of the drive, the strongest order first."""
    if table.torque_per_a_nm is None:
        raise InputError(where, "torque_per_a_nm", "(missing)", "the torque per ampere", "save it with `evenspin run`")
    if table.empty:
        raise InputError(where, "disturbance_a", 0.0, "something learned", "let it learn first")
    orders = np.fft.rfft(table.disturbance_a)[1 : (table.cells + 1) // 2] * 2.0 / table.cells * table.torque_per_a_nm
    found: dict[str, float] = {}
    for number, index in enumerate(np.argsort(-np.abs(orders))[:count], start=1):
        # table: |c| cos(n theta + arg c); a cosine with the other sign is a sine a quarter turn before
        found[f"rdc_line{number}_cycles"] = float(index + 1)
        found[f"rdc_line{number}_nm"] = float(abs(orders[index]))
        found[f"rdc_line{number}_rad"] = float(np.angle(-1j * orders[index]))
    return found


def drive_text(found: dict[str, float]) -> str:
    return "\n".join(["[drive]", *(f"{name} = {value:.6g}" for name, value in found.items())])
