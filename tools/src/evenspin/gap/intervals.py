"""How sure each parameter is: from coordinates of the search to parameters, with a spread that simulation confirms."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import Hypothesis
from evenspin.gap.candidate import Model
from evenspin.gap.fitting import Fitter
from evenspin.gap.thresholds_evidence import (
    DAMPING_SHARE,
    INFLATION_MIN,
    PARAMETER_SHARE,
    PHASE_KNOWN_RAD,
    SATURATION_SHARE,
)
from evenspin.log.tolerance import SIGMA, TOLERANCES, unit_of
from evenspin.native import tables
from evenspin.native.tables import EffectParam

Array = NDArray[np.float64]
UNITS = 10  # healthy units with the same effects, simulated
Z95 = 1.96
UNIFORM95 = 0.95  # of the bound hold 95 % of what is even within it
SCATTER_MAX = 1e4  # of one unit over the covariance, squared: a fit that has run away does not count more
FORM_SHARES = {"i_sat_a": SATURATION_SHARE, "damping_ratio": DAMPING_SHARE}  # of parameters that hang on the law
EXACT = ("order", "sign")  # roles of parameters without an interval


@dataclass(frozen=True, slots=True)
class Interval:
    effect: str
    parameter: str
    value: float
    half: float  # of the 95 % interval

    @property
    def field(self) -> EffectParam:
        return tables().effects[self.effect].params[self.parameter]

    def as_json(self) -> dict[str, float]:
        return {"value": self.value, "low": self.value - self.half, "high": self.value + self.half}


@dataclass(frozen=True, slots=True)
class Intervals:
    parameters: tuple[Interval, ...]
    inflation: float  # of the standard deviations of the fit, from simulated units

    def widened(self, factor: float) -> Intervals:
        return replace(self, parameters=tuple(replace(i, half=factor * i.half) for i in self.parameters))

    def of(self, effect: str) -> tuple[Interval, ...]:
        return tuple(interval for interval in self.parameters if interval.effect == effect)

    def warnings(self) -> list[str]:
        """Parameters that this log does not determine."""
        messages = []
        for effect in dict.fromkeys(interval.effect for interval in self.parameters):
            mine = self.of(effect)
            for interval in mine:
                if interval.half > _size(interval, mine) and not interval.field.optional:
                    messages.append(
                        f"{effect}.{interval.parameter} = {interval.value:.3g} +- {interval.half:.2g} (95 %): "
                        "not identifiable from this log"
                    )
        return messages


def intervals(fitter: Fitter, model: Model) -> Intervals:
    """95 % intervals of the vocabulary's parameters of every effect in the model.

    Features repeat one another, so that the covariance of the fit is too small. Healthy units with the same effects are
    simulated and fitted linearly; their scatter over the covariance is the factor that all intervals are widened by.
    Where an effect is a tolerance, only larger, no log says which part is the unit's: the tolerance is in the interval.
    What the model of an effect may be off itself comes on top (PARAMETER_SHARE, FORM_SHARES).
    """
    if not model.z:
        return Intervals((), 1.0)
    columns = fitter.columns(model)
    left = fitter.forward.measured - model.features
    covariance = fitter.judge.fit(left, fitter.nuisance, columns, known=model.z).covariance
    inflation = _inflation(fitter, model, columns, covariance)
    found: list[Interval] = []
    at = 0
    for name, z in model.z.items():
        size = len(z)
        part = covariance[at : at + size, at : at + size] * inflation**2 + np.diag(tolerance_variance(name, size))
        at += size
        found += with_model_share(of_effect(fitter.library[name], z, part))
    return Intervals(tuple(found), inflation)


def _inflation(fitter: Fitter, model: Model, columns: Array, covariance: Array) -> float:
    random = np.random.default_rng(31)
    free = np.array([t.effect not in model.z for t in TOLERANCES])
    deltas = random.normal(0.0, SIGMA, (UNITS, len(SIGMA))) * free
    effects = fitter.effects(model.z)
    units = [unit_of(effects, delta, 8000 + i, float(random.random())) for i, delta in enumerate(deltas)]
    scatter = []
    for run in fitter.forward.many(units):
        amount = fitter.judge.fit(run - model.features, fitter.nuisance, columns, known=model.z).amount
        known = np.diag(covariance) > 0.0  # a form that is off has no variance
        scatter.append(amount[known] ** 2 / np.diag(covariance)[known])
    return max(INFLATION_MIN, math.sqrt(float(np.mean(np.minimum(scatter, SCATTER_MAX)))))


def tolerance_variance(effect: str, size: int) -> Array:
    """Of each coordinate, by what a unit may have of it within its tolerance: evenly up to the bound."""
    bounds = [t.sigma for t in TOLERANCES if t.effect == effect]
    return (UNIFORM95 / Z95 * np.array(bounds)) ** 2 if bounds else np.zeros(size)


def of_effect(h: Hypothesis, z: Array, covariance: Array) -> list[Interval]:
    reported = [p for p in tables().effects[h.name].params.values() if p.reported]
    values = reported_parameters(h.name, h.to_params(z))
    jacobian = np.array([_slope(h.to_params, z, i, h.coordinates[i].probe, reported) for i in range(len(z))])
    variance = np.einsum("ip,ij,jp->p", jacobian, covariance, jacobian)
    halves = dict(zip((p.name for p in reported), Z95 * np.sqrt(np.maximum(variance, 0.0)), strict=True))
    return [Interval(h.name, key, value, float(halves[key])) for key, value in values.items()]


def with_model_share(found: list[Interval]) -> list[Interval]:
    """Wider by what the simulation of an effect may be off itself, which no repeat of it shows."""

    def share(i: Interval) -> float:
        return FORM_SHARES.get(i.parameter, PARAMETER_SHARE)

    return [
        i if i.field.role in EXACT else replace(i, half=math.hypot(i.half, share(i) * _size(i, tuple(found))))
        for i in found
    ]


def _slope(
    to_params: Callable[[Array], Mapping[str, float]], z: Array, i: int, probe: float, reported: list[EffectParam]
) -> list[float]:
    h = 1e-4 * probe
    ahead, behind = z.copy(), z.copy()
    ahead[i] += h
    behind[i] -= h
    high, low = to_params(ahead), to_params(behind)
    return [_difference(p, high[p.name], low[p.name]) / (2.0 * h) for p in reported]


def _difference(param: EffectParam, a: float, b: float) -> float:
    if param.role == "phase":
        return math.remainder(a - b, math.tau)
    return 0.0 if param.role == "sign" else a - b


def _size(interval: Interval, all_of_effect: tuple[Interval, ...]) -> float:
    """What an interval has to be narrower than to mean anything."""
    field = interval.field
    if field.role == "phase":
        return PHASE_KNOWN_RAD
    together = [i for i in all_of_effect if i.field.vector] if field.vector else [interval]
    off = field.default if field.role == "factor" else 0.0
    return max(abs(other.value - off) for other in together)


def reported_parameters(effect: str, params: Mapping[str, Any]) -> dict[str, float]:
    """Without the details of the model, which are fitted along."""
    fields = tables().effects[effect].params.values()
    return {p.name: float(params[p.name]) for p in fields if p.reported and p.name in params}
