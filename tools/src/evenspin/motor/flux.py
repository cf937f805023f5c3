"""The flux linkage of the magnets from what a data sheet gives.

A sinusoidal machine with peak flux linkage psi of a phase and p pole pairs, in SI units:

    back-EMF of a phase, peak              p psi w                                                        (1)
    between two terminals                  sqrt(3) times (1); rms: 1 / sqrt(2) of the peak                  (2)
    torque                                 1.5 p psi i,  i the peak of the phase current                    (3)

so Kv = 60 / (2 pi sqrt(3) p psi) r/min per V of (2, peak) and Kt Kv = 8.27 N m/A r/min/V with peak amperes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from evenspin.motor.plate import RPM, Plate

AGREE = 0.12  # two constants of the same data sheet: tolerance of the magnets and rounding
# What a factor between two constants of one motor most often means.
FACTORS: Mapping[float, str] = {
    math.sqrt(2.0): "rms against peak: see --currents and --ke-as",
    math.sqrt(3.0): "phase against line-to-line: see --ke-as",
    math.sqrt(1.5): "rms line-to-line against peak of a phase: see --ke-as",
    math.sqrt(6.0): "rms line-to-line against peak of a phase, the other way round: see --ke-as",
    2.0 / math.sqrt(3.0): "a Kt that is 60 / (2 pi Kv), without the factor of three phases",
    2.0: "poles against pole pairs",
    1.5: "a torque constant of one phase instead of three",
}


@dataclass(frozen=True, slots=True)
class Flux:
    """One way to the flux linkage. `tolerance`: what such a number is good for, either way."""

    name: str
    psi_wb: float
    origin: str
    tolerance: float


def flux_of(plate: Plate, pole_pairs: float) -> list[Flux]:
    """Every way that this plate offers, the best first."""
    found = []
    if plate.psi_wb is not None:
        found.append(Flux("psi_wb", plate.psi_wb, "as given", 0.05))
    if plate.ke is not None:
        phase_peak = plate.ke / {
            "ll-rms": math.sqrt(1.5), "ll-peak": math.sqrt(3.0), "phase-rms": 1.0 / math.sqrt(2.0), "phase-peak": 1.0,
        }[plate.ke_as]  # fmt: skip
        psi = phase_peak / (1000.0 * RPM * pole_pairs)
        found.append(Flux("ke", psi, f"from {plate.said('ke')} ({plate.ke_as})", 0.10))
    if plate.kt is not None:
        psi = plate.kt / plate.per_peak / (1.5 * pole_pairs)
        found.append(Flux("kt", psi, f"from {plate.said('kt')} (per {plate.currents} A)", 0.10))
    if plate.kv is not None:
        psi = 1.0 / (plate.kv * RPM * math.sqrt(3.0) * pole_pairs)
        found.append(Flux("kv", psi, f"from {plate.said('kv')}", 0.10))
    if not found and plate.rated_torque is not None and plate.rated_current is not None:
        psi = plate.rated_torque / (1.5 * pole_pairs * plate.rated_current * plate.per_peak)
        found.append(Flux("rated_torque", psi, "from rated torque over rated current", 0.25))
    return found


def meaning(ratio: float) -> str:
    """What a factor between two constants may come from; empty when it resembles none."""
    ratio = max(ratio, 1.0 / ratio)
    near = min(FACTORS, key=lambda factor: abs(math.log(ratio / factor)))
    return FACTORS[near] if abs(math.log(ratio / near)) < 0.04 else ""
