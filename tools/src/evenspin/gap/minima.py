"""Where the cost has many local minima: effects whose logs are neither linear in their coordinates nor repeatable.

Around each of the best starts some points are simulated. A plane through the features of all of them, over steps that
are large against what does not repeat, then proposes the next point: Gauss-Newton with a secant through many points.
Coordinates in which an explanation is linear follow at each point by a linear fit, so that they cost no simulation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import Hypothesis
from evenspin.gap.candidate import Z
from evenspin.gap.evidence import model_features
from evenspin.gap.fitting import Fitter
from evenspin.gap.thresholds_evidence import NEIGHBOUR_SHARE

Array = NDArray[np.float64]
SEEDS = 3  # of the starts are searched around
AROUND = 2  # points per coordinate
SEED_WIDTH = 0.8  # in shares of the grid's pitch
WIDTHS = (0.5, 0.35, 0.2)  # around the best, one after the other
DAMPINGS = (0.03, 0.3, 3.0)  # of the proposals, relative to what the log says
REACH = 1.5  # widths that a proposal may go


@dataclass(frozen=True, slots=True)
class Point:
    """One set of nonlinear coordinates, with the linear ones where they fit best."""

    x: Array  # nonlinear coordinates, in shares of the grid's pitch
    features: Array
    amount: Array  # of the linear coordinates, from where they are
    cost: float


class MinimaSearch:
    """The search around the starts of the effects in `z` that are not linear."""

    def __init__(self, fitter: Fitter, z: Z, probes: int = 1) -> None:
        self.fitter = fitter
        self.probes = probes
        self.base = z
        library = fitter.library
        self.nonlinear = [name for name in z if not library[name].linear]
        self.linear = [name for name in z if library[name].linear]
        self.pitch = np.concatenate([[c.spread for c in library[name].coordinates] for name in self.nonlinear])
        self.round = 0  # seeds the scatter of points: another one each time
        self.columns = self._linear_columns()

    def lowest(self) -> Z:
        """The lowest point found from all starts; at worst `z` itself."""
        seeds = sorted(self._simulated(self._starts()), key=lambda point: point.cost)[:SEEDS]
        best = min((self._searched_around(seed, SEED_WIDTH) for seed in seeds), key=lambda point: point.cost)
        return self._z(best.x, best.amount)

    def bottom(self) -> Z:
        """The lowest point found near `z`."""
        (best,) = self._simulated([self._x(self.base)])
        for width in WIDTHS:
            best = self._searched_around(best, width)
        return self._z(best.x, best.amount)

    def _starts(self) -> list[Array]:
        """The starts of each effect, the others where the candidate has them."""
        home = self._x(self.base)
        starts = [home]
        for name in self.nonlinear:
            h = self.fitter.library[name]
            if h.amplitude is None:
                starts += [self._x({**self.base, name: np.array(start)}) for start in h.starts]
        return starts

    def _searched_around(self, best: Point, width: float) -> Point:
        from scipy.stats import qmc  # half a second, which a search without many minima does not need

        self.round += 1
        count = AROUND * len(best.x)
        scatter = qmc.Halton(len(best.x), seed=self.round).random(count) * 2.0 - 1.0
        points = self._simulated([best.x + width * off for off in scatter])
        lowest = min([best, *points], key=lambda point: point.cost)
        proposals = self._simulated(self._proposals(lowest, [best, *points], width))
        return min([lowest, *proposals], key=lambda point: point.cost)

    def _proposals(self, at: Point, points: Sequence[Point], width: float) -> list[Array]:
        others = [point for point in points if point is not at]
        steps = np.stack([point.x - at.x for point in others])
        change = np.stack([point.features - at.features for point in others])
        plane = np.linalg.lstsq(steps, change, rcond=1e-6)[0].T
        judge, nuisance = self.fitter.judge, self.fitter.nuisance
        extra = np.hstack((plane, self.columns))
        out = []
        for damping in DAMPINGS:
            fit = judge.fit(self.fitter.forward.measured - at.features, nuisance, extra, damping, self.base)
            step = fit.amount[: len(at.x)]
            length = float(np.max(np.abs(step)))
            out.append(at.x + step * min(1.0, REACH * width / max(length, 1e-12)))
        return out

    def _simulated(self, xs: Sequence[Array]) -> list[Point]:
        nothing = np.zeros(self.columns.shape[1])
        zs = [self._z(x, nothing) for x in xs]
        runs = model_features(self.fitter.forward, [self.fitter.effects(z) for z in zs], self.probes)
        return [self._judged(self._x(z), run.mean(axis=0)) for z, run in zip(zs, runs, strict=True)]

    def _judged(self, x: Array, features: Array) -> Point:
        residual = self.fitter.forward.measured - features
        fit = self.fitter.judge.fit(residual, self.fitter.nuisance, self.columns, 1e-6, self.base)
        return Point(x, features, fit.amount, fit.cost)

    def _linear_columns(self) -> Array:
        """Change of the features per unit of each linear coordinate, the nonlinear effects as `z` has them."""
        if not self.linear:
            return np.zeros((len(self.fitter.forward.measured), 0))
        return self.fitter.columns(self.fitter.model(self.base), set(self.linear))

    def _x(self, z: Z) -> Array:
        return np.concatenate([z[name] for name in self.nonlinear]) / self.pitch

    def _z(self, x: Array, amount: Array) -> Z:
        """Within the limits of every coordinate, names in the order they had."""
        out = dict(self.base)
        for names, values in ((self.nonlinear, x * self.pitch), (self.linear, amount)):
            at = 0
            for name in names:
                part = values[at : at + len(self.base[name])]
                at += len(part)
                h = self.fitter.library[name]
                out[name] = h.clip(part if names is self.nonlinear else self.base[name] + part)
        return out


def neighbours(library: Mapping[str, Hypothesis], z: Z, count: int) -> list[Z]:
    """The model with its nonlinear effects as far off as a search may leave them; empty when it has none."""
    nonlinear = [name for name in z if not library[name].linear and library[name].amplitude is None]
    if not nonlinear:
        return []
    from scipy.stats import qmc

    out = []
    for i in range(count):
        near = dict(z)
        for name in nonlinear:
            spread = np.array([c.spread for c in library[name].coordinates])
            off = qmc.Halton(len(spread), seed=100 + i).random(1)[0] * 2.0 - 1.0
            near[name] = library[name].clip(z[name] + NEIGHBOUR_SHARE * spread * off)
        out.append(near)
    return out
