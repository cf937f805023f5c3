"""How far a healthy unit may be from its data sheet (docs/log-format.md): nuisance parameters with priors.

`blind` draws its units from bounds of its own on purpose: they check these.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.log.unit import Effects, Unit
from evenspin.native import tables


@dataclass(frozen=True, slots=True)
class Tolerance:
    """What a data sheet leaves open: factors on numbers of the machine model, or a parameter of a sensor's effect."""

    name: str
    sigma: float  # relative, or A for the offsets
    factors: tuple[str, ...] = ()
    sensor: tuple[str, str] | None = None  # effect and parameter; its off value stands in the table of effects
    effect: str = ""  # the effect that is the same thing, only larger


def _sensor(name: str, sigma: float, effect: str, param: str) -> Tolerance:
    return Tolerance(name, sigma, sensor=(effect, param), effect=effect)


TOLERANCES = (
    Tolerance("resistance", 0.012, ("resistance_ohm",), effect="winding_resistance"),
    Tolerance("inductance", 0.015, ("ld_h", "lq_h")),
    Tolerance("flux", 0.004, ("psi_wb",), effect="torque_constant"),
    Tolerance("inertia", 0.012, ("inertia_kgm2",), effect="inertia"),
    Tolerance("viscous", 0.04, ("viscous_nms",), effect="viscous_friction"),
    _sensor("offset_a", 0.010, "current_offset", "offset_a_a"),
    _sensor("offset_b", 0.010, "current_offset", "offset_b_a"),
    _sensor("gain_a", 0.002, "current_gain", "gain_a"),
    _sensor("gain_b", 0.002, "current_gain", "gain_b"),
)
TOLERANCE_EFFECTS = tuple(dict.fromkeys(t.effect for t in TOLERANCES if t.effect))
SIGMA = np.array([t.sigma for t in TOLERANCES])
NAMED_PRIOR = 1e4  # times the inverse variance: the deviation of a named effect is all the effect's


def prior_of(effects: Iterable[str]) -> NDArray[np.float64]:
    """Inverse variance of each tolerance; one that an effect stands for does not move any more."""
    named = set(effects)
    return np.array([(NAMED_PRIOR if t.effect in named else 1.0) / t.sigma**2 for t in TOLERANCES])


def unit_of(
    effects: Effects,
    delta: Sequence[float] | NDArray[np.float64] | None = None,
    noise_seed: int | None = None,
    part: float = 0.5,
) -> Unit:
    """A unit with these effects that is off its data sheet by `delta` (as TOLERANCES)."""
    all_effects = {name: dict(params) for name, params in effects.items()}
    factors: dict[str, float] = {}
    for tolerance, d in zip(TOLERANCES, delta if delta is not None else (), strict=False):
        factors.update({key: 1.0 + float(d) for key in tolerance.factors})
        if tolerance.sensor is not None and d != 0.0:
            effect, param = tolerance.sensor
            params = all_effects.setdefault(effect, {})
            params[param] = params.get(param, tables().effects[effect].params[param].default) + float(d)
    return Unit(all_effects, factors, noise_seed, part)
