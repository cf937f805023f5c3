"""The memory of the angle observer: given to a run, taken from it."""

from __future__ import annotations

from pathlib import Path

from evenspin.errors import InputError
from evenspin.memory import AngleTable, check_table_file, read_table
from evenspin.memory.table import Array
from evenspin.model.methods import method_word, observer_of
from evenspin.model.setup import Setup
from evenspin.native.simulation import Simulation

ARO = "aro"


def table_for(setup: Setup, path: Path) -> Array:
    """The content of this file, if the drive can take it."""
    _need_aro(setup, "--memory")
    table = read_table(path)
    cells, limit_a = int(setup.drive["aro_cells"]), setup.drive["observer_limit_a"]
    if table.cells != cells:
        hint = f"set aro_cells = {table.cells} in [drive]"
        raise InputError(path, "cells", table.cells, f"{cells}, the drive's aro_cells", hint)
    largest_a = float(abs(table.disturbance_a).max())
    if largest_a > limit_a:
        hint = "raise observer_limit_a in [drive]"
        raise InputError(
            path, "disturbance_a", largest_a, f"within +-{limit_a:g} A, the drive's observer_limit_a", hint
        )
    return table.disturbance_a


def check_saving(setup: Setup, path: Path) -> None:
    """Refuse before the work what cannot be saved after it."""
    _need_aro(setup, "--save-memory")
    check_table_file(path, "--save-memory")


def learned_table(setup: Setup, simulation: Simulation) -> AngleTable | None:
    """What the drive knows now; None without an angle observer."""
    amps = simulation.memory()
    torque_per_a_nm = 1.5 * setup.drive["pole_pairs"] * setup.drive["motor_psi_wb"]
    return AngleTable(amps, torque_per_a_nm) if len(amps) else None


def _need_aro(setup: Setup, option: str) -> None:
    if observer_of(setup.drive) != ARO:
        raise InputError("run", "method", method_word(setup.drive), f"aro with {option}", "add --method aro")
