"""Where the cost has many valleys: effects whose logs are not linear in their coordinates, nor repeat to the sample.

From each of the best starts some places around it are simulated. A plane through the features of all of them, over
steps that are large against what does not repeat, then proposes the next place: Gauss-Newton with a secant of many.
Coordinates in which an explanation is linear follow at each place by a linear fit, so that they cost nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from evenspin.gap.evidence import model_features

if TYPE_CHECKING:
    from evenspin.gap.hypotheses import Hypothesis
    from evenspin.gap.search import Search, Z

Array = NDArray[np.float64]
SEEDS = 3  # of the starts are looked around
AROUND = 2  # places per coordinate
SEED_WIDTH = 0.8  # in shares of the grid's pitch
WIDTHS = (0.5, 0.35, 0.2)  # around the best, one after the other
DAMPINGS = (0.03, 0.3, 3.0)  # of the proposals, relative to what the log says
NEAR = 0.5  # of the pitch: how sure the place of a wild effect is
REACH = 1.5  # widths that a proposal may go


@dataclass(frozen=True, slots=True)
class Place:
    """One place of the wild effects, with the linear ones where they fit best."""

    x: Array  # wild coordinates, in shares of the grid's pitch
    features: Array
    amount: Array  # of the linear coordinates, from where they are
    cost: float


class Valleys:
    """The search around the starts of the effects in `z` that are not linear."""

    def __init__(self, search: Search, z: Z, probes: int = 1) -> None:
        self.search = search
        self.probes = probes
        self.base = z
        library = search.library
        self.wild = [name for name in z if not library[name].linear]
        self.steady = [name for name in z if library[name].linear]
        self.pitch = np.concatenate([[c.spread for c in library[name].coordinates] for name in self.wild])
        self.turn = 0
        self.columns = self._linear_columns()

    def lowest(self) -> Z:
        """The lowest place found from all starts; at worst where `z` has it."""
        seeds = sorted(self._simulated(self._starts()), key=lambda place: place.cost)[:SEEDS]
        best = min((self._looked_around(seed, SEED_WIDTH) for seed in seeds), key=lambda place: place.cost)
        return self._z(best.x, best.amount)

    def bottom(self) -> Z:
        """The lowest place found near `z`."""
        (best,) = self._simulated([self._x(self.base)])
        for width in WIDTHS:
            best = self._looked_around(best, width)
        return self._z(best.x, best.amount)

    def _starts(self) -> list[Array]:
        """The starts of each effect, the others where the lead has them."""
        home = self._x(self.base)
        starts = [home]
        for name in self.wild:
            h = self.search.library[name]
            if h.amplitude is None:
                starts += [self._x({**self.base, name: np.array(start)}) for start in h.starts]
        return starts

    def _looked_around(self, best: Place, width: float) -> Place:
        self.turn += 1
        count = AROUND * len(best.x)
        points = qmc.Halton(len(best.x), seed=self.turn).random(count) * 2.0 - 1.0
        places = self._simulated([best.x + width * point for point in points])
        lowest = min([best, *places], key=lambda place: place.cost)
        proposals = self._simulated(self._proposals(lowest, [best, *places], width))
        return min([lowest, *proposals], key=lambda place: place.cost)

    def _proposals(self, at: Place, places: Sequence[Place], width: float) -> list[Array]:
        others = [place for place in places if place is not at]
        steps = np.stack([place.x - at.x for place in others])
        change = np.stack([place.features - at.features for place in others])
        plane = np.linalg.lstsq(steps, change, rcond=1e-6)[0].T
        judge, nuisance = self.search.judge, self.search.nuisance
        extra = np.hstack((plane, self.columns))
        out = []
        for damping in DAMPINGS:
            fit = judge.fit(self.search.forward.measured - at.features, nuisance, extra, damping, self.base)
            step = fit.amount[: len(at.x)]
            length = float(np.max(np.abs(step)))
            out.append(at.x + step * min(1.0, REACH * width / max(length, 1e-12)))
        return out

    def _simulated(self, xs: Sequence[Array]) -> list[Place]:
        nothing = np.zeros(self.columns.shape[1])
        zs = [self._z(x, nothing) for x in xs]
        runs = model_features(self.search.forward, [self.search.effects(z) for z in zs], self.probes)
        return [self._judged(self._x(z), run.mean(axis=0)) for z, run in zip(zs, runs, strict=True)]

    def _judged(self, x: Array, features: Array) -> Place:
        residual = self.search.forward.measured - features
        fit = self.search.judge.fit(residual, self.search.nuisance, self.columns, 1e-6, self.base)
        return Place(x, features, fit.amount, fit.cost)

    def _linear_columns(self) -> Array:
        """Change of the features per unit of each linear coordinate, the wild effects at the lead's place."""
        if not self.steady:
            return np.zeros((len(self.search.forward.measured), 0))
        names = set(self.steady)
        return self.search.columns(self.search._model(self.base), names)

    def _x(self, z: Z) -> Array:
        return np.concatenate([z[name] for name in self.wild]) / self.pitch

    def _z(self, x: Array, amount: Array) -> Z:
        """Within the limits of every coordinate, names in the order they had."""
        out = dict(self.base)
        for names, values in ((self.wild, x * self.pitch), (self.steady, amount)):
            at = 0
            for name in names:
                part = values[at : at + len(self.base[name])]
                at += len(part)
                h = self.search.library[name]
                out[name] = h.clip(part if names is self.wild else self.base[name] + part)
        return out


def neighbours(library: Mapping[str, Hypothesis], z: Z, count: int) -> list[Z]:
    """The model with its wild effects as far off as a search may leave them; nothing when it has none."""
    wild = [name for name in z if not library[name].linear and library[name].amplitude is None]
    out = []
    for i in range(count if wild else 0):
        near = dict(z)
        for name in wild:
            spread = np.array([c.spread for c in library[name].coordinates])
            off = qmc.Halton(len(spread), seed=100 + i).random(1)[0] * 2.0 - 1.0
            near[name] = library[name].clip(z[name] + NEAR * spread * off)
        out.append(near)
    return out
