"""Which records and features speak for each name: what its absence would add to the residual, and where."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.candidate import Model
from evenspin.gap.evidence import robust_cost
from evenspin.gap.finding import Finding
from evenspin.gap.where import Subject

Array = NDArray[np.float64]
SHOWN = 4  # groups of features for each name


@dataclass(frozen=True, slots=True)
class Support:
    """A group of features that a name makes fit."""

    record: str
    signal: str
    what: str  # mean level, angle order, after a step...
    share: float  # of all that speaks for the name
    without: float  # rms residual in standard deviations of healthy units
    with_it: float


def support_of(finding: Finding, name: str, nothing: Array, where: Sequence[Subject]) -> tuple[Support, ...]:
    """The groups of features that the name improves most; `nothing`: residual of the machine without any effect."""
    without = _without(finding, name, nothing)
    if without is None:
        return ()
    groups: dict[tuple[str, str, str], list[int]] = defaultdict(list)
    for i, subject in enumerate(where):
        groups[(subject.key.record, subject.key.signal, subject.what)].append(i)
    after = finding.model.residual
    gains = {key: robust_cost(without[rows]) - robust_cost(after[rows]) for key, rows in groups.items()}
    total = sum(gain for gain in gains.values() if gain > 0.0) or 1.0
    best = sorted((key for key in gains if gains[key] > 0.0), key=lambda key: -gains[key])[:SHOWN]
    return tuple(
        Support(*key, gains[key] / total, _rms(without[groups[key]]), _rms(after[groups[key]])) for key in best
    )


def _without(finding: Finding, name: str, nothing: Array) -> Array | None:
    """Residual of the best model that has all of the explanation but this name; None where none was fitted."""
    others = set(finding.model.z) - {name}
    fitted: list[Model] = [model for model in finding.tried if set(model.z) == others]
    if fitted:
        return fitted[-1].residual  # the last was judged by the noise of the explanation
    return None if others else nothing


def _rms(residual: Array) -> float:
    return math.sqrt(float(np.mean(residual**2)))
