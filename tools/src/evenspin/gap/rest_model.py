"""The machine with terms that no effect of the table is: the known effects beside them are fitted and named again.

A name that was found without the terms may have stood for what they say better, and another may have been hidden by it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from evenspin.empirical.effect import Effects
from evenspin.gap.candidate import Model
from evenspin.gap.finding import Finding
from evenspin.gap.fitting import Fitter
from evenspin.gap.investigate import Investigation, tolerated
from evenspin.gap.outcome import Outcome, Validation
from evenspin.gap.partial import GapOf, partial, size_spread
from evenspin.gap.rest import Rest, rest_of
from evenspin.gap.thresholds_effects import PARTIAL_GAIN, PARTIAL_SHARE, WORSE_SHARE
from evenspin.log.tolerance import unit_of
from evenspin.log.unit import Unit

Array = NDArray[np.float64]

STEPS, STEPS_WITHOUT = 4, 2  # downhill: with all of them, and with one less


@dataclass(frozen=True, slots=True)
class Closed:
    """What is simulated with the terms. `finding` has the names that stand beside them; `effects` are theirs; `fitter`
    has the terms in every simulation; `gap_of` is that on the validation records, with the terms."""

    rest: Rest
    finding: Finding
    fitter: Fitter
    model: Model
    effects: Effects
    delta: Array
    unit: Unit
    after: Outcome
    gap_of: GapOf


def closed(
    investigation: Investigation,
    finding: Finding,
    validation: Validation,
    known: Outcome,
    say: Callable[[str, float], None],
) -> Closed | None:
    """The records as they were logged, with terms for what the named effects leave. None: no term of the library
    explains it, or the simulation of the records is no better with it (`known`: without)."""
    named = {name: finding.model.z[name] for name in finding.named}
    without = investigation.search.fitter.on(investigation.original)
    nominal = investigation.original.replays[0].nominal
    rest = rest_of(validation.case, nominal, investigation.scale, without.effects(named), say)
    if not rest.terms:
        return None
    say("simulating what was found", 0.95)
    fitter = replace(without, always=rest.effects)
    beside = {name: z for name, z in rest.beside.items() if name in fitter.library}
    model, weights = _standing(fitter, fitter.model({**named, **beside}))
    spread = {name: size_spread(fitter, model, name) for name in model.z}
    names = partial(model, weights, spread, _gap_of(fitter, model, validation))
    if set(names) != set(model.z):
        model = fitter.descended(fitter.model({name: model.z[name] for name in names}), STEPS_WITHOUT)
    delta = tolerated(model.delta)
    unit = unit_of(fitter.effects(model.z), delta)
    after = validation.outcome(unit)
    if rest.effects and not _better(after, known, without.model(named), model):
        return None
    effects = {name: fitter.library[name].to_params(model.z[name]) for name in names}
    named_now = replace(
        finding,
        named=names,
        weights={name: weights[name] for name in names},
        size_spread={**finding.size_spread, **spread},
    )
    return Closed(rest, named_now, fitter, model, effects, delta, unit, after, _gap_of(fitter, model, validation))


def _standing(fitter: Fitter, model: Model) -> tuple[Model, dict[str, float]]:
    """The effects that are larger than a tolerance and take something off, and how much each does."""
    model = fitter.descended(model, STEPS)
    weights: dict[str, float] = {}
    for name in list(model.z):
        others = {other: z for other, z in model.z.items() if other != name}
        less = fitter.descended(fitter.model(others), STEPS_WITHOUT)
        weights[name] = less.cost - model.cost
        large = fitter.library[name].magnitude(model.z[name]) >= 1.0
        if weights[name] < PARTIAL_GAIN or not large:
            return _standing(fitter, less)
    return model, weights


def _gap_of(fitter: Fitter, model: Model, validation: Validation) -> GapOf:
    @cache
    def gap(names: tuple[str, ...]) -> float:
        effects = fitter.effects({name: model.z[name] for name in names})
        return validation.outcome(unit_of(effects, tolerated(model.delta))).gap

    return gap


def _better(after: Outcome, known: Outcome, without: Model, model: Model) -> bool:
    """On the validation records; where what is left has settled before them, on the others and not worse on these."""
    if after.gap**2 < (1.0 - PARTIAL_SHARE) * known.gap**2:
        return True
    return after.gap <= (1.0 + WORSE_SHARE) * known.gap and without.cost - model.cost > PARTIAL_GAIN
