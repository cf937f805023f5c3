"""What is left of the equations turned into terms of the empirical library, together with the effects of the table.

Every family is tried at many shapes on what the effects leave, with all deviations of the unit fitted again; the best
shapes then compete with the effects in the same search for the choice of least cost (`search`), so that what belongs
to an effect goes back to it. Shapes are improved between rounds.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.empirical.term import EmpiricalTerm
from evenspin.weakform.analysis import ZERO_TERM, Explained
from evenspin.weakform.beyond_screen import alone, improved, inflation_of, screen
from evenspin.weakform.beyond_search import Candidate, Search
from evenspin.weakform.fit import Normal, Piece, moved, normal_of, prior_of, pull_of, settled
from evenspin.weakform.model import Point
from evenspin.weakform.screen import left_of
from evenspin.weakform.search import Choice, choices
from evenspin.weakform.terms import Kind, Term

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

ROUNDS = 7
MOST = 5  # effects and terms
AGAIN_FROM = 2.0  # of what noise leaves: the search begins once more, without the effects that were chosen first


@dataclass(frozen=True, slots=True)
class Beyond:
    """`found` has the terms of the library among its named ones; `candidates` are all that competed at last."""

    found: Explained
    terms: dict[str, Candidate]  # by the name of the term, those chosen
    candidates: dict[str, Candidate]
    after_known: Sequence[Sequence[Array]]  # what the equations leave with the best choice of effects alone
    evidence: tuple[EmpiricalTerm, ...] = ()  # the terms that unseen stretches confirm, largest share first
    dropped: tuple[str, ...] = ()  # terms that they do not confirm


@dataclass(frozen=True, slots=True)
class _State:
    """A choice of a round, with what it leaves where it was fitted."""

    score: float
    normal: Normal
    rivals: Sequence[Choice]
    whole: Point
    named: frozenset[str]
    kept: dict[str, Candidate]
    tried: dict[str, Candidate]


def look_beyond(search: Search, say: Callable[[str, float], None], rounds: int = ROUNDS) -> Beyond:
    """The choice of effects and terms of the library that explains the logs best."""
    found = search.found
    named = frozenset(name for name in found.named if found.term(name).kind is Kind.EFFECT)
    point: Point = {term.name: found.point.get(term.name, term.off).copy() for term in search.base}
    best, after_known = _rounds(search, named, point, say, rounds)
    if best is not None and best.score > AGAIN_FROM and named:  # the effects that were chosen first may mislead
        off: Point = {term.name: point[term.name] if _stays(term) else term.off.copy() for term in search.base}
        other, _ = _rounds(search, frozenset(), off, say, rounds)
        best = other if other is not None and other.score < best.score else best
    if best is None:
        return Beyond(found, {}, {}, found.after)
    search.set_terms(best.tried)
    done = _explained(search, best.normal, best.rivals, best.whole, best.named)
    return Beyond(done, best.kept, best.tried, after_known)


def _stays(term: Term) -> bool:
    return term.kind is Kind.UNIT or term.name == ZERO_TERM


def _rounds(
    search: Search, named: frozenset[str], point: Point, say: Callable[[str, float], None], rounds: int
) -> tuple[_State | None, Sequence[Sequence[Array]]]:
    """The best round, and what the equations leave with the best choice of effects alone."""
    kept: dict[str, Candidate] = {}
    normal = search.found.normal
    after_known: Sequence[Sequence[Array]] = search.found.after
    best: _State | None = None
    for number in range(rounds):
        say("searching beyond the table of effects", 0.6 + 0.05 * number)
        terms = search.set_terms(kept)
        pieces = search.gatherer.pieces(point, named)
        prior, toward = prior_of(terms, named), pull_of(terms, point)
        left = left_of(pieces, search.fits, inflation_of(normal, pieces), prior, toward)
        better = [improved(search, left, point, c, name) for name, c in kept.items()]
        fresh = screen(search, left, better)
        if not fresh and number > 0 and all(a == b for a, b in zip(better, kept.values(), strict=True)):
            break
        if named - set(kept):
            fresh += alone(search, pieces, normal, point, kept)
        tried = {search.term(c).name: c for c in (*better, *fresh, *kept.values())}
        if not tried:
            break
        start = _at(search, tried, point)
        normal, rivals = _choose(search, tried, start, named)
        terms, choice = list(search.model.terms), rivals[0]
        whole = settled(terms, start, choice.step, choice.names)
        point = moved(terms, start, choice.step, choice.names)
        if number == 0:
            effects = next((c for c in rivals if not c.names & set(tried)), None)
            if effects is not None:
                without = settled(terms, start, effects.step, effects.names)
                after_known = [search.model.residual(without, log) for log in range(len(search.logs))]
        named = choice.names
        kept = {name: c for name, c in tried.items() if name in choice.names}
        search.fundamentals = [c.shape[0] for c in kept.values() if c.family.name == "angle_line"]
        state = _State(_score(search, whole, len(named)), normal, rivals, whole, named, kept, tried)
        if best is None or state.score < best.score:
            best = state
        if not kept:
            break
    return best, after_known


def _score(search: Search, whole: Point, count: int) -> float:
    """What is left of the equations where they were fitted, over noise, with a price for each name."""
    total, number, k = 0.0, 0, 0
    for log in range(len(search.logs)):
        parts = search.model.residual(whole, log)
        for part, floor in zip(parts, search.floors[log], strict=True):
            total += float(np.mean(part[search.fits[k]] ** 2)) / floor**2
            number, k = number + 1, k + 1
    return float(np.sqrt(total / max(number, 1))) * (1.0 + PRICE_OF_NAME * count)


PRICE_OF_NAME = 0.02


def again_without(search: Search, beyond: Beyond, dropped: Collection[str]) -> Beyond:
    """The choice once more, with fewer terms of the library."""
    kept = {name: c for name, c in beyond.terms.items() if name not in dropped}
    if not kept:
        return replace(beyond, found=search.found, terms={}, evidence=())
    named = frozenset(name for name in beyond.found.named if name not in dropped)
    whole: Point = {name: beyond.found.point[name] for name in beyond.found.point if name not in dropped}
    point = _at(search, kept, whole)
    for _ in range(AGAIN):
        normal, rivals = _choose(search, kept, point, named)
        best = rivals[0]
        whole = settled(search.model.terms, point, best.step, best.names)
        point = moved(search.model.terms, point, best.step, best.names)
        named = best.names
    still = {name: c for name, c in kept.items() if name in named}
    done = _explained(search, normal, rivals, whole, named)
    return replace(beyond, found=done, terms=still, evidence=tuple(e for e in beyond.evidence if e.name in still))


def _at(search: Search, tried: Mapping[str, Candidate], point: Point) -> Point:
    return {term.name: point.get(term.name, term.off.copy()) for term in search.set_terms(tried)}


def _choose(
    search: Search, tried: Mapping[str, Candidate], point: Point, named: frozenset[str]
) -> tuple[Normal, Sequence[Choice]]:
    terms = search.model.terms
    pieces = [_fit_rows(each, fit) for each, fit in zip(search.gatherer.pieces(point, named), search.fits, strict=True)]
    free = {t.name for t in terms if t.kind is Kind.EFFECT and not _is_later_variant(terms, t)} | set(tried)
    normal = normal_of(pieces, prior_of(terms, free, REACH), pull_of(terms, point))
    return normal, choices(terms, normal, point, search.edges, MOST)


def _explained(
    search: Search, normal: Normal, rivals: Sequence[Choice], whole: Point, named: frozenset[str]
) -> Explained:
    after = [search.model.residual(whole, log) for log in range(len(search.logs))]
    model = replace(search.model, terms=list(search.model.terms))
    names = tuple(sorted(named))
    return replace(search.found, model=model, named=names, point=whole, normal=normal, rivals=rivals, after=after)


AGAIN = 2
REACH = 0.2  # of what a term may be: the fit with all of them is for the scatter alone


def _is_later_variant(terms: Sequence[Term], term: Term) -> bool:
    return term.variant and next(t.name for t in terms if t.effect == term.effect) != term.name


def _fit_rows(piece: Piece, fit: Flags) -> Piece:
    return Piece(piece.r[fit], piece.x[fit], piece.stretch[fit], piece.noise, piece.pull, piece.floor, piece.kind)
