"""A motor of one's own, from its name plate."""

from __future__ import annotations

from typing import Any

from evenspin.errors import EvenspinError, InputError, did_you_mean
from evenspin.native import tables

TEXTS = ("currents", "ke_as")
SIMULATED = {"auto_run": True, "align_periods": 0}  # the simulated drive knows its electrical zero


def name_plate(**printed: Any) -> dict[str, Any]:
    """A model with limits and first gains of a drive that starts by itself, as `model` of a scenario takes it.

    Args:
        printed: what the plate says, by the names of `evenspin motor new --help`: `pole_pairs=7`, `kv=270`,
            `ohm_ll=0.11`, `mh_ll=0.06`, `gcm2=500`, `lines=2048`, `supply=24`, `rated_current=12`.

    Raises:
        EvenspinError: numbers that contradict each other, or too few of them.
    """
    from evenspin.motor.files import plain
    from evenspin.motor.plate import Plate, names_of_plate
    from evenspin.motor.resolve import resolve
    from evenspin.tune.first_drive import first_drive

    for name, value in printed.items():
        if name not in names_of_plate():
            raise InputError("name_plate", name, value, "a quantity of a plate", did_you_mean(name, names_of_plate()))
        if name not in TEXTS and (isinstance(value, bool) or not isinstance(value, int | float)):
            raise InputError("name_plate", name, value, "a number", "give it without its unit")
    found = resolve(Plate(**printed))
    if found.contradictions:
        raise EvenspinError(f"name_plate: {'; '.join(found.contradictions)}")
    drive = first_drive(found)
    plant = {name: plain(tables().model[name], value) for name, value in {**found.plant, **drive.board}.items()}
    return {"name": "own", "plant": plant, "drive": drive.words() | SIMULATED}
