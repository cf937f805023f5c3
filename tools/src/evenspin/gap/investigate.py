"""From a case to a finding: name what is missing, one effect at a time, or say that nothing known explains the log."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import Hypothesis, Scale, hypotheses
from evenspin.gap.acceptance import Acceptance, ExpectedCost
from evenspin.gap.candidate import Candidate, Model
from evenspin.gap.evidence import model_features
from evenspin.gap.finding import Finding
from evenspin.gap.fitting import Fitter
from evenspin.gap.forward import Forward
from evenspin.gap.leftover import Line, leftover_lines
from evenspin.gap.minima import neighbours
from evenspin.gap.outcome import Validation
from evenspin.gap.partial import partial, size_spread
from evenspin.gap.periodic import PeriodicLine, periodic_lines, without
from evenspin.gap.search import Search
from evenspin.gap.slotting import detected_order
from evenspin.gap.thresholds_effects import (
    CANDIDATES,
    CANDIDATES_BESIDE,
    EFFECTS_MAX,
    FIRST_KEPT,
    GAIN_MIN,
    INSTEAD_SPREAD,
    LINE_RATIO,
    LINES_MIN,
    NEAR_GAIN,
    NONLINEAR_GAIN,
    PAIR_GAIN,
    SETTLED_SHARE,
    SURE_GAIN,
    TOLERATED,
    VARIES_SPREAD,
    WORSE_SHARE,
)
from evenspin.log.case import Case
from evenspin.log.tolerance import SIGMA, unit_of
from evenspin.log.unit import Unit

SETTLE_MAX = 4  # rounds of noise level and refinement around an explanation
LINES_KEPT, LINES_ALL = 12, 1000
LINE_REPEATS, LINE_NEIGHBOURS = 6, 8  # simulations of the model, and beside it, that a left-over line is held against
REACH_SHARE = 0.5  # of the least gain: a refinement that will not even reach this is given up
HEALTHY_UNITS = 8  # simulated units within tolerance from which the cost expected of a correct model is taken

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]  # what is being done, share done


class Investigation:
    """The search through one case, stage by stage. `run` once; `forward.close()` when done."""

    def __init__(self, case: Case, workers: int | None = None, progress: Progress | None = None) -> None:
        self.say = progress or (lambda what, share: None)
        self.say("reading", 0.0)
        self.scale = Scale.of(case.meta["motor"], float(case.meta["encoder"]["counts_per_rev"]))
        forward = self.original = Forward(case, workers)
        self.say("noise and tolerance", 0.02)
        self._begin(Fitter.nominal(forward, hypotheses(self.scale)), ())

    def _begin(self, fitter: Fitter, beside: tuple[PeriodicLine, ...]) -> None:
        """`beside`: lines that were taken off the log, so that whatever is named, something else is there, too."""
        self.forward = fitter.forward
        self.case = fitter.forward.case
        self.beside = beside
        motor, encoder = self.case.meta["motor"], self.case.meta["encoder"]
        nothing = fitter.model({})
        order = detected_order(motor, self.forward.keys, nothing.residual)
        self.library = hypotheses(Scale.of(motor, float(encoder["counts_per_rev"]), order))
        self.nominal = replace(fitter, library=self.library)
        self.search = Search(self.nominal, nothing)
        self.rules = Acceptance(self.library)
        self.validation = Validation(self.case)
        self.tried: list[Model] = []
        self.first_explanations: list[Model] = []  # first explanations, best first
        self.pairs: list[Model] = []  # pairs that were refined during the search

    def without_tones(self, least_ratio: float, model: Model | None = None) -> bool:
        """Begin again on the log less what repeats in it with a frequency or an order of its own; False: it has none.

        `model`: the machine that leaves these lines, the nominal one where nothing was searched yet.
        """
        model = model or self.search.nothing
        unit = unit_of(self.search.fitter.effects(model.z), tolerated(model.delta))
        lines = periodic_lines(self.forward, self.lines(model, LINES_ALL), unit, least_ratio)
        if lines:
            cleaned = without(self.case, self.forward, lines, unit)
            self._begin(self.nominal.on(self.forward.on(cleaned.case, cleaned.uncertain)), lines)
        return bool(lines)

    def run(self) -> Finding:
        search = self.search
        nothing = search.nothing
        expected = self.expected_cost(nothing)
        self.say("screening", 0.10)
        best = self._first(nothing, expected)
        steps = [nothing]
        if best.z:
            self.say("noise around the first explanation", 0.35)
            best, expected = self._settled(best)
            if len(best.z) > 1:  # the single effect that led there
                steps += [m for m in self.first_explanations if set(m.z) < set(best.z)][:1]
            steps.append(best)
            best, expected, more = self._further(best, expected)
            steps += more
            other = self._instead(best, expected)
            if other is not None:
                best, expected = self._settled(other)
                best, expected, more = self._further(best, expected)
                steps += [best, *more]
        self.say("dropping and weighing", 0.85)
        best = search.refine(best) if best.z else best  # to the end of its way down
        best, weights = self._drop(best, expected)
        lines = self.lines(best)
        spread = {name: size_spread(search.fitter, best, name) for name in best.z}
        changes = changing(spread, self.library)
        left = expected.excess(best.cost) > expected.limit or _has_unknown_lines(lines)
        if changes and not left and not self._serve(best, changes):
            best, weights = self._without(best, weights, changes)
            lines, changes = self.lines(best), ()
            left = expected.excess(best.cost) > expected.limit or _has_unknown_lines(lines)
        named = tuple(sorted(best.z, key=lambda name: -weights.get(name, 0.0)))
        unexplained = left or bool(changes)
        unknown = unexplained or bool(self.beside)
        part = partial(best, weights, spread, self.gap_of(best)) if unknown else ()
        before = search.fitter.judge.fit(self.forward.measured - nothing.features, search.fitter.nuisance).cost
        return Finding(
            best,
            part if unknown else named,
            unknown,
            before,
            expected,
            lines,
            tuple(search.fitter.judged(model) for model in self.tried),  # costs compare under one noise only
            tuple(steps),
            weights,
            self.forward.simulations,
            spread,
            changes,
            self.beside,
        )

    # ---- stages ------------------------------------------------------------------------------------------------------

    def _settled(self, model: Model) -> tuple[Model, ExpectedCost]:
        """The model refined under the noise level and the tolerances around itself; again while that still helps."""
        cost = math.inf
        for _ in range(SETTLE_MAX):
            self.search.reconsider(model)
            fitter = self.search.fitter
            found = self.search.refine(fitter.variant(fitter.judged(model)), 4)
            still = all(np.array_equal(z, model.z[name]) for name, z in found.z.items())
            model, expected = found, self.expected_cost(found)
            if still or not expected.is_significant(model.cost) or model.cost > SETTLED_SHARE * cost:
                break
            cost = model.cost
        return model, expected

    def _first(self, nothing: Model, expected: ExpectedCost) -> Model:
        """The best single effect or pair to go on from; nothing when none earns a place."""
        alone = self.search.candidates(nothing, 1, CANDIDATES)
        candidates = [c for c in alone if self.rules.promises(c, nothing, expected)]
        if expected.is_significant(nothing.cost):
            in_pairs = self.search.candidates(nothing, 2, CANDIDATES_BESIDE)
            candidates += [c for c in in_pairs if c.gain > PAIR_GAIN * GAIN_MIN]
        models = self._refined(candidates, expected, 0.12, 0.33)
        singles = [m for m in models if len(m.z) == 1 and self.rules.earns(nothing, m, expected)]
        pairs = [m for m in models if len(m.z) == 2]
        if not singles:
            both = [m for m in pairs if self.rules.all_large(m) and nothing.cost - m.cost > PAIR_GAIN * GAIN_MIN]
            return min(both, key=lambda m: m.likelihood_cost, default=nothing)
        self.first_explanations = sorted(singles, key=lambda m: m.likelihood_cost)[:FIRST_KEPT]
        self.pairs = pairs
        single = self.first_explanations[0]
        whole = [m for m in pairs if not expected.is_significant(m.own_cost) and self.rules.earns(single, m, expected)]
        if whole and expected.is_significant(single.own_cost):
            return min(whole, key=lambda m: m.likelihood_cost)
        return single

    def _further(self, best: Model, expected: ExpectedCost) -> tuple[Model, ExpectedCost, list[Model]]:
        """One effect more at a time, as long as each earns its place; the steps on the way."""
        steps = []
        for stage in range(len(best.z) + 1, EFFECTS_MAX + 1):
            better = self._next(best, expected, 0.3 + 0.15 * stage)
            if better is None:
                break
            best, expected = self._settled(better)
            steps.append(best)
        return best, expected, steps

    def _instead(self, best: Model, expected: ExpectedCost) -> Model | None:
        """Where something is left: other effects in place of those whose size is not the same over the log."""
        if expected.excess(best.cost) <= expected.limit or len(best.z) < 2:
            return None
        spread = {name: size_spread(self.search.fitter, best, name) for name in best.z}
        wrong = {name for name in best.z if INSTEAD_SPREAD < spread[name] < math.inf}
        right = {name: z for name, z in best.z.items() if name not in wrong}
        if not wrong or not right:
            return None
        root = self.search.refine(Candidate(right, 0.0), 5, downhill=True)
        candidates = [
            candidate
            for size in (1, 2)
            for candidate in self.search.candidates(root, size, CANDIDATES_BESIDE)
            if not wrong & set(candidate.z)
        ]
        models = self._refined(candidates, expected, 0.75, 0.84)
        better = [m for m in models if self.rules.earns(best, m, expected)]
        return min(better, key=lambda m: m.likelihood_cost, default=None)

    def _next(self, best: Model, expected: ExpectedCost, share: float) -> Model | None:
        """One more effect, from the best explanation and from its runner-up."""
        roots = [best]
        unexplained = expected.is_significant(best.cost)
        if len(best.z) == 1 and unexplained:
            roots += [m for m in self.first_explanations if set(m.z) != set(best.z)]
        candidates: list[Candidate] = []
        for root in roots:
            possible = self.search.candidates(root, 1, len(self.library), borrowed=True)
            if not unexplained and not any(self.rules.promises(c, best, expected) for c in possible[:CANDIDATES]):
                return None
            among = self.rules.worth_simulating(possible, unexplained)
            more = self.search.candidates(root, 1, CANDIDATES if root is best else CANDIDATES_BESIDE, among=among)
            candidates += [candidate for candidate in more if self.rules.promises(candidate, best, expected)]
        if len(best.z) == 1 and unexplained:
            candidates += [Candidate(m.z, 0.0) for m in self.pairs]
        unique = {frozenset(candidate.z): candidate for candidate in reversed(candidates)}
        models = self._refined(list(unique.values()), expected, share, share + 0.14, best)
        good = [m for m in models if self.rules.earns(best, m, expected) and self.rules.all_large(m)]
        found = min(good, key=lambda m: m.likelihood_cost, default=None)
        if found is None:
            return None
        explained = self.search.fitter.judged(self.search.nothing).cost - best.cost
        if not unexplained and self.rules.is_remainder(best, found, explained):
            return None
        trusted = self.rules.is_decisive(best, found, expected) or self._validates(best, found)
        return found if trusted else None

    def _validates(self, without: Model, with_it: Model) -> bool:
        """One more effect must not make the records worse that no fit has seen, nor stretch a tolerance too far."""
        units = (unit_of(self.search.fitter.effects(m.z), tolerated(m.delta)) for m in (without, with_it))
        before, after = (self.validation.outcome(unit).gap for unit in units)
        return not after > before * (1.0 + WORSE_SHARE)

    def gap_of(self, model: Model) -> Callable[[tuple[str, ...]], float]:
        """The gap on the validation records with some of the effects of a model; with none, of the nominal machine."""

        @cache
        def gap(names: tuple[str, ...]) -> float:
            effects = self.search.fitter.effects({name: model.z[name] for name in names})
            return self.validation.outcome(unit_of(effects, tolerated(model.delta)) if names else Unit()).gap

        return gap

    def _refined(
        self,
        candidates: list[Candidate],
        expected: ExpectedCost,
        start: float,
        end: float,
        without: Model | None = None,
    ) -> list[Model]:
        """Each candidate refined, small sets first; once one explains the log, only its close rivals.

        `without`: the explanation that each has to improve on; what cannot reach that is given up.
        """
        out: list[Model] = []
        best = math.inf
        start_cost = self.search.nothing.cost
        candidates = sorted(candidates, key=lambda candidate: (len(candidate.z), -candidate.gain))
        for i, candidate in enumerate(candidates):
            explained = bool(out) and not expected.is_significant(best)
            if explained and (candidate.gain < NEAR_GAIN * candidates[0].gain or len(candidate.z) > len(out[0].z)):
                continue
            nonlinear = any(not self.library[name].linear for name in candidate.z)
            if nonlinear and out and (explained or candidate.gain < NONLINEAR_GAIN * (start_cost - best)):
                continue  # a wide search costs as much as all the others together
            self.say(f"trying {' + '.join(candidate.z)}", start + (end - start) * i / max(1, len(candidates)))
            beat = best + expected.mean
            if without is not None:
                beat = min(beat, without.cost - REACH_SHARE * self.rules.least_gain(set(candidate.z) - set(without.z)))
            found = self.search.refine(candidate, beat=beat)
            simpler = [self.search.refine(twin, downhill=True) for twin in self.rules.simpler(found)]
            out += [found, *simpler]
            best = min(best, *(m.own_cost for m in (found, *simpler)))
        self.tried += out
        return out

    def _stands(self, name: str, gain: float, without: Model, with_it: Model) -> bool:
        """What an effect takes off the cost is enough, also in simulations that no fit has seen where it is little."""
        if not self.rules.needs_recheck(name, gain):
            return self.rules.holds(name, gain)
        before, after = self.search.fitter.fresh_costs(without, with_it)
        return self.rules.holds_on_recheck(name, before - after)

    def _drop(self, best: Model, expected: ExpectedCost) -> tuple[Model, dict[str, float]]:
        """Take out what is not needed; by how much each remaining one lowers the cost."""
        weights: dict[str, float] = {}
        names = list(best.z)
        if not names:
            return best, weights
        if len(names) == 1:
            empty = self.search.fitter.judged(self.search.nothing)
            self.tried.append(empty)
            gain = empty.cost - best.cost
            # under the noise level and tolerances around itself it may be less than it seemed at first
            keep = self._stands(names[0], gain, empty, best) and self.rules.all_large(best)
            return (best, {names[0]: gain}) if keep else (empty, {})
        for name in names:
            others = {k: z for k, z in best.z.items() if k != name}
            without = self.search.refine(Candidate(others, 0.0), 5, downhill=True)
            if without.cost - best.cost < SURE_GAIN:
                without = min(without, self.search.refine(Candidate(others, 0.0), 5), key=lambda m: m.cost)
            self.tried.append(without)
            weights[name] = without.cost - best.cost
            if not self._stands(name, weights[name], without, best) or not self.rules.all_large(best):
                return self._drop(without, expected)
        return best, weights

    def _serve(self, best: Model, names: Sequence[str]) -> bool:
        """Whether effects lower the gap on records that no fit has seen."""
        gap = self.gap_of(best)
        return gap(tuple(best.z)) < gap(tuple(name for name in best.z if name not in names))

    def _without(
        self, best: Model, weights: Mapping[str, float], names: Sequence[str]
    ) -> tuple[Model, dict[str, float]]:
        """What the others leave. They were chance: the log is as well explained without them."""
        others = {name: z for name, z in best.z.items() if name not in names}
        fitter = self.search.fitter
        model = (
            self.search.refine(Candidate(others, 0.0), 5, downhill=True)
            if others
            else fitter.judged(self.search.nothing)
        )
        self.tried.append(model)
        return model, {name: weights[name] for name in others}

    # ---- what is left -----------------------------------------------------------------------------------------------

    def expected_cost(self, model: Model) -> ExpectedCost:
        fitter = self.search.fitter
        effects = fitter.effects(model.z)
        random = np.random.default_rng(29)
        deltas = random.normal(0.0, SIGMA, (HEALTHY_UNITS, len(SIGMA)))
        units = [unit_of(effects, d, 7000 + i, float(random.random())) for i, d in enumerate(deltas)]
        (probes,) = model_features(self.forward, [effects])
        features = probes.mean(axis=0)
        costs = [fitter.judge.fit(run - features, fitter.nuisance).cost for run in self.forward.many(units)]
        return ExpectedCost(float(np.mean(costs)), float(np.std(costs, ddof=1)))

    def lines(self, model: Model, keep: int = LINES_KEPT) -> tuple[Line, ...]:
        fitter = self.search.fitter
        effects = fitter.effects(model.z)
        units = [unit_of(effects, model.delta, 50 + i, (i + 0.5) / LINE_REPEATS) for i in range(LINE_REPEATS)]
        # a limit cycle may begin a little beside the point that was found
        near = enumerate(neighbours(self.library, model.z, LINE_NEIGHBOURS))
        units += [unit_of(fitter.effects(z), model.delta, 60 + i, (i + 0.5) / LINE_NEIGHBOURS) for i, z in near]
        return tuple(leftover_lines(self.forward, units, keep))


def changing(spread: Mapping[str, float], library: Mapping[str, Hypothesis]) -> tuple[str, ...]:
    """Effects whose size is another in parts of the log; of those that act in proportion to it, at no detent."""
    scales = (name for name in spread if library[name].linear and not library[name].rests)
    return tuple(name for name in scales if VARIES_SPREAD < spread[name] < math.inf)


def tolerated(delta: Array) -> Array:
    """Deviations of a unit, within what a unit may have."""
    bound = TOLERATED * SIGMA
    return np.clip(delta, -bound, bound)


def _has_unknown_lines(lines: tuple[Line, ...]) -> bool:
    """Enough lines of the spectrum that no effect of the model takes up."""
    return sum(line.ratio > LINE_RATIO for line in lines) >= LINES_MIN
