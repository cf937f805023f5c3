"""What the angle observer has learned, as lines of the model that rdc and speed_model_ff feed forward, and back.

The table is the torque that drives forward over the angle; a line is the torque that the drive adds,
L sin(n theta + phi), so it is the order n of the table with the other sign.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from evenspin.errors import InputError
from evenspin.memory.table import AngleTable

MAX_LINES = 6  # CTL_HARMONICS_MAX of control/position/harmonics.h


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


def table_of(drive: Mapping[str, float], where: Path, cells: int, torque_per_a_nm: float) -> AngleTable:
    """The table that adds the torque of the lines in `drive`, parameters of a drive by name.

    A table holds one turn: lines of whole cycles, fewer than half of its cells.
    """
    theta = 2.0 * np.pi * np.arange(cells) / cells
    added_nm = np.zeros(cells)
    found = False
    for number in range(1, MAX_LINES + 1):
        name = f"rdc_line{number}"
        amplitude_nm, cycles = drive.get(f"{name}_nm", 0.0), drive.get(f"{name}_cycles", 0.0)
        if amplitude_nm == 0.0:
            continue
        if not (cycles >= 1.0 and cycles == round(cycles)):
            hint = f"use {max(1, round(cycles))} where the torque is tied to the rotor (`evenspin identify --snap`)"
            must = "a whole number of at least 1: a table holds one turn"
            raise InputError(where, f"{name}_cycles", cycles, must, hint)
        if not 2.0 * cycles < cells:
            must = f"below half of the {cells} cells"
            raise InputError(where, f"{name}_cycles", cycles, must, f"use --cells {2 * round(cycles) + 1} or more")
        added_nm += amplitude_nm * np.sin(cycles * theta + drive.get(f"{name}_rad", 0.0))
        found = True
    if not found:
        raise InputError(where, "rdc_line1_nm", 0.0, "above 0: at least one line", "`evenspin identify` measures them")
    return AngleTable(-added_nm / torque_per_a_nm, torque_per_a_nm)


def drive_text(found: dict[str, float]) -> str:
    return "\n".join(["[drive]", *(f"{name} = {value:.6g}" for name, value in found.items())])
