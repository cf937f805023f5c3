"""What an effect has to show before it is tried, kept and named. The numbers stand in thresholds.py."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from evenspin.effects import Hypothesis
from evenspin.gap.candidate import Candidate, Model
from evenspin.gap.thresholds_effects import (
    BORROWED_SHARE,
    DECISIVE_SHARE,
    EXCESS_SHARE,
    EXCESS_SIGMAS,
    FAR_OFF,
    GAIN_BEYOND_TOLERANCE,
    GAIN_MIN,
    IMPERFECT_SHARE,
    PROMISE_BORROWED,
    PROMISE_EXPLAINED,
    PROMISE_SIZE,
    PROMISE_SIZE_TOLERANCE,
    PROMISE_UNEXPLAINED,
    SECOND_SHARE,
    SHARE_MIN,
    UNKNOWN_SHARE,
    WEAK_GAIN,
)
from evenspin.log.tolerance import TOLERANCE_EFFECTS


@dataclass(frozen=True, slots=True)
class ExpectedCost:
    """The cost expected of a correct model: over simulated healthy units."""

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
class Acceptance:
    """The rules for the effects of a library."""

    library: Mapping[str, Hypothesis]
    tolerated: Collection[str] = TOLERANCE_EFFECTS  # effects that are a tolerance, only larger

    def least_gain(self, names: Collection[str]) -> float:
        """A deviation that a tolerance can take up costs no more than its prior: (size over sigma) squared."""
        return GAIN_BEYOND_TOLERANCE if names and all(n in self.tolerated for n in names) else GAIN_MIN

    def all_large(self, model: Model) -> bool:
        """Every effect is larger than what tolerance and format call no effect."""
        return all(self.library[name].magnitude(z) > 1.0 for name, z in model.z.items())

    def promises(self, candidate: Candidate, model: Model, expected: ExpectedCost) -> bool:
        """Worth a refinement: while nothing explains the log almost anything is, afterwards only what may be named."""
        if expected.is_significant(model.cost):
            return candidate.gain > PROMISE_UNEXPLAINED * GAIN_MIN
        large = all(
            self.library[name].magnitude(z) > (PROMISE_SIZE_TOLERANCE if name in self.tolerated else PROMISE_SIZE)
            for name, z in candidate.z.items()
        )
        return large and candidate.gain > PROMISE_EXPLAINED * self.least_gain(set(candidate.z) - set(model.z))

    def worth_simulating(self, possible: Sequence[Candidate], unexplained: bool) -> frozenset[str]:
        """Effects whose signature beside an explanation is worth its simulations, by signatures that are not those.

        While much is left, what promises a fair part of the best; afterwards all that may count. Sizes are not asked.
        """
        most = max((candidate.gain for candidate in possible), default=0.0)
        names: set[str] = set()
        for candidate in possible:
            least = PROMISE_EXPLAINED * self.least_gain(candidate.new)
            if candidate.gain > (BORROWED_SHARE * most if unexplained else PROMISE_BORROWED * least):
                names |= candidate.new
        return frozenset(names)

    def earns(self, without: Model, with_it: Model, expected: ExpectedCost) -> bool:
        """What is new explains enough of what was left, and is large enough."""
        least = self.least_gain(set(with_it.z) - set(without.z))
        if least == GAIN_MIN:
            least = max(least, SHARE_MIN * expected.excess(without.cost))
        return without.cost - with_it.cost > least and self.all_large(with_it)

    def is_decisive(self, without: Model, with_it: Model, expected: ExpectedCost) -> bool:
        """What takes most of an excess away needs no validation record: where a loop rings, none could confirm it."""
        gain = without.cost - with_it.cost
        return expected.is_significant(without.cost) and gain > DECISIVE_SHARE * expected.excess(without.cost)

    def is_remainder(self, without: Model, with_it: Model, explained: float) -> bool:
        """What is new is no more than what the imperfect model of a large effect leaves; `explained`: its gain."""
        return without.cost - with_it.cost < IMPERFECT_SHARE * explained and not self.is_far_off(with_it, without)

    def is_far_off(self, model: Model, without: Model) -> bool:
        """What is new is a tolerance so far off that no unit is: its prior says so, however little it costs."""
        more = set(model.z) - set(without.z)
        return all(name in self.tolerated and self.library[name].magnitude(model.z[name]) > FAR_OFF for name in more)

    def needs_recheck(self, name: str, gain: float) -> bool:
        """The gain is enough, but so small that a search may have picked it by chance."""
        return self.least_gain({name}) <= gain <= WEAK_GAIN and name not in self.tolerated

    def holds(self, name: str, gain: float) -> bool:
        return gain >= self.least_gain({name})

    def holds_on_recheck(self, name: str, gain: float) -> bool:
        """`gain`: in simulations that no fit has seen."""
        return gain > SECOND_SHARE * self.least_gain({name})

    def simpler(self, model: Model) -> list[Candidate]:
        """Candidates without the part of an effect that makes it another one: a twisting shaft without its backlash."""
        out = []
        for name, z in model.z.items():
            twin = self.library[name].simpler
            if twin is not None and twin[0] in self.library:
                others = {other: x for other, x in model.z.items() if other != name}
                out.append(Candidate({**others, twin[0]: z[list(twin[1])]}, 0.0))
        return out
