"""Terms beyond the table held against stretches that no fit saw: how much each takes off there, and what else would.

A term stays when it takes off more than chance on those stretches: the cost is compared block by block with that of a
fit without the term, in which every other term could take its place; blocks are long against what is correlated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from evenspin.empirical.library import FAMILIES, can_show, travel_of
from evenspin.empirical.term import EmpiricalTerm, LookAlike
from evenspin.weakform.beyond import Beyond, again_without
from evenspin.weakform.beyond_search import Candidate, Search
from evenspin.weakform.curves import curve_of
from evenspin.weakform.fit import HUBER, prior_of, pull_of
from evenspin.weakform.screen import Left, even_solve, left_of

Array = NDArray[np.float64]

BLOCK_S = 0.25
LEAST_T = 3.5  # standard errors by which the cost of unseen blocks falls
LEAST_GAP = 0.15  # squared, over that of noise, summed over the equations
LEAST_SHARE = 0.02  # of the squared gap above noise
CHI2_95 = 3.84
NARROW = 2.0  # times the chi-square of a profile: what is left is not white
MODEL_SHARE = 0.01  # of an exponent or a time constant
MODEL_MISFIT = 0.03  # of what the term does, rms, by which two honest models of one cause differ
MENTIONED = 3
CLEAR = 6.0  # cost of a block that is no chance
LEAST_CLEAR = 6
SIGN_TEST = 1.45  # 3.5 for six blocks of which none says the opposite: a chance of 1 in 64, beside all other tests


def confirmed(search: Search, beyond: Beyond) -> Beyond:
    """Without the terms that unseen stretches do not confirm; `evidence` has what is left of them."""
    if not beyond.terms:
        return beyond
    left = full_fit(search, beyond, set(beyond.terms))
    found: list[EmpiricalTerm] = []
    for name, c in beyond.terms.items():
        without = full_fit(search, beyond, set(beyond.terms) - {name})
        t, share = unseen(search, left, without)
        if t >= LEAST_T and share >= LEAST_SHARE:
            found.append(_described(search, beyond, left, name, c, t, share))
    found.sort(key=lambda term: -term.share)
    dropped = tuple(sorted(set(beyond.terms) - {term.name for term in found}))
    beyond = replace(beyond, evidence=tuple(found), dropped=dropped)
    return again_without(search, beyond, dropped) if dropped else beyond


def full_fit(search: Search, beyond: Beyond, terms: set[str]) -> Left:
    """The best fit with the named effects and these terms; others of the library are off."""
    found = beyond.found
    search.set_terms(beyond.terms)
    point = {term.name: found.point[term.name] for term in search.model.terms}
    pieces = search.gatherer.pieces(point, found.named)
    effects = {name for name in found.named if not name.startswith("foreign: ")}
    prior = prior_of(search.model.terms, effects | terms)
    inflation = [1.0] * len(pieces)
    return left_of(pieces, search.fits, inflation, prior, pull_of(search.model.terms, point))


def unseen(search: Search, left: Left, without: Left) -> tuple[float, float]:
    """Standard errors by which the term lowers the cost of unseen blocks, and its share of the squared gap."""
    blocks: dict[tuple[int, int], float] = {}
    gained, gap = 0.0, 0.0
    for (log, _, w), piece, fit, a, b, sigma in zip(
        search.windows(), left.pieces, search.fits, left.r, without.r, left.sigma, strict=True
    ):
        rows = ~fit
        number = (w.centre[w.used][rows] * w.bump.period_s // BLOCK_S).astype(np.int64)
        less = _cost(b[rows] / sigma) - _cost(a[rows] / sigma)
        for block, value in zip(number, less, strict=True):
            key = (log, int(block))
            blocks[key] = blocks.get(key, 0.0) + float(value)
        if np.any(rows):
            gained += (float(np.mean(b[rows] ** 2)) - float(np.mean(a[rows] ** 2))) / piece.floor**2
            gap += max(float(np.mean(b[rows] ** 2)) / piece.floor**2 - 1.0, 0.0)
    values = np.array(list(blocks.values()))
    if len(values) < 4:
        return 0.0, 0.0
    spread = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    if gap < LEAST_GAP:  # without the term there is no more than noise
        return 0.0, 0.0
    t = float(np.mean(values)) / max(spread, 1e-300)
    share = float(np.clip(gained / max(gap, 1e-300), 0.0, 1.0))
    up, down = int(np.count_nonzero(values > CLEAR)), int(np.count_nonzero(values < -CLEAR))
    if (
        up + down >= LEAST_CLEAR and float(np.sum(values)) > 0.0
    ):  # a cause that shows now and then, such as after reversals
        t = max(t, (up - down) / math.sqrt(up + down) * SIGN_TEST)
    return t, share


def _cost(x: Array) -> Array:
    size = np.abs(x)
    return np.where(size < HUBER, size**2, 2.0 * HUBER * size - HUBER**2)


def _place(search: Search, name: str) -> slice:
    at = 0
    for term in search.model.terms:
        if term.name == name:
            return slice(at, at + len(term))
        at += len(term)
    raise KeyError(name)


def _described(
    search: Search, beyond: Beyond, left: Left, name: str, c: Candidate, t: float, share: float
) -> EmpiricalTerm:
    own = _place(search, name)
    size: Array = np.array(beyond.found.point[name] + left.step[own], dtype=np.float64)
    without = left.without(own, size)
    rows = search.rows(search.logs[c.log or 0])
    covariance: Array = np.array(NARROW * even_solve(left.h, np.eye(len(left.h)))[own, own], dtype=np.float64)
    travel = travel_of(rows)
    facts = {
        "top_rad_s": search.found.top_rad_s,
        "rated_nm": search.scale.rated_torque_nm,
        "rated_a": search.scale.rated_current_a,
        "inertia_kgm2": float(search.logs[c.log or 0].plant["inertia_kgm2"]),
        "span_s": rows.span_s,
        "start_s": rows.start_s,
        "travel_rad": max(travel[1] - travel[0], 1e-9),
        "middle_rad": 0.5 * (travel[0] + travel[1]),
    }
    speed = np.abs(rows.speed_rad_s)
    moving = speed[speed > rows.rest_rad_s]
    low, high = (float(x) for x in np.percentile(moving, (2.0, 99.5)))
    term = EmpiricalTerm(
        name,
        c.family,
        tuple(float(x) for x in c.shape),
        size,
        covariance,
        _shape_halves(search, without, c),
        t,
        share,
        (low, high),
        _look_alikes(search, without, c),
        search.logs[c.log].signals.name if c.log is not None and len(search.logs) > 1 else "",
        facts,
    )
    return replace(term, curve=curve_of(term, rows, search.logs[c.log or 0], _rows_of_log(search, without, c.log or 0)))


def _rows_of_log(search: Search, without: Left, log: int) -> list[Array]:
    return [r for (number, _, _), r in zip(search.windows(), without.r, strict=True) if number == log]


def _shape_halves(search: Search, without: Left, c: Candidate) -> tuple[float, ...]:
    """95 %, from how the gain falls beside the best shape.

    A shape that changes what the term does by less than honest models differ is as good: the square of that share of
    the gain. An order or a frequency, which a whole log counts, is as sure as its noise.
    """
    halves = []
    turns = search.logs[c.log or 0].signals.theta_m_rad
    step_of = {
        "order": 0.05 * 2.0 * np.pi / float(np.ptp(turns)),
        "frequency_hz": 0.05 / search.rows(search.logs[0]).span_s,
    }
    for k, kind in enumerate(c.family.shape):
        if kind in ("speed_exponent", "turns_over"):
            halves.append(0.0)
            continue
        step = step_of.get(kind, 0.03 * max(abs(c.shape[k]), 1e-6))
        if kind == "centre_rad":
            step = 0.1 * c.shape[1]

        def gain(x: float, k: int = k) -> float:
            shape = (*c.shape[:k], c.shape[k] + x, *c.shape[k + 1 :])
            return without.gain(search.columns(c.family, shape, c.log))[0]

        bend = max(2.0 * gain(0.0) - gain(step) - gain(-step), 1e-9) / step**2
        half = math.sqrt(2.0 * CHI2_95 * NARROW / bend)
        if kind not in step_of:
            misfit = math.sqrt(2.0 * MODEL_MISFIT**2 * max(gain(0.0), 0.0) / bend)
            half = math.hypot(half, misfit, MODEL_SHARE * abs(c.shape[k]))
        halves.append(half)
    return tuple(halves)


def _look_alikes(search: Search, without: Left, c: Candidate) -> tuple[LookAlike, ...]:
    best = without.gain(search.columns(c.family, c.shape, c.log))[0]
    found = []
    for family in FAMILIES:
        if family.name == c.family.name or not all(can_show(family, search.rows(e)) for e in search.logs):
            continue
        log = c.log if family.depends_on in ("time", "position", "frequency") else None
        shapes: Sequence[tuple[float, ...]] = family.starts(search.rows(search.logs[log or 0]))
        gains = [without.gain(search.columns(family, shape, log))[0] for shape in shapes]
        if gains:
            found.append(LookAlike(family.name, best - max(gains)))
    found = [each for each in found if each.behind < 0.5 * best]
    return tuple(sorted(found, key=lambda each: each.behind)[:MENTIONED])
