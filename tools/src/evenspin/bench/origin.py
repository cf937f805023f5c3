"""Where a motor number that a drive holds came from.

The link carries values, no history. So a value that the model of a virtual drive gave it is from the model; one that
differs from the firmware's default was set or stored by somebody; one that equals the default and was given by nobody
is the default, and nobody has measured it. A person can say that a default is right for this motor (`known`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from evenspin.bench.client import Drive
from evenspin.errors import InputError, did_you_mean

# What measures a number; what nothing measures is on the name plate.
MEASURED_BY = {
    "motor_resistance_ohm": "rl",
    "motor_ld_h": "rl",
    "motor_lq_h": "rl",
    "motor_psi_wb": "encoder",
    "observer_inertia_kgm2": "mechanics",
    "observer_viscous_nms": "mechanics",
}
# Counts per turn and pole pairs: one that is not the default shows that somebody has set up the motor.
NAME_PLATE = ("pole_pairs", "encoder_counts")


class Origin(StrEnum):
    MODEL = "from the model"
    STORED = "stored in the drive"
    KNOWN = "the default, known to be right"
    DEFAULT = "default, not measured"


@dataclass(frozen=True, slots=True)
class Number:
    """A parameter that a result rests on."""

    name: str
    value: float
    unit: str
    origin: Origin

    @property
    def sure(self) -> bool:
        return self.origin is not Origin.DEFAULT

    @property
    def first(self) -> str:
        """What to do about a default."""
        procedure = MEASURED_BY.get(self.name)
        do = (
            f"`evenspin bench calibrate {procedure}` measures it"
            if procedure
            else f"set {' and '.join(NAME_PLATE)} first"
        )
        return f"{do}, or --known {self.name} when the default is right for this motor"

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.name} = {self.value:.6g}{unit}: {self.origin}"


def numbers_of(
    drive: Drive, names: Sequence[str], model_parameters: Mapping[str, float], known: Collection[str] = ()
) -> tuple[Number, ...]:
    """`model_parameters`: given by the model of a virtual drive; `known`: defaults that a person answers for."""
    found = []
    for name, value in drive.get(names).items():
        field = drive.parameters[name]
        if name in model_parameters and _same(value, model_parameters[name]):
            origin = Origin.MODEL
        elif not _same(value, field.default):
            origin = Origin.STORED
        else:
            origin = Origin.KNOWN if name in known else Origin.DEFAULT
        found.append(Number(name, value, field.unit, origin))
    return tuple(found)


def rests_on(
    drive: Drive, names: Sequence[str], model_parameters: Mapping[str, float], known: Collection[str] = ()
) -> tuple[Number, ...]:
    """`numbers_of` for a result that needs the torque or the angle of the motor: with the name plate."""
    if not names:
        return ()
    plate = numbers_of(drive, NAME_PLATE, model_parameters, known)
    return (
        *(plate if not any(number.sure for number in plate) else ()),
        *numbers_of(drive, names, model_parameters, known),
    )


def check_known(known: Collection[str]) -> None:
    """Refuse a name that no result rests on."""
    possible = (*NAME_PLATE, *MEASURED_BY)
    for name in known:
        if name not in possible:
            raise InputError("bench calibrate", "--known", name, "motor data", did_you_mean(name, possible))


def _same(a: float, b: float) -> bool:
    """In single precision, in which the drive holds them."""
    return bool(np.float32(a) == np.float32(b))
