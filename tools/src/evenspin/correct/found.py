"""The machine that `evenspin gap` has found: what it is made of, and other machines that the intervals allow."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.result import CaseResult
from evenspin.log.nominal import Nominal
from evenspin.log.tolerance import unit_of
from evenspin.log.unit import Unit

Numbers = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Found:
    """`effects`: what is named, with all parameters; `halves`: of the 95 % interval of each that has one."""

    effects: Mapping[str, Numbers]
    halves: Mapping[str, Numbers]
    delta: NDArray[np.float64]  # deviations of the unit
    nominal: Nominal

    @classmethod
    def of(cls, result: CaseResult) -> Found:
        halves = {name: {i.parameter: i.half for i in result.intervals.of(name)} for name in result.effects}
        return cls(result.effects, halves, np.asarray(result.delta, dtype=float), result.nominal)

    def half(self, effect: str, parameter: str) -> float:
        return float(self.halves.get(effect, {}).get(parameter, 0.0))

    def unit(self, noise_seed: int | None = None, part: float = 0.5) -> Unit:
        return unit_of(self.effects, self.delta, noise_seed, part)

    def machine(self, key: str) -> float:
        """A number of the machine model, with the deviation of the unit and the factors of named effects."""
        value = self.nominal.machine[key] * self.unit().factors.get(key, 1.0)
        effect = FACTOR_OF.get(key)
        return value * self.effects.get(effect, {}).get("factor", 1.0) if effect else value

    def less(self, effects: Collection[str]) -> Found:
        """The machine without these effects."""
        return replace(self, effects={name: p for name, p in self.effects.items() if name not in effects})

    def other(self, random: np.random.Generator) -> Found:
        """A machine at the end of each interval, one end or the other by chance."""
        effects = {
            name: {
                key: value + float(random.choice((-1.0, 1.0))) * self.half(name, key) for key, value in params.items()
            }
            for name, params in self.effects.items()
        }
        return replace(self, effects=effects)


FACTOR_OF = {  # effects that are a factor on a number of the machine model
    "resistance_ohm": "winding_resistance",
    "psi_wb": "torque_constant",
    "inertia_kgm2": "inertia",
    "viscous_nms": "viscous_friction",
}
