"""The search: which effects, how large. Screening is linear and cheap, refinement has the simulation in the loop."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.evidence import PROBES, Effects, Judge, Noise, model_features, noise_level, nuisance_columns
from evenspin.gap.forward import Forward
from evenspin.gap.hypotheses import Hypothesis
from evenspin.gap.tolerance import SIGMA, unit_of
from evenspin.gap.valleys import Valleys

Array = NDArray[np.float64]
Z = dict[str, Array]  # an effect's place in its coordinates
LINEAR_SHARE = 0.1  # share of a residual that a linear signature may miss; large residuals count that much less
STEPS_MAX = 8
FRESH, FRESH_SEED = 8, 400  # simulations of a second look
RING = np.arange(8) * math.tau / 8  # for effects whose cost has more than one valley over the phase...
RING_SCALES = (1.0, 2.5, 6.0, 12.0)  # ...at multiples of the amplitude of a linear fit: wells make that too small
STEPS_WILD = 4  # after the search of valleys
LIKENESS = 0.3  # of what the signature of a start explains that is not linear: what a better place may explain
STEP_SHARE = 0.35  # of a coordinate's probe: a step around an explanation; all of it where logs do not repeat


@dataclass(frozen=True, slots=True)
class Model:
    """A set of effects with their coordinates, refined on the fit records."""

    z: Z
    delta: Array
    features: Array  # expected
    probe: Array  # of the first probe alone: what columns are differences from
    cost: float
    residual: Array  # whitened
    own: float | None = None  # the cost where noise is what the model itself says it is
    likely: float | None = None  # that, with what it takes to have such noise: to be held against other models

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
class Lead:
    """Something worth refining: effects, where to start, and what a linear fit promises."""

    z: Z
    gain: float
    new: frozenset[str] = frozenset()  # effects beside those of a model that was refined already


class Search:
    def __init__(self, forward: Forward, library: dict[str, Hypothesis]) -> None:
        self.forward = forward
        self.library = library
        self.nuisance = nuisance_columns(forward, {})
        self.judge = Judge(noise_level(forward, self.nuisance))
        self._signed: tuple[Model | None, list[tuple[str, Array, Array]]] = (None, [])
        self._signed_nothing: list[tuple[str, Array, Array]] = []
        self.nothing = self._model({})

    def effects(self, z: Z) -> Effects:
        return {name: self.library[name].to_params(x) for name, x in z.items()}

    def reconsider(self, model: Model) -> None:
        """Nuisance columns and noise level anew around a model."""
        effects = self.effects(model.z)
        self.nuisance = nuisance_columns(self.forward, effects)
        self.judge = Judge(noise_level(self.forward, self.nuisance, effects))

    def _signatures_of(self, model: Model) -> list[tuple[str, Array, Array]]:
        if model is not self._signed[0]:
            if model is self.nothing:
                self._signed_nothing = self._signed_nothing or self.signatures(model)
                return self._signed_nothing
            self._signed = (model, self.signatures(model))
        return self._signed[1]

    # ---- screening --------------------------------------------------------------------------------------------------

    def signatures(self, model: Model) -> list[tuple[str, Array, Array]]:
        """(name, start, columns per coordinate) of every effect and start that the model does not have."""
        base_z = dict(model.z)
        jobs: list[tuple[str, Array, list[Array]]] = []
        for name, h in self.library.items():
            if name in base_z:
                continue
            for start in h.starts:
                z0 = np.array(start, dtype=np.float64)
                jobs.append((name, z0, _probe_points(h, z0)))
        units = [self.effects({**base_z, name: z}) for name, _, points in jobs for z in points]
        runs = iter(model_features(self.forward, units, 1))
        base = model.probe
        out = []
        for name, z0, points in jobs:
            h = self.library[name]
            columns = [next(runs)[0] for _ in points]
            if h.linear:
                columns = [
                    (f - (base if c.beside is None else columns[c.beside])) / c.probe
                    for f, c in zip(columns, h.coordinates, strict=True)
                ]
            else:
                columns = [columns[0] - base]
            out.append((name, z0, np.stack(columns, axis=1)))
        return out

    def leads(self, model: Model, size: int = 1, keep: int = 6, borrowed: bool = False) -> list[Lead]:
        """Sets of `size` more effects, best first, as a linear fit sees them; one lead a set of names.

        `borrowed`: with the signatures of the bare machine, which cost nothing more; good enough to see that nothing
        is left to find.
        """
        known = self._signatures_of(self.nothing if borrowed else model)
        signatures = [entry for entry in known if entry[0] not in model.z]
        y = (self.forward.measured - model.features) * self.judge.weight
        weight = 1.0 / np.sqrt(1.0 + (LINEAR_SHARE * y) ** 2)
        blocks = [self.nuisance, *(columns for _, _, columns in signatures)]
        a = np.hstack(blocks) * (self.judge.weight * weight)[:, None]
        b = y * weight
        gram, right = a.T @ a, a.T @ b
        n = len(SIGMA)
        gram[:n, :n] += np.diag(1.0 / SIGMA**2)
        edges = np.cumsum([n, *(columns.shape[1] for _, _, columns in signatures)])
        base = _explained(gram, right, np.arange(n))[0]
        tried = self._costs_of_starts(model, signatures) if size == 1 else {}
        best: dict[frozenset[str], Lead] = {}
        for combination in itertools.combinations(range(len(signatures)), size):
            names = frozenset(signatures[i][0] for i in combination)
            if len(names) < size or sum(self.library[name].is_shaft for name in {*names, *model.z}) > 1:
                continue
            columns = np.concatenate([np.arange(n), *(np.arange(edges[i], edges[i + 1]) for i in combination)])
            gain, x = _explained(gram, right, columns)
            z = dict(model.z)
            at, allowed = n, True
            for i in combination:
                name, z0, block = signatures[i]
                part = x[at : at + block.shape[1]]
                at += block.shape[1]
                place = self._place(name, z0, part)
                if place is None:
                    allowed = False
                    break
                z[name] = place
            promise = gain - base
            if combination[0] in tried:
                promise = max(tried[combination[0]], LIKENESS * promise)
            if allowed and promise > (best[names].gain if names in best else 0.0):
                best[names] = Lead(z, promise, names)
        return sorted(best.values(), key=lambda lead: -lead.gain)[:keep]

    def _costs_of_starts(self, model: Model, signatures: list[tuple[str, Array, Array]]) -> dict[int, float]:
        """What each start of an effect that is not linear takes off the cost as it stands: no line leads there."""
        y = self.forward.measured
        before = self.judge.fit(y - model.probe, self.nuisance).cost
        return {
            i: before - self.judge.fit(y - model.probe - columns[:, 0], self.nuisance).cost
            for i, (name, _, columns) in enumerate(signatures)
            if not self.library[name].linear and self.library[name].amplitude is None
        }

    def _place(self, name: str, z0: Array, amount: Array) -> Array | None:
        """Where a linear fit puts the effect; None where that is the wrong side of off."""
        h = self.library[name]
        if not h.linear:
            z = z0.copy()
            if h.amplitude is not None:
                z[h.amplitude] *= min(max(float(amount[0]), 0.05), 20.0)
            return h.clip(z) if amount[0] > 0.0 else None
        z = h.clip(z0 + amount)
        low = np.array([c.low for c in h.coordinates])
        return None if np.any((low == z0) & (amount <= 0.0)) else z

    # ---- refinement -------------------------------------------------------------------------------------------------

    def refine(
        self, lead: Lead | Model, steps: int = STEPS_MAX, beat: float = math.inf, at_home: bool = False
    ) -> Model:
        """Gauss-Newton with the simulation in the loop, damped; gives up where `beat` is out of reach.

        `at_home`: only downhill from where a lead is, also for effects whose cost has many valleys.
        """
        far = isinstance(lead, Lead) and not at_home
        if far and any(not self.library[name].linear for name in lead.z):
            return self._refined_wildly(lead, min(steps, STEPS_WILD))
        model = self._model(lead.z)
        rests = {name for name in lead.z if self.library[name].rests}
        if far and rests & (lead.new or set(lead.z)):
            return self._refined_in_wells(model, steps)
        return self._descended(model, steps, beat) if lead.z else model

    def _refined_wildly(self, lead: Lead, steps: int) -> Model:
        """For effects whose logs do not repeat to the sample: what varies with the noise counts less on the way."""
        strict = self.judge
        try:
            wild = self._own_noise(self._wildest(lead.z)).sigma
            self.judge = Judge(replace(strict.noise, sigma=np.maximum(strict.noise.sigma, wild)))
            found = Valleys(self, lead.z).lowest()
            varies = any(c.wildest is not None for name in found for c in self.library[name].coordinates)
            places = (found, self._wildest(found)) if varies else (found,)
            models = [self._under_own_noise(z, strict) for z in places]
            noise, model = min(models, key=lambda pair: pair[1].likelihood_cost)
            self.judge = Judge(noise)
            bottom = Valleys(self, model.z, len(PROBES) if varies else 1).bottom()
            model = min(model, self._model(bottom), key=lambda m: m.cost)
            model = self._descended(model, steps, math.inf)
            own, likely = model.cost, model.cost + _price(noise, strict.noise)
        finally:
            self.judge = strict
        return replace(self.rejudged(model), own=own, likely=likely)

    def _refined_in_wells(self, model: Model, steps: int) -> Model:
        """For a torque in which the rotor rests: where it does, the log does not repeat, and that noise is its own."""
        strict = self.judge
        model = self._descended(self._turned(model), steps, math.inf)
        noise = self._own_noise(model.z)
        self.judge = Judge(noise)
        try:
            model = self._descended(self.rejudged(model), steps, math.inf)
        finally:
            self.judge = strict
        return replace(self.rejudged(model), own=model.cost, likely=model.cost + _price(noise, strict.noise))

    def _wildest(self, z: Z) -> Z:
        return {name: self.library[name].as_wild_as_can_be(x) for name, x in z.items()}

    def _own_noise(self, z: Z) -> Noise:
        return noise_level(self.forward, self.nuisance, self.effects(z))

    def _under_own_noise(self, z: Z, strict: Judge) -> tuple[Noise, Model]:
        noise = self._own_noise(z)
        self.judge = Judge(noise)
        model = self._model(z)
        return noise, replace(model, own=model.cost, likely=model.cost + _price(noise, strict.noise))

    def _descended(self, model: Model, steps: int, beat: float) -> Model:
        damping = 1e-3
        for step in range(steps):
            columns = self.columns(model)
            better = None
            for _ in range(3):
                z = self._moved(model, columns, damping)
                trial = self._model(z)
                if trial.cost < model.cost:
                    better = trial
                    damping = max(damping / 10.0, 1e-6)
                    break
                damping *= 20.0
            if better is None:
                break
            gained, model = model.cost - better.cost, better
            if gained < 0.2 + 2e-4 * model.cost or model.cost - (steps - step) * gained > beat:
                break
        return model

    def _turned(self, model: Model) -> Model:
        """The best of a ring of phases for a torque in which the rotor can rest: there no line leads to the phase."""
        best = model
        for name in (name for name in model.z if self.library[name].rests):
            ring = [scale * _rotated(best.z[name], angle) for scale in RING_SCALES for angle in RING]
            places = [self.library[name].clip(z) for z in ring]
            runs = model_features(self.forward, [self.effects({**best.z, name: z}) for z in places], 1)
            y = self.forward.measured
            costs = [self.judge.fit(y - f[0], self.nuisance, known=best.z).cost for f in runs]
            k = int(np.argmin(costs))
            if costs[k] < best.cost:
                best = self._model({**best.z, name: places[k]})
        return best

    def columns(self, model: Model, only: Collection[str] | None = None) -> Array:
        """Change of the features per unit of each coordinate, of all effects or of some."""
        units = []
        steps = []
        for name, z in model.z.items():
            if only is not None and name not in only:
                continue
            for i, c in enumerate(self.library[name].coordinates):
                h = (STEP_SHARE if self.library[name].linear else 1.0) * c.probe
                if z[i] + h > c.high:
                    h = -h
                moved = z.copy()
                moved[i] += h
                units.append(self.effects({**model.z, name: moved}))
                steps.append(h)
        runs = model_features(self.forward, units, 1)
        return np.stack([(f[0] - model.probe) / h for f, h in zip(runs, steps, strict=True)], axis=1)

    def _moved(self, model: Model, columns: Array, damping: float) -> Z:
        probes = np.array([c.probe for name in model.z for c in self.library[name].coordinates])
        y = self.forward.measured - model.features
        scaled = columns * probes
        fit = self.judge.fit(y, self.nuisance, scaled, damping, model.z)
        z, at = {}, 0
        for name, old in model.z.items():
            step = fit.amount[at : at + len(old)] * probes[at : at + len(old)]
            at += len(old)
            z[name] = self.library[name].clip(old + step)
        return z

    def _model(self, z: Z) -> Model:
        (probes,) = model_features(self.forward, [self.effects(z)])
        features = probes.mean(axis=0)
        fit = self.judge.fit(self.forward.measured - features, self.nuisance, known=z)
        return Model(z, fit.delta, features, probes[0], fit.cost, fit.residual)

    def second_look(self, *models: Model) -> list[float]:
        """Cost of each model by simulations that no fit has seen.

        Small changes of a machine make an encoder round elsewhere, and a search picks those that happen to fit: what
        it gains so is gone with other noise and another angle within a count.
        """
        todo = [
            unit_of(self.effects(m.z), None, FRESH_SEED + i, (i + 0.5) / FRESH) for m in models for i in range(FRESH)
        ]
        runs = np.array(self.forward.many(todo)).reshape(len(models), FRESH, -1).mean(axis=1)
        y = self.forward.measured
        return [self.judge.fit(y - f, self.nuisance, known=m.z).cost for m, f in zip(models, runs, strict=True)]

    def rejudged(self, model: Model) -> Model:
        """The same model under today's noise level and nuisance columns."""
        fit = self.judge.fit(self.forward.measured - model.features, self.nuisance, known=model.z)
        return replace(model, delta=fit.delta, cost=fit.cost, residual=fit.residual, own=None, likely=None)


def _price(noise: Noise, of: Noise) -> float:
    """What a model pays for saying that the log repeats less than `of` says: the norm of its density."""
    both = noise.used & of.used
    return float(2.0 * np.sum(np.log(noise.sigma[both] / of.sigma[both])))


def _probe_points(h: Hypothesis, z0: Array) -> list[Array]:
    if not h.linear:
        return [z0]
    points = []
    for i, c in enumerate(h.coordinates):
        z = z0.copy()
        z[i] += c.probe
        if c.beside is not None:
            z[c.beside] += h.coordinates[c.beside].probe
        points.append(z)
    return points


def _rotated(z: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * z[0] - s * z[1], s * z[0] + c * z[1]])


def _explained(gram: Array, right: Array, columns: Sequence[int] | Array) -> tuple[float, Array]:
    g = gram[np.ix_(columns, columns)].copy()
    g[np.diag_indices_from(g)] *= 1.0 + 1e-9
    g[np.diag_indices_from(g)] += 1e-12
    x = np.linalg.solve(g, right[columns])
    return float(right[columns] @ x), x
