"""How a candidate is refined: downhill, around detents, or among many local minima, behind one interface."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.candidate import Candidate, Model, Z, noise_price
from evenspin.gap.evidence import PROBES, Noise, model_features
from evenspin.gap.fitting import Fitter
from evenspin.gap.minima import MinimaSearch

Array = NDArray[np.float64]
RING = np.arange(8) * math.tau / 8  # phases that are tried where the cost has several minima over the phase...
RING_SCALES = (1.0, 2.5, 6.0, 12.0)  # ...at multiples of the amplitude of a linear fit, which detents make too small
STEPS_AFTER_SEARCH = 4  # downhill, after the search of local minima


class Strategy(Protocol):
    def refine(self, fitter: Fitter, candidate: Candidate | Model, steps: int, beat: float) -> Model:
        """The best model found from there, judged by `fitter`; may give up where a cost of `beat` is out of reach."""
        ...


@dataclass(frozen=True, slots=True)
class Downhill:
    """Gauss-Newton from where the candidate is: for effects whose features change in proportion."""

    def refine(self, fitter: Fitter, candidate: Candidate | Model, steps: int, beat: float) -> Model:
        model = fitter.model(candidate.z)
        return fitter.descended(model, steps, beat)


@dataclass(frozen=True, slots=True)
class Detents:
    """For a torque in which the rotor can rest: a ring of phases first, then downhill under the model's own noise.

    Where the rotor rests in a detent the log does not repeat, and no linear fit leads to the phase.
    """

    def refine(self, fitter: Fitter, candidate: Candidate | Model, steps: int, beat: float) -> Model:
        model = fitter.descended(_best_phase(fitter, fitter.model(candidate.z)), steps)
        noise = fitter.noise_of(model.z)
        under_own = fitter.with_noise(noise)
        model = under_own.descended(under_own.judged(model), steps)
        return _priced(fitter, model, noise)


@dataclass(frozen=True, slots=True)
class LocalMinima:
    """For effects whose logs do not repeat to the sample: what varies with the noise counts less during the search."""

    def refine(self, fitter: Fitter, candidate: Candidate | Model, steps: int, beat: float) -> Model:
        strict = fitter.judge.noise
        varying = fitter.noise_of(_least_repeatable(fitter, candidate.z)).sigma
        soft = fitter.with_noise(replace(strict, sigma=np.maximum(strict.sigma, varying)))
        found = MinimaSearch(soft, candidate.z).lowest()
        varies = any(c.least_repeatable is not None for name in found for c in fitter.library[name].coordinates)
        points = (found, _least_repeatable(fitter, found)) if varies else (found,)
        models = [_under_own_noise(fitter, z) for z in points]
        noise, model = min(models, key=lambda pair: pair[1].likelihood_cost)
        under_own = fitter.with_noise(noise)
        bottom = MinimaSearch(under_own, model.z, len(PROBES) if varies else 1).bottom()
        model = min(model, under_own.model(bottom), key=lambda m: m.cost)
        model = under_own.descended(model, min(steps, STEPS_AFTER_SEARCH))
        return _priced(fitter, model, noise)


def strategy_for(fitter: Fitter, candidate: Candidate) -> Strategy:
    """The one that the effects of a candidate need."""
    library = fitter.library
    if any(not library[name].linear for name in candidate.z):
        return LocalMinima()
    if any(library[name].rests for name in candidate.new or candidate.z):
        return Detents()
    return Downhill()


def _priced(fitter: Fitter, model: Model, noise: Noise) -> Model:
    """A model found under `noise`, judged by `fitter`; its cost under that noise stays known, with its price."""
    likely = model.cost + noise_price(noise, fitter.judge.noise)
    return replace(fitter.judged(model), own=model.cost, likely=likely)


def _under_own_noise(fitter: Fitter, z: Z) -> tuple[Noise, Model]:
    noise = fitter.noise_of(z)
    model = fitter.with_noise(noise).model(z)
    return noise, replace(model, own=model.cost, likely=model.cost + noise_price(noise, fitter.judge.noise))


def _least_repeatable(fitter: Fitter, z: Z) -> Z:
    return {name: fitter.library[name].least_repeatable(x) for name, x in z.items()}


def _best_phase(fitter: Fitter, model: Model) -> Model:
    """The best of a ring of phases and amplitudes for each effect in which the rotor can rest."""
    best = model
    for name in (name for name in model.z if fitter.library[name].rests):
        ring = [scale * _rotated(best.z[name], angle) for scale in RING_SCALES for angle in RING]
        points = [fitter.library[name].clip(z) for z in ring]
        runs = model_features(fitter.forward, [fitter.effects({**best.z, name: z}) for z in points], 1)
        y = fitter.forward.measured
        costs = [fitter.judge.fit(y - f[0], fitter.nuisance, known=best.z).cost for f in runs]
        k = int(np.argmin(costs))
        if costs[k] < best.cost:
            best = fitter.model({**best.z, name: points[k]})
    return best


def _rotated(z: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * z[0] - s * z[1], s * z[0] + c * z[1]])
