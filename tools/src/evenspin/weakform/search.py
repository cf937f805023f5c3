"""Which terms are named: the choice of least cost, over all pairs and a beam of larger choices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from evenspin.weakform.fit import Normal, Priors, cost_of
from evenspin.weakform.terms import SHAFT, Kind, Term

Array = NDArray[np.float64]

PRICE = 22.0  # of a named term: as much cost as 4.7 standard deviations of one that is held
PRICE_FOREIGN = 28.0
PER_COORDINATE = 3.0
MOST_NAMED = 4
BEAM = 12
SHAFT_PARTS = 2  # of a residual are torques


@dataclass(frozen=True, slots=True)
class Choice:
    names: frozenset[str]
    cost: float  # with the price of each name
    step: Array


@dataclass(frozen=True, slots=True)
class Edges:
    """What a term that acts on the winding has to change, rms, in the torque or in a voltage."""

    torque_nm: float
    volts: float


def choices(
    terms: Sequence[Term], normal: Normal, point: Mapping[str, Array], edges: Edges, most: int = MOST_NAMED
) -> list[Choice]:
    """The best choices, best first, of at most @p most. Each named term has its least size; effects of one name exclude
    each other."""
    toward = np.concatenate([term.off - point[term.name] for term in terms])
    low = np.concatenate([np.where(term.details, -np.inf, term.low) - point[term.name] for term in terms])
    by_name = {term.name: term for term in terms}
    candidates = [term.name for term in terms if term.kind is not Kind.UNIT]
    lowest = {name: np.where(by_name[name].details, -np.inf, by_name[name].low - 1e-12) for name in candidates}
    highest = {name: by_name[name].high + np.where(by_name[name].details, np.inf, 0.0) for name in candidates}
    price_of = {
        name: (PRICE_FOREIGN if by_name[name].kind is Kind.FOREIGN else PRICE)
        + PER_COORDINATE * (np.sum(~by_name[name].details) - 1)
        for name in candidates
    }
    priors = Priors(terms)
    known: dict[frozenset[str], Choice | None] = {}
    place, at = {}, 0
    for term in terms:
        place[term.name] = slice(at, at + len(term))
        at += len(term)

    gathered: dict[str, list[float]] = {}  # of what repeats with the angle

    def shows(name: str, z: Array) -> bool:
        """Whether what a term changes is large enough to be seen, rms."""
        if by_name[name].over_angle and name not in gathered:
            gathered[name] = _gathered(normal, place[name], z)
        times = gathered.get(name, [1.0] * len(normal.grams))
        for gram, kind, more in zip(normal.grams, normal.kinds, times, strict=True):
            edge = edges.torque_nm if kind < SHAFT_PARTS else edges.volts
            if more * float(z @ gram[place[name], place[name]] @ z) > (by_name[name].edge * edge) ** 2:
                return True
        return False

    def tried(names: frozenset[str]) -> Choice | None:
        if names in known:
            return known[names]
        known[names] = None
        effects = [by_name[name].effect or name for name in names]
        if len(set(effects)) < len(effects):
            return None
        cost, step = cost_of(normal, priors.of(names), toward, low)
        for name in names:
            term = by_name[name]
            z = point[name] + step[place[name]]
            if (z < lowest[name]).any() or (z > highest[name]).any():
                return None
            if term.effect == SHAFT and np.any(z > term.high):  # so damped is noise of the angle, or a gap
                return None
            if term.least(np.clip(z, term.low, term.high)) < 1.0:
                return None
            if not term.shaft_only and not shows(name, z - term.off):
                return None
        price = sum(price_of[name] for name in names)
        known[names] = Choice(names, cost + float(price), step)
        return known[names]

    found = [tried(frozenset())]
    found += [tried(frozenset((name,))) for name in candidates]
    found += [tried(frozenset(pair)) for pair in combinations(candidates, 2)]
    for size in range(3, most + 1):
        best = sorted((c for c in known.values() if c is not None and len(c.names) == size - 1), key=lambda c: c.cost)[
            :BEAM
        ]
        for choice in best:
            for name in candidates:
                if name not in choice.names:
                    found.append(tried(choice.names | {name}))
    return sorted((c for c in known.values() if c is not None), key=lambda c: c.cost)


def _gathered(normal: Normal, place: slice, z: Array) -> list[float]:
    """Per piece, how much larger the square of a change is where it acts than over all windows: there each window has
    the weight of its own square. At high speeds windows average away what repeats with the angle, so that its rms over
    a log hangs on how long that stays there."""
    found = []
    for x in normal.columns:
        square = (x[:, place] @ z) ** 2
        total = float(np.sum(square))
        found.append(len(square) * float(square @ square) / total**2 if total > 0.0 else 1.0)
    return found
