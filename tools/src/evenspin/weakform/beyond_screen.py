"""Which terms of the library would take off most of what is left, and at which shape."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.empirical.library import FAMILIES, Family, Shape, can_show, family_of
from evenspin.empirical.lines import frequency_spectrum, order_spectra, peaks
from evenspin.weakform.analysis import cogging_orders
from evenspin.weakform.beyond_search import Candidate, Search
from evenspin.weakform.fit import Normal, Piece, prior_of, pull_of
from evenspin.weakform.model import Point
from evenspin.weakform.screen import Left, left_of

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

WEAK = 0.25  # of the cost that a line over the angle takes off: a frequency below that is the line at a held speed
STANDS_OUT = 45.0  # cost that a term has to take off to become a candidate
CANDIDATES = 8
LINES = 2  # of each spectrum
LEAST_HZ = {"torque_frequency": 1.0, "supply_frequency": 5.0}  # slower is a change with the time
SPEED_POWERS = (0.0, 1.0, 2.0)  # of the amplitude of a line
NEAR_KNOWN = 2.5  # resolutions: as near to a known order it is that one


def inflation_of(normal: Normal, pieces: Sequence[Piece]) -> list[float]:
    return list(normal.inflation) if len(normal.inflation) == len(pieces) else [2.0] * len(pieces)


def screen(search: Search, left: Left, kept: Sequence[Candidate]) -> list[Candidate]:
    """The best shape of each family on what is left, strongest first."""
    found: list[Candidate] = []
    have = {c.family.name for c in kept}
    for family in FAMILIES:
        if not all(can_show(family, search.rows(e)) for e in search.logs):
            continue
        for log in range(len(search.logs)) if _of_one_log(family, search) else (None,):
            e = search.logs[log or 0]
            shapes = family.starts(search.rows(e))
            if not shapes or (family.name in have and family.name != "position_bump"):
                continue
            gain, shape = max((left.gain(search.columns(family, each, log))[0], each) for each in shapes)
            if gain > STANDS_OUT:
                gain, shape = _polished(search, left, family, shape, log, gain)
                found.append(Candidate(family, shape, log, gain))
    lines = _orders(search, left)
    strongest = max((c.gain for c in (*lines, *kept) if c.family.name == "angle_line"), default=0.0)
    found += lines
    found += [c for c in _frequencies(search, left) if c.gain > WEAK * strongest]
    return sorted(found, key=lambda c: -c.gain)[:CANDIDATES]


def _of_one_log(family: Family, search: Search) -> bool:
    return len(search.logs) > 1 and family.depends_on in ("time", "position", "frequency")


def _orders(search: Search, left: Left) -> list[Candidate]:
    p = search.logs[0].plant["pole_pairs"]
    known = [1.0, 2.0, p, 2.0 * p, 6.0 * p, *cogging_orders(search.scale)]
    family = family_of("angle_line")
    best: dict[float, Candidate] = {}
    for (log, k, w), r, fit in zip(search.windows(), left.r, search.fits, strict=True):
        e = search.logs[log]
        if k > 1 or not e.signals.shows_orders:
            continue
        theta, speed = (w.at_centre(x)[fit] for x in (e.signals.theta_m_rad, e.signals.speed_rad_s))
        turns = float(np.ptp(theta)) / (2.0 * np.pi)
        fixed = order_spectra(r[fit], theta, speed, w.bump.transform, (0.0, 2.0))
        turning = order_spectra(r[fit] * np.sign(speed), theta, speed, w.bump.transform, (0.0, 2.0))
        orders = fixed[0]
        for gain in (*fixed[1], *turning[1]):
            if not len(orders):
                continue
            reach = max(NEAR_KNOWN / turns, 0.03)
            for order in known:
                gain[np.abs(orders - order) < reach] = 0.0
            for order, _ in peaks(orders, gain, 4.0 / turns, LINES, STANDS_OUT):
                shapes: list[Shape] = [(order, m, over) for m in SPEED_POWERS for over in (0.0, 1.0)]
                cost, shape = max((left.gain(search.columns(family, shape, None))[0], shape) for shape in shapes)
                cost, shape = _polished(search, left, family, shape, None, cost, 0.6 / turns)
                near = [o for o in best if abs(o - shape[0]) < 2.0 / turns]
                if cost > STANDS_OUT and all(best[o].gain < cost for o in near):
                    for o in near:
                        del best[o]
                    best[shape[0]] = Candidate(family, shape, None, cost)
    return list(best.values())


def _frequencies(search: Search, left: Left) -> list[Candidate]:
    found: list[Candidate] = []
    if len(search.logs) > 1:
        return found
    e = search.logs[0]
    span_s = search.rows(e).span_s
    for (_, k, w), r, fit in zip(search.windows(), left.r, search.fits, strict=True):
        t_s = w.at_centre(e.signals.t_s)
        even = np.where(fit, r, 0.0)
        if k < 2:
            family, size = family_of("torque_frequency"), fit.astype(float)
        elif k == 3 and e.signals.vq_v is not None:  # the q axis has most of the voltage
            family, size = family_of("supply_frequency"), fit * w.at_centre(e.signals.vq_v)
        else:
            continue
        hz, gain = frequency_spectrum(even, t_s, w.bump.transform, size)
        gain[hz < LEAST_HZ[family.name]] = 0.0
        for at, _ in peaks(hz, gain, 4.0 / span_s, LINES, STANDS_OUT):
            cost = left.gain(search.columns(family, (at,), None))[0]
            cost, shape = _polished(search, left, family, (at,), None, cost, 0.6 / span_s)
            if cost > STANDS_OUT and not any(
                c.family is family and abs(c.shape[0] - shape[0]) < 2.0 / span_s for c in found
            ):
                found.append(Candidate(family, shape, None, cost))
    return found


def _polished(
    search: Search, left: Left, family: Family, shape: Shape, log: int | None, gain: float, step: float = 0.0
) -> tuple[float, Shape]:
    """The shape numbers improved one after the other. `step`: of the first one, absolute; 0: ratios."""
    from scipy.optimize import minimize_scalar

    for k in range(len(shape)):
        if family.shape[k] in ("speed_exponent", "turns_over"):
            continue
        absolute = step if step > 0.0 else 0.12 * _range(search, log) if family.shape[k] == "centre_rad" else 0.0

        def shifted(x: float, k: int = k, absolute: float = absolute, shape: Shape = shape) -> Shape:
            value = shape[k] + x * absolute if absolute > 0.0 else shape[k] * math.exp(x)
            return (*shape[:k], value, *shape[k + 1 :])

        def cost(x: float, shifted: Callable[[float], Shape] = shifted) -> float:
            return -left.gain(search.columns(family, shifted(x), log))[0]

        half = 1.0 if absolute > 0.0 else 0.5
        best = minimize_scalar(cost, bounds=(-half, half), method="bounded", options={"xatol": 0.01, "maxiter": 14})
        if -best.fun > gain:
            shape, gain = shifted(float(best.x)), -float(best.fun)
    return gain, shape


def _range(search: Search, log: int | None) -> float:
    return float(np.ptp(search.logs[log or 0].signals.theta_m_rad))


def alone(
    search: Search, pieces: Sequence[Piece], normal: Normal, point: Point, kept: Mapping[str, Candidate]
) -> list[Candidate]:
    """The chosen terms with the shapes that are best when the effects beside them are no more than tolerances."""
    terms, toward = search.model.terms, pull_of(search.model.terms, point)
    found: list[Candidate] = []
    for name, c in kept.items():
        if c.family.depends_on not in SMOOTH or not c.shape:
            continue
        prior = prior_of(terms, set(kept) - {name})
        left = left_of(pieces, search.fits, inflation_of(normal, pieces), prior, toward)
        shapes = [*c.family.starts(search.rows(search.logs[c.log or 0])), c.shape]
        gain, shape = max((left.gain(search.columns(c.family, each, c.log))[0], each) for each in shapes)
        gain, shape = _polished(search, left, c.family, shape, c.log, gain)
        found.append(Candidate(c.family, shape, c.log, gain))
    return [c for c in found if c not in kept.values()]


SMOOTH = ("speed", "time", "reversal")  # what effects of the table may stand for


def improved(search: Search, left: Left, point: Point, c: Candidate, name: str) -> Candidate:
    """A chosen term with its shape improved: first what it took away is put back."""
    if not c.shape:
        return c
    at = 0
    for term in search.model.terms:
        if term.name == name:
            break
        at += len(term)
    own = slice(at, at + len(point[name]))
    size = point[name] + left.step[own]
    without = left.without(own, size)
    turns, span_s = _range(search, c.log) / (2.0 * np.pi), search.rows(search.logs[c.log or 0]).span_s
    step = {"order": 0.3 / turns, "frequency_hz": 0.3 / span_s}.get(c.family.shape[0], 0.0)
    gain = without.gain(search.columns(c.family, c.shape, c.log))[0]
    better, shape = _polished(search, without, c.family, c.shape, c.log, gain, step)
    return Candidate(c.family, shape, c.log, better) if better > gain + IMPROVES else c


IMPROVES = 1.0  # cost
