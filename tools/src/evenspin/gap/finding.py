"""What an investigation found: the explanation, what else was tried, and what is left."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from evenspin.gap.acceptance import ExpectedCost
from evenspin.gap.candidate import Model
from evenspin.gap.leftover import Line
from evenspin.gap.periodic import PeriodicLine
from evenspin.gap.thresholds_effects import ALTERNATIVE_COST
from evenspin.gap.thresholds_evidence import ALTERNATIVE_LEAST


@dataclass(frozen=True, slots=True)
class Finding:
    model: Model  # best explanation, named or not
    named: tuple[str, ...]  # strongest first; may be empty
    unknown: bool  # something is left that no known effect explains, beside what is named
    before: float  # cost of the nominal machine
    expected_cost: ExpectedCost
    lines: tuple[Line, ...]
    tried: tuple[Model, ...]
    steps: tuple[Model, ...] = ()  # nothing, then one effect more each: how it was found
    weights: dict[str, float] = field(default_factory=dict)  # cost that each named effect takes away
    simulations: int = 0
    size_spread: Mapping[str, float] = field(default_factory=dict)  # of each effect over the log
    changes: tuple[str, ...] = ()  # effects whose size is another in parts of the log, so that they explain nothing
    periodic: tuple[PeriodicLine, ...] = ()  # taken off the log before it was searched


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
    return [(tuple(best[key].z), weight / total) for key, weight in ranked if weight / total > ALTERNATIVE_LEAST]
