"""From a case to a finding: name what is missing, one effect at a time, or say that nothing known explains the log."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.candidate import Lead, Model
from evenspin.gap.evidence import model_features
from evenspin.gap.fitting import Fitter
from evenspin.gap.forward import Forward
from evenspin.gap.hypotheses import hypotheses
from evenspin.gap.leftover import Line, leftover_lines
from evenspin.gap.minima import neighbours
from evenspin.gap.outcome import Validation
from evenspin.gap.search import Search
from evenspin.gap.slotting import heard_order
from evenspin.gap.tolerance import SIGMA, unit_of
from evenspin.log.case import Case

EFFECTS_MAX = 3
LEADS = 6  # refined per stage
SETTLE_MAX = 4  # rounds of noise level and refinement around an explanation
BEAM = 2  # first explanations that are carried on
SOUND_UNITS = 8  # simulated sound units that say what cost a true model has
GAIN_MIN = 40.0  # of cost; features repeat one another, so that a chance gain is some times a chi-square's
SURE_GAIN = 400.0  # what no other valley of the rest makes up for
GAIN_BEYOND_TOLERANCE = 8.0  # the same for what is a tolerance, only larger: three of its sigmas make 9
SHARE_MIN = 0.10  # of the excess that an effect has to explain
IMPERFECT_SHARE = 0.005  # of what a first effect explains: what its model may leave, where nothing significant is left
WEAK_GAIN = 500.0  # deserves a second look: by chance, gains of 100 come up
TOLERATED = 3.0  # sigmas that a unit may be off
SECOND_SHARE = 0.5  # of the least gain, at a second look: there no search has picked what fits
FAR_OFF = 1.5  # times the edge of a tolerance, which is three sigmas
DECISIVE_SHARE = 0.5  # of the excess: where a loop rings, no simulation follows the validation records either
WORSE_SHARE = 0.002  # of the validation gap: not worse
EXCESS_SIGMAS = 6.0  # beyond what sound units have: something is left
EXCESS_SHARE = 0.12  # and that share of the expected cost: two honest simulators differ by less
UNKNOWN_SHARE = 0.4  # so much more than noise makes the verdict unknown: what is nearly right is a little different
LINE_RATIO = 40.0  # power of a line over the model's noise
LINES_MIN = 3  # in so many stretches or signals
WILD_GAIN = 0.1  # of what the best explanation so far takes off: least promise of an effect that is not linear
NEAR_GAIN = 0.3  # of the best lead's promise: still worth a look when the best one explains the log
ALTERNATIVE_COST = 20.0  # cost by which an alternative is e times less likely

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]  # what is being done, share done


@dataclass(frozen=True, slots=True)
class Floor:
    """Cost that a true model has: over sound units, simulated."""

    mean: float
    sigma: float

    def excess(self, cost: float) -> float:
        return cost - self.mean

    def is_significant(self, cost: float) -> bool:
        """Worth a further search."""
        return self.excess(cost) > max(EXCESS_SIGMAS * self.sigma, EXCESS_SHARE * self.mean)

    @property
    def limit(self) -> float:
        """Excess beyond which no explanation holds."""
        return max(EXCESS_SIGMAS * self.sigma, UNKNOWN_SHARE * self.mean)


@dataclass(frozen=True, slots=True)
class Finding:
    model: Model  # best explanation, named or not
    named: tuple[str, ...]  # strongest first; empty: nothing missing, or unknown
    unknown: bool
    before: float  # cost of the nominal machine
    floor: Floor
    lines: tuple[Line, ...]
    tried: tuple[Model, ...]
    steps: tuple[Model, ...] = ()  # nothing, then one effect more each: how it was found
    weights: dict[str, float] = field(default_factory=dict)  # cost that each named effect takes away
    simulations: int = 0


class Investigation:
    def __init__(self, case: Case, workers: int | None = None, progress: Progress | None = None) -> None:
        self.case = case
        self.say = progress or (lambda what, share: None)
        self.say("reading", 0.0)
        self.forward = Forward(case, workers)
        motor, encoder = case.meta["motor"], case.meta["encoder"]
        counts = float(encoder["counts_per_rev"])
        self.say("noise and tolerance", 0.02)
        fitter = Fitter.nominal(self.forward, hypotheses(motor, counts))
        nothing = fitter.model({})
        heard = heard_order(motor, self.forward.labels, nothing.residual)
        self.library = hypotheses(motor, counts, heard)
        self.search = Search(replace(fitter, library=self.library), nothing)
        self.validation = Validation(case)
        self.tried: list[Model] = []
        self.beam: list[Model] = []  # first explanations, best first
        self.pairs: list[Model] = []  # pairs that were refined on the way

    def run(self) -> Finding:
        search = self.search
        nothing = search.nothing
        floor = self.floor(nothing)
        self.say("screening", 0.10)
        best = self._first(nothing, floor)
        steps = [nothing]
        if best.z:
            self.say("noise around the first explanation", 0.35)
            best, floor = self._settled(best)
            steps += [m for m in self.beam if len(best.z) > 1 and set(m.z) < set(best.z)][:1]  # how it went there
            steps.append(best)
            for stage in range(len(best.z) + 1, EFFECTS_MAX + 1):
                better = self._next(best, floor, 0.3 + 0.15 * stage)
                if better is None:
                    break
                best = better
                best, floor = self._settled(best)
                steps.append(best)
        self.say("dropping and weighing", 0.85)
        best, weights = self._drop(best, floor)
        lines = self.lines(best)
        named = tuple(sorted(best.z, key=lambda name: -weights.get(name, 0.0)))
        unknown = floor.excess(best.cost) > floor.limit or _lines_speak(lines)
        before = search.fitter.judge.fit(self.forward.measured - nothing.features, search.fitter.nuisance).cost
        return Finding(
            best,
            () if unknown else named,
            unknown,
            before,
            floor,
            lines,
            tuple(self.tried),
            tuple(steps),
            weights,
            self.forward.simulations,
        )

    # ---- stages ------------------------------------------------------------------------------------------------------

    def _settled(self, model: Model) -> tuple[Model, Floor]:
        """The model refined under the noise level and the tolerances around itself; again while that still helps."""
        cost = math.inf
        for _ in range(SETTLE_MAX):
            self.search.reconsider(model)
            found = self.search.refine(self.search.fitter.judged(model), 4)
            still = all(np.array_equal(z, model.z[name]) for name, z in found.z.items())
            model, floor = found, self.floor(found)
            if still or not floor.is_significant(model.cost) or model.cost > 0.97 * cost:
                break
            cost = model.cost
        return model, floor

    def _first(self, nothing: Model, floor: Floor) -> Model:
        """The best single effect or pair to go on from; nothing when none earns a place."""
        leads = [lead for lead in self.search.leads(nothing, 1, LEADS) if self._promises(lead, nothing, floor)]
        if floor.is_significant(nothing.cost):
            leads += [lead for lead in self.search.leads(nothing, 2, 3) if lead.gain > 2.0 * GAIN_MIN]
        models = self._refined(leads, floor, 0.12, 0.33)
        singles = [m for m in models if len(m.z) == 1 and self._earns(nothing, m, floor)]
        pairs = [m for m in models if len(m.z) == 2]
        if not singles:
            both = [m for m in pairs if self._all_large(m) and nothing.cost - m.cost > 2.0 * GAIN_MIN]
            return min(both, key=lambda m: m.likelihood_cost, default=nothing)
        self.beam = sorted(singles, key=lambda m: m.likelihood_cost)[:BEAM]
        self.pairs = pairs
        single = self.beam[0]
        whole = [m for m in pairs if not floor.is_significant(m.own_cost) and self._earns(single, m, floor)]
        if whole and floor.is_significant(single.own_cost):
            return min(whole, key=lambda m: m.likelihood_cost)
        return single

    def _next(self, best: Model, floor: Floor, share: float) -> Model | None:
        """One more effect, from the best explanation and from its runner-up."""
        roots = [best]
        unexplained = floor.is_significant(best.cost)
        if len(best.z) == 1 and unexplained:
            roots += [m for m in self.beam if set(m.z) != set(best.z)]
        leads: list[Lead | Model] = []
        if not unexplained and not any(
            self._promises(lead, best, floor) for lead in self.search.leads(best, 1, LEADS, borrowed=True)
        ):
            return None
        for root in roots:
            more = self.search.leads(root, 1, LEADS if root is best else 3)
            leads += [lead for lead in more if self._promises(lead, best, floor)]
        if len(best.z) == 1 and unexplained:
            leads += [Lead(m.z, 0.0) for m in self.pairs]
        unique = {frozenset(lead.z): lead for lead in reversed(leads)}
        models = self._refined(list(unique.values()), floor, share, share + 0.14)
        good = [m for m in models if self._earns(best, m, floor) and self._all_large(m)]
        found = min(good, key=lambda m: m.likelihood_cost, default=None)
        if found is None:
            return None
        explained = self.search.fitter.judged(self.search.nothing).cost - best.cost
        imperfect = best.cost - found.cost < IMPERFECT_SHARE * explained and not self._is_far_off(found, best)
        if not unexplained and imperfect:
            return None  # no more than what a large effect leaves that is modelled a little differently
        return found if self._is_trusted(best, found, floor) else None

    def _is_trusted(self, without: Model, with_it: Model, floor: Floor) -> bool:
        """What takes most of an excess away needs no leave; what takes little must not be fitted noise."""
        gain = without.cost - with_it.cost
        decisive = floor.is_significant(without.cost) and gain > DECISIVE_SHARE * floor.excess(without.cost)
        return decisive or self._validates(without, with_it)

    def _validates(self, without: Model, with_it: Model) -> bool:
        """One more effect must not make the records worse that no fit has seen, nor stretch a tolerance too far."""
        bound = TOLERATED * SIGMA
        units = (unit_of(self.search.fitter.effects(m.z), np.clip(m.delta, -bound, bound)) for m in (without, with_it))
        before, after = (self.validation.outcome(unit).gap for unit in units)
        return not after > before * (1.0 + WORSE_SHARE)

    def _refined(self, leads: list[Lead], floor: Floor, start: float, end: float) -> list[Model]:
        """Each lead with the simulation in the loop, small sets first; once one explains the log, only close rivals."""
        out: list[Model] = []
        best = math.inf
        start_cost = self.search.nothing.cost
        leads = sorted(leads, key=lambda lead: (len(lead.z), -lead.gain))
        for i, lead in enumerate(leads):
            explained = bool(out) and not floor.is_significant(best)
            if explained and (lead.gain < NEAR_GAIN * leads[0].gain or len(lead.z) > len(out[0].z)):
                continue
            wild = any(not self.library[name].linear for name in lead.z)
            if wild and out and (explained or lead.gain < WILD_GAIN * (start_cost - best)):
                continue  # a wide search costs as much as all the others together
            self.say(f"trying {' + '.join(lead.z)}", start + (end - start) * i / max(1, len(leads)))
            found = self.search.refine(lead, beat=best + floor.mean)
            simpler = [self.search.refine(twin, downhill=True) for twin in self._simpler(found)]
            out += [found, *simpler]
            best = min(best, *(m.own_cost for m in (found, *simpler)))
        self.tried += out
        return out

    def _simpler(self, model: Model) -> list[Lead]:
        """The same with an effect that one of its own holds: a shaft twists with or without play."""
        out = []
        for name, z in model.z.items():
            twin = self.library[name].simpler
            if twin is not None and twin[0] in self.library:
                rest = {other: x for other, x in model.z.items() if other != name}
                out.append(Lead({**rest, twin[0]: z[list(twin[1])]}, 0.0))
        return out

    def _earns(self, without: Model, with_it: Model, floor: Floor) -> bool:
        least = self._least_gain(set(with_it.z) - set(without.z))
        if least == GAIN_MIN:
            least = max(least, SHARE_MIN * floor.excess(without.cost))
        return without.cost - with_it.cost > least and self._all_large(with_it)

    def _least_gain(self, names: set[str]) -> float:
        """A deviation that a tolerance can take up costs no more than its prior: (size over sigma) squared."""
        return GAIN_BEYOND_TOLERANCE if names and all(self.library[n].is_tolerance for n in names) else GAIN_MIN

    def _promises(self, lead: Lead, model: Model, floor: Floor) -> bool:
        """Worth a refinement: while nothing explains the log almost anything is, afterwards only what may be named."""
        if floor.is_significant(model.cost):
            return lead.gain > 0.5 * GAIN_MIN
        large = all(
            self.library[name].magnitude(z) > (0.1 if self.library[name].is_tolerance else 0.6)  # which takes its share
            for name, z in lead.z.items()
        )
        return large and lead.gain > 0.7 * self._least_gain(set(lead.z) - set(model.z))

    def _all_large(self, model: Model) -> bool:
        return all(self.library[name].magnitude(z) > 1.0 for name, z in model.z.items())

    def _stands(self, name: str, gain: float, without: Model, with_it: Model) -> bool:
        """What an effect takes off the cost is enough, also at a second look where it is little."""
        least = self._least_gain({name})
        if gain < least or gain > WEAK_GAIN or self.library[name].is_tolerance:
            return gain >= least
        before, after = self.search.fitter.second_look(without, with_it)
        return before - after > SECOND_SHARE * least

    def _is_far_off(self, model: Model, without: Model) -> bool:
        """What is more is a tolerance so far off that no unit is: its prior says so, however little it costs."""
        more = set(model.z) - set(without.z)
        return all(
            self.library[name].is_tolerance and self.library[name].magnitude(model.z[name]) > FAR_OFF for name in more
        )

    def _drop(self, best: Model, floor: Floor) -> tuple[Model, dict[str, float]]:
        """Take out what is not needed; what each of the rest takes away from the cost."""
        weights: dict[str, float] = {}
        names = list(best.z)
        if not names:
            return best, weights
        if len(names) == 1:
            empty = self.search.fitter.judged(self.search.nothing)
            gain = empty.cost - best.cost
            # under the noise level and tolerances around itself it may be less than it seemed at first
            keep = self._stands(names[0], gain, empty, best) and self._all_large(best)
            return (best, {names[0]: gain}) if keep else (empty, {})
        for name in names:
            rest = {k: z for k, z in best.z.items() if k != name}
            without = self.search.refine(Lead(rest, 0.0), 5, downhill=True)
            if without.cost - best.cost < SURE_GAIN:
                without = min(without, self.search.refine(Lead(rest, 0.0), 5), key=lambda m: m.cost)
            self.tried.append(without)
            weights[name] = without.cost - best.cost
            if not self._stands(name, weights[name], without, best) or not self._all_large(best):
                return self._drop(without, floor)
        return best, weights

    # ---- what is left -----------------------------------------------------------------------------------------------

    def floor(self, model: Model) -> Floor:
        fitter = self.search.fitter
        effects = fitter.effects(model.z)
        random = np.random.default_rng(29)
        deltas = random.normal(0.0, SIGMA, (SOUND_UNITS, len(SIGMA)))
        units = [unit_of(effects, d, 7000 + i, float(random.random())) for i, d in enumerate(deltas)]
        (probes,) = model_features(self.forward, [effects])
        expected = probes.mean(axis=0)
        costs = [fitter.judge.fit(run - expected, fitter.nuisance).cost for run in self.forward.many(units)]
        return Floor(float(np.mean(costs)), float(np.std(costs, ddof=1)))

    def lines(self, model: Model) -> tuple[Line, ...]:
        fitter = self.search.fitter
        effects = fitter.effects(model.z)
        units = [unit_of(effects, model.delta, 50 + i, (i + 0.5) / 6.0) for i in range(6)]
        near = neighbours(self.library, model.z, 8)  # a limit cycle may begin a little beside the place that was found
        units += [unit_of(fitter.effects(z), model.delta, 60 + i, (i + 0.5) / 8.0) for i, z in enumerate(near)]
        return tuple(leftover_lines(self.forward, units))


def _lines_speak(lines: tuple[Line, ...]) -> bool:
    return sum(line.ratio > LINE_RATIO for line in lines) >= LINES_MIN


def alternatives(finding: Finding) -> list[tuple[tuple[str, ...], float]]:
    """Other explanations and how likely they are beside the best one, most likely first."""
    best: dict[frozenset[str], Model] = {}
    for model in finding.tried:
        key = frozenset(model.z)
        if key and (key not in best or model.cost < best[key].cost):
            best[key] = model
    chosen = frozenset(finding.model.z)
    odds = {
        key: math.exp(-max(0.0, model.cost - finding.model.cost) / ALTERNATIVE_COST)
        for key, model in best.items()
        if key != chosen and not key > chosen
    }
    total = 1.0 + sum(odds.values())
    ranked = sorted(odds.items(), key=lambda item: -item[1])
    return [(tuple(best[key].z), weight / total) for key, weight in ranked if weight / total > 1e-3]
