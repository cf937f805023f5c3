"""Models held against the log: simulation in the loop, Gauss-Newton steps, costs under a given noise."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import Hypothesis
from evenspin.empirical.effect import together
from evenspin.gap.candidate import Model, Z
from evenspin.gap.evidence import Effects, Judge, Noise, model_features, noise_level, nuisance_columns
from evenspin.gap.forward import Forward
from evenspin.log.tolerance import unit_of

Array = NDArray[np.float64]
FRESH, FRESH_SEED = 8, 400  # simulations of a check that no fit has seen
STEP_SHARE = 0.35  # of a coordinate's probe: a step around an explanation; all of it where logs do not repeat
DAMPING_START, DAMPING_MIN, DAMPING_TRIES = 1e-3, 1e-6, 3
# A step that takes this share off the cost is doubled while that helps, at most so far: robust weights shorten steps.
STRETCH_SHARE, STRETCH_MOST = 0.01, 8.0
GAIN_STOP, GAIN_STOP_SHARE = 0.2, 2e-4  # of cost, and of its share: a step that gains less is the last one


@dataclass(frozen=True, slots=True)
class Fitter:
    """A log with its simulator, its hypotheses, and the noise that residuals are judged by.

    A Fitter does not change: another noise level, or another model around which the tolerances are taken, is another
    Fitter (`with_noise`, `around`).
    """

    forward: Forward
    library: Mapping[str, Hypothesis]
    nuisance: Array  # change of the features per unit of each tolerance
    judge: Judge
    always: Effects = field(default_factory=dict)  # in every simulation, beside what is searched

    @classmethod
    def nominal(cls, forward: Forward, library: Mapping[str, Hypothesis]) -> Fitter:
        """Noise and tolerances of the machine without any effect."""
        nuisance = nuisance_columns(forward, {})
        return cls(forward, library, nuisance, Judge(noise_level(forward, nuisance)))

    def around(self, model: Model) -> Fitter:
        """Noise and tolerances of the machine with the effects of a model."""
        effects = self.effects(model.z)
        nuisance = nuisance_columns(self.forward, effects)
        return replace(self, nuisance=nuisance, judge=Judge(noise_level(self.forward, nuisance, effects)))

    def on(self, forward: Forward) -> Fitter:
        """The same noise and tolerances for other records of the same experiments."""
        noise = self.judge.noise
        return replace(self, forward=forward, judge=Judge(replace(noise, used=noise.used & forward.compared)))

    def with_noise(self, noise: Noise) -> Fitter:
        return replace(self, judge=Judge(noise))

    def effects(self, z: Z) -> Effects:
        """Parameters of the simulator's effects."""
        return together(self.always, {name: self.library[name].to_params(x) for name, x in z.items()})

    def noise_of(self, z: Z) -> Noise:
        """How little a machine with these effects repeats itself."""
        return noise_level(self.forward, self.nuisance, self.effects(z))

    def model(self, z: Z) -> Model:
        (probes,) = model_features(self.forward, [self.effects(z)])
        features = probes.mean(axis=0)
        fit = self.judge.fit(self.forward.measured - features, self.nuisance, known=z)
        return Model(z, fit.delta, features, probes[0], fit.cost, fit.residual)

    def judged(self, model: Model) -> Model:
        """A model that another Fitter made, under the noise and the tolerances of this one."""
        fit = self.judge.fit(self.forward.measured - model.features, self.nuisance, known=model.z)
        return replace(model, delta=fit.delta, cost=fit.cost, residual=fit.residual, own=None, likely=None)

    def columns(self, model: Model, only: Collection[str] | None = None) -> Array:
        """Change of the features per unit of each coordinate, of all effects or of some."""
        units = []
        steps = []
        for name, z in model.z.items():
            if only is not None and name not in only:
                continue
            for i, c in enumerate(self.library[name].coordinates):
                if not self.library[name].is_asked(i, z):
                    steps.append(0.0)
                    continue
                h = (STEP_SHARE if self.library[name].linear else 1.0) * c.probe
                if z[i] + h > c.high:
                    h = -h
                moved = z.copy()
                moved[i] += h
                units.append(self.effects({**model.z, name: moved}))
                steps.append(h)
        runs = iter(model_features(self.forward, units, 1))
        nothing = np.zeros(len(model.probe))
        return np.stack([(next(runs)[0] - model.probe) / h if h else nothing for h in steps], axis=1)

    def descended(self, model: Model, steps: int, beat: float = math.inf) -> Model:
        """Damped Gauss-Newton downhill from a model; gives up where a cost of `beat` is out of reach. A model without
        effects has nowhere to go and comes back as it is."""
        if not model.z:
            return model
        damping = DAMPING_START
        for step in range(steps):
            columns = self.columns(model)
            better = None
            for _ in range(DAMPING_TRIES):
                trial = self.model(self._stepped(model, columns, damping))
                if trial.cost < model.cost:
                    better = self._stretched(model, trial)
                    damping = max(damping / 10.0, DAMPING_MIN)
                    break
                damping *= 20.0
            if better is None:
                break
            gained, model = model.cost - better.cost, better
            if gained < GAIN_STOP + GAIN_STOP_SHARE * model.cost or model.cost - (steps - step) * gained > beat:
                break
        return model

    def variant(self, model: Model) -> Model:
        """The model with the variant of each of its effects that fits best, all else as it is."""
        best = model
        for name, z in model.z.items():
            for variant in self.library[name].variants:
                moved = z.copy()
                for i, value in variant.items():
                    moved[i] = value
                trial = self.model({**best.z, name: moved})
                best = trial if trial.cost < best.cost else best
        return best

    def _stretched(self, model: Model, stepped: Model) -> Model:
        """The step from one to the other, longer, while that leads further down.

        Where much is off, robust weights count what is worst explained least, and a step becomes far too short.
        """
        best, factor = stepped, 2.0
        while model.cost - stepped.cost > STRETCH_SHARE * model.cost and factor <= STRETCH_MOST:
            z = {name: self.library[name].clip(old + factor * (stepped.z[name] - old)) for name, old in model.z.items()}
            trial = self.model(z)
            if not trial.cost < best.cost:
                break
            best, factor = trial, 2.0 * factor
        return best

    def fresh_costs(self, *models: Model) -> list[float]:
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

    def _stepped(self, model: Model, columns: Array, damping: float) -> Z:
        probes = np.array([c.probe for name in model.z for c in self.library[name].coordinates])
        y = self.forward.measured - model.features
        fit = self.judge.fit(y, self.nuisance, columns * probes, damping, model.z)
        z, at = {}, 0
        for name, old in model.z.items():
            step = fit.amount[at : at + len(old)] * probes[at : at + len(old)]
            at += len(old)
            z[name] = self.library[name].clip(old + step)
        return z
