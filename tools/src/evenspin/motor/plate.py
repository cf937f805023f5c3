"""What a name plate or a data sheet says, in the units that are printed there; None: it does not say.

Each quantity has one field for each unit or convention in which it is commonly printed, so that nothing is converted by
hand. `resolve` brings them together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any

from evenspin.errors import InputError, did_you_mean

RPM = math.pi / 30.0  # rad/s
CURRENTS = ("rms", "peak")
KE = ("ll-rms", "ll-peak", "phase-rms", "phase-peak")


def _number(text: str, unit: str, low: float = 0.0, high: float = 1e6, *, zero: bool = False) -> Any:
    """`low` itself is allowed when `zero`."""
    return field(default=None, metadata={"text": text, "unit": unit, "low": low, "high": high, "zero": zero})


@dataclass(frozen=True, slots=True)
class Plate:
    """The numbers of a name plate. The metadata of a field has text, unit and range."""

    pole_pairs: float | None = _number("pole pairs", "", 1.0, 50.0, zero=True)
    poles: float | None = _number("poles", "", 2.0, 100.0, zero=True)
    kv: float | None = _number("speed constant Kv, from the peak line-to-line voltage", "r/min per V")
    kt: float | None = _number("torque constant Kt, per ampere as `currents` says", "N m/A")
    ke: float | None = _number("voltage constant Ke, as `ke_as` says", "V per 1000 r/min", high=1e5)
    psi_wb: float | None = _number("flux linkage of the magnets, peak of a phase", "Wb", high=10.0)
    ohm_ll: float | None = _number("resistance between two terminals", "ohm", high=2000.0)
    ohm_phase: float | None = _number("resistance of a phase", "ohm", high=1000.0)
    mh_ll: float | None = _number("inductance between two terminals", "mH", high=2000.0)
    mh_phase: float | None = _number("inductance of a phase", "mH", high=1000.0)
    mh_d: float | None = _number("inductance of the d axis", "mH", high=1000.0)
    mh_q: float | None = _number("inductance of the q axis", "mH", high=1000.0)
    gcm2: float | None = _number("rotor inertia", "g cm^2", high=1e10)
    kgcm2: float | None = _number("rotor inertia", "kg cm^2", high=1e7)
    kgm2: float | None = _number("rotor inertia", "kg m^2", high=1e3)
    load_kgm2: float | None = _number("inertia of the load, at the motor shaft", "kg m^2", high=1e3, zero=True)
    viscous_nms: float | None = _number("viscous friction", "N m s/rad", high=1e3, zero=True)
    lines: float | None = _number("encoder lines (periods of a track) per turn", "", 4.0, 4194304.0, zero=True)
    counts: float | None = _number(
        "encoder counts per turn, after four-fold evaluation", "", 16.0, 16777216.0, zero=True
    )
    bits: float | None = _number("encoder bits per turn", "", 4.0, 24.0, zero=True)
    supply: float | None = _number("dc-link voltage", "V", high=2000.0)
    rated_current: float | None = _number("rated current, as `currents` says", "A", high=10000.0)
    peak_current: float | None = _number("peak current, as `currents` says", "A", high=10000.0)
    rated_torque: float | None = _number("rated torque", "N m", high=100000.0)
    rated_speed: float | None = _number("rated speed", "r/min", high=190000.0)
    rated_power: float | None = _number("rated power at the shaft", "W", high=1e7)
    max_speed: float | None = _number("largest speed", "r/min", high=190000.0)
    board_current: float | None = _number("largest phase current that the board bears, peak", "A", high=1000.0)
    board_voltage: float | None = _number("largest dc-link voltage that the board bears", "V", high=1000.0)
    currents: str = "rms"
    ke_as: str = "ll-rms"

    def __post_init__(self) -> None:
        for item in fields(self):
            if item.metadata:
                _check(item.name, getattr(self, item.name), item.metadata)
        for name, known in (("currents", CURRENTS), ("ke_as", KE)):
            if getattr(self, name) not in known:
                value = getattr(self, name)
                raise InputError("motor new", flag(name), value, " or ".join(known), did_you_mean(value, known))

    @property
    def per_peak(self) -> float:
        """Peak of a current of this plate, over the number that is printed."""
        return math.sqrt(2.0) if self.currents == "rms" else 1.0

    def given(self, *names: str) -> list[str]:
        """Those of these fields that the plate states."""
        return [name for name in names if getattr(self, name) is not None]

    def said(self, name: str) -> str:
        """A number as it was given: flag, value, unit."""
        unit = unit_of(name)
        return f"{flag(name)} {getattr(self, name):g}{f' {unit}' if unit else ''}"


WHOLE = ("pole_pairs", "poles", "lines", "counts", "bits")


def _check(name: str, value: float | None, limits: Any) -> None:
    if value is None:
        return
    low, high = limits["low"], limits["high"]
    inside = math.isfinite(value) and value <= high and (value >= low if limits["zero"] else value > low)
    if not inside or (name in WHOLE and value != int(value)):
        whole = "a whole number" if name in WHOLE else "a number"
        edge = "from" if limits["zero"] else "above"
        must = f"{whole} {edge} {low:g} to {high:g} {limits['unit']}".rstrip()
        raise InputError("motor new", flag(name), value, must, "correct the value or its unit")


def flag(name: str) -> str:
    """The option of a field."""
    return "--" + name.replace("_", "-")


def text_of(name: str) -> str:
    return str(_meta(name)["text"])


def unit_of(name: str) -> str:
    return str(_meta(name)["unit"])


def _meta(name: str) -> Any:
    return next(item.metadata for item in fields(Plate) if item.name == name)


def names_of_plate() -> list[str]:
    return [item.name for item in fields(Plate)]
