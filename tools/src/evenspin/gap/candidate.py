"""What a search hands around: explanations of a log, and starting points for them. Values without behaviour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.evidence import Noise

Array = NDArray[np.float64]
Z = dict[str, Array]  # coordinates of each effect, by name (see hypotheses.Coordinate)


@dataclass(frozen=True, slots=True)
class Model:
    """A set of effects with their coordinates, refined on the fit records."""

    z: Z
    delta: Array  # deviations of the unit, within its tolerances
    features: Array  # expected
    probe: Array  # expected of the first probe alone: columns are differences from it
    cost: float
    residual: Array  # whitened
    own: float | None = None  # the cost under the noise that the model itself predicts, where that is another
    likely: float | None = None  # `own` plus the price of that noise: comparable with the cost of other models

    @property
    def own_cost(self) -> float:
        return self.cost if self.own is None else self.own

    @property
    def likelihood_cost(self) -> float:
        return self.cost if self.likely is None else self.likely

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.z)


@dataclass(frozen=True, slots=True)
class Candidate:
    """A starting point worth refining: effects with their coordinates, and the gain that a linear fit expects."""

    z: Z
    gain: float
    new: frozenset[str] = frozenset()  # effects beside those of a model that was refined already


def noise_price(noise: Noise, reference: Noise) -> float:
    """What a model pays for predicting more noise than `reference`: the norm of its normal density."""
    both = noise.used & reference.used
    return float(2.0 * np.sum(np.log(noise.sigma[both] / reference.sigma[both])))
