"""What a model file gives for the torque balance, in ampere equivalents."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.effect_facts import torque_effects
from evenspin.errors import InputError
from evenspin.model.machine import TORQUE_ALONE, Machine, find_model, load_machine

Array = NDArray[np.float64]

LINES = 6  # of the effect torque_ripple
FACTORS = ("inertia", "viscous_friction")


@dataclass(frozen=True, slots=True)
class Line:
    """Braking torque A sin(order theta + phase), in amperes."""

    order: float
    amplitude_a: float
    phase_rad: float

    def __call__(self, theta_rad: Array) -> Array:
        return self.amplitude_a * np.sin(self.order * theta_rad + self.phase_rad)


def torque_of(lines: Sequence[Line], theta_rad: Array) -> Array:
    """Of all of them together, A."""
    total = np.zeros_like(theta_rad)
    for line in lines:
        total = total + line(theta_rad)
    return total


@dataclass(frozen=True, slots=True)
class Nominal:
    """A model in ampere equivalents: every torque over the torque constant."""

    machine: Machine
    kt_nm_per_a: float
    inertia_as2: float  # J/Kt, A s^2/rad; 0: the model file does not give it
    viscous_as: float  # B/Kt, A s/rad
    coulomb_a: float
    load_a: float
    stribeck_a: float
    stribeck_rad_s: float
    lines: tuple[Line, ...]

    @property
    def pole_pairs(self) -> int | None:
        """None when the model is one in ampere equivalents, whose pole pairs are a stand-in."""
        return None if abs(self.kt_nm_per_a - 1.0) < 1e-4 else int(self.machine.plant["pole_pairs"])

    def windings(self) -> dict[str, float] | None:
        """Flux in V s, resistance, reactance in V s/A, per mechanical rad; None where the model does not say it."""
        named, plant = self.machine.plant_from, self.machine.plant
        if self.pole_pairs is None or not {"resistance_ohm", "lq_h"} <= set(named):
            return None
        resistance = self.machine.effects.get("winding_resistance", {}).get("factor", 1.0) * plant["resistance_ohm"]
        flux = self.kt_nm_per_a / 1.5
        return {"flux": flux, "resistance": resistance, "reactance": self.pole_pairs * plant["lq_h"]}

    def friction(self, speed_rad_s: Array) -> Array:
        """Dry friction and load, A."""
        low = np.exp(-((speed_rad_s / self.stribeck_rad_s) ** 2))
        return np.sign(speed_rad_s) * (self.coulomb_a + self.stribeck_a * low) + self.load_a


def read_nominal(given: str | Path) -> Nominal:
    def refuse(must: str, hint: str) -> InputError:
        return InputError("gap", "--model", str(given), must, hint)

    machine = load_machine(find_model(str(given), Path(), refuse), TORQUE_ALONE)
    kt = machine.torque_per_a_nm * machine.effects.get("torque_constant", {}).get("factor", 1.0)
    if not kt > 0.0:
        raise refuse("a model with psi_wb above 0", "a torque balance needs torque per ampere")
    effects = {name: dict(machine.effects.get(name, {})) for name in (*torque_effects(), *FACTORS)}
    plant = machine.plant
    stribeck = effects["stribeck_friction"]
    return Nominal(
        machine,
        kt,
        plant["inertia_kgm2"] * effects["inertia"].get("factor", 1.0) / kt if _tells_inertia(machine) else 0.0,
        plant["viscous_nms"] * effects["viscous_friction"].get("factor", 1.0) / kt,
        effects["coulomb_friction"].get("torque_nm", 0.0) / kt,
        effects["load_torque"].get("torque_nm", 0.0) / kt,
        stribeck.get("torque_nm", 0.0) / kt,
        stribeck.get("speed_rad_s", 1.0),
        tuple(line for line in _lines(effects, kt) if line.amplitude_a != 0.0 and line.order != 0.0),
    )


def _tells_inertia(machine: Machine) -> bool:
    """A default of another machine would be held against this one."""
    return "inertia_kgm2" in machine.plant_from


def _lines(effects: Mapping[str, Mapping[str, float]], kt: float) -> list[Line]:
    cogging, bent, ripple = (effects[name] for name in ("cogging", "misalignment", "torque_ripple"))
    first = bent.get("amplitude_nm", 0.0)
    lines = [
        Line(cogging.get("order", 0.0), cogging.get("amplitude_nm", 0.0) / kt, cogging.get("phase_rad", 0.0)),
        Line(1.0, first / kt, bent.get("phase_rad", 0.0)),
        Line(2.0, first * bent.get("second_rel", 0.0) / kt, bent.get("phase2_rad", 0.0)),
    ]
    for i in range(1, LINES + 1):
        names = (f"order_{i}", f"amplitude_{i}_nm", f"phase_{i}_rad")
        order, amplitude, phase = (ripple.get(name, 0.0) for name in names)
        lines.append(Line(order, amplitude / kt, phase))
    return lines
