"""What a healthy machine and bench may differ from the model file by: two named sets of least sizes.

`laboratory` is that of the measured-log format: the sizes that the hypotheses of the effects state. `bench` is what
amplifiers, couplings and data sheets on ordinary benches leave open: an electrical zero that is new at every power-up,
current gains of some per cent, a resistance by its temperature. Smaller is a deviation of this unit and no effect.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import Hypothesis, Scale
from evenspin.errors import InputError, did_you_mean

SLOW_INERTIA = 3.0
HELD = 4.0  # a deviation of the unit is held by its least size over this, as one standard deviation
HELD_ALONE = 5.5  # the same, where nothing else does it: worth the price of a name from its least size on


@dataclass(frozen=True, slots=True)
class Tolerances:
    """`times`: least size of an effect in units of what its hypothesis calls the edge of the laboratory."""

    name: str
    inductance: float  # relative, one standard deviation
    gain: float  # of both current sensors together, which no log without a torque sensor tells from the machine
    torque: float  # of the rated torque, rms: what acts on the winding and changes less has not been seen
    volts: float  # of the dc link, rms
    times: Mapping[str, float] = field(default_factory=dict)
    # Shares of the rated current and of a PWM period; an angle in rad, which a coarse encoder does not make larger.
    least: Mapping[str, float] = field(default_factory=dict)
    of_the_format: bool = False  # what the hypothesis calls its edge, in A and s of one drive, is the least of `least`

    def scaled(self, hypothesis: Hypothesis, scale: Scale, pwm_hz: float) -> float:
        """Least size of an effect, as `hypothesis.magnitude` counts it."""
        times = self.times.get(hypothesis.name, 1.0)
        units = {"current_offset": scale.rated_current_a, "dead_time": 1.0 / pwm_hz, "encoder_eccentricity": 1.0}
        if hypothesis.name in self.least:
            own = hypothesis.magnitude(_along(hypothesis, self.least[hypothesis.name] * units[hypothesis.name]))
            return max(times, own) if self.of_the_format else own
        return times

    def without_scale(self, known: Mapping[str, Hypothesis]) -> Tolerances:
        """Where nothing fixes the torque per ampere: an inertia has that tolerance beside its own."""
        edge = {name: 1.0 / known[name].magnitude(np.ones(1)) for name in ("inertia", "torque_constant")}
        own, flux = (edge[name] * self.times.get(name, 1.0) for name in edge)
        both = math.hypot(own, flux, HELD * self.gain)
        return replace(self, times=MappingProxyType({**self.times, "inertia": both / edge["inertia"]}))

    def between_rows(self) -> Tolerances:
        """Where a shaft speeds up and slows down between two rows: torque per acceleration is that of their mean."""
        wider = {**self.times, "inertia": SLOW_INERTIA * self.times.get("inertia", 1.0)}
        return replace(self, times=MappingProxyType(wider))


def _along(hypothesis: Hypothesis, size: float) -> NDArray[np.float64]:
    z = np.zeros(len(hypothesis.coordinates))
    z[0] = size
    return z


LABORATORY = Tolerances(
    "laboratory", 0.015, 0.002, 0.0005, 0.0002, {"encoder_eccentricity": 2.5}, {"current_offset": 0.004}, True
)
BENCH = Tolerances(
    "bench",
    0.08,
    0.01,
    0.002,
    0.001,
    MappingProxyType(
        {
            "winding_resistance": 4.0,  # 15 %: 38 K of copper
            "torque_constant": 2.5,  # 3 %: magnets, and the current gains behind a measured constant
            "inertia": 1.7,  # 6 %
            "viscous_friction": 2.5,
            "coulomb_friction": 3.0,  # 0.75 % of the rated torque
            "load_torque": 3.0,
            "stribeck_friction": 4.0,
            "cogging": 2.4,
            "misalignment": 3.0,
            "current_gain": 5.6,  # mismatch of 4.5 %: two amplifiers of 2 to 5 %
            "encoder_offset": 25.0,  # 0.25 rad
            "inductance_saturation": 1.7,
            "flux_harmonics": 2.0,
            "two_mass": 4.0,  # a load of 8 % of the inertia
        }
    ),
    MappingProxyType({"current_offset": 0.01, "dead_time": 0.003, "encoder_eccentricity": 1.6e-3}),
)
SETS = {each.name: each for each in (LABORATORY, BENCH)}


def tolerances_of(name: str) -> Tolerances:
    if name not in SETS:
        raise InputError("gap", "--tolerances", name, " or ".join(SETS), did_you_mean(name, SETS))
    return SETS[name]
