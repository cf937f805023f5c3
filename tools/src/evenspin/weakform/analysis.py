"""From logs to the terms that explain them: weak equations, choice of names, and what is left on unseen stretches."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import Scale, hypotheses
from evenspin.effects.equations import Acting
from evenspin.weakform.answer import answer_term, late_current
from evenspin.weakform.equations import Equations
from evenspin.weakform.fit import Gatherer, Normal, Piece, moved, normal_of, prior_of, pull_of, settled
from evenspin.weakform.foreign import foreign_terms, frequency_term, order_term
from evenspin.weakform.lines import foreign_frequencies, foreign_orders
from evenspin.weakform.model import ANSWER, CURRENT_LATE, LATE, LD, LQ, TURNED, ZERO, Model, Point
from evenspin.weakform.screen import left_of
from evenspin.weakform.search import Choice, Edges, choices
from evenspin.weakform.shaft import shaft_candidates
from evenspin.weakform.signals import SLOW_S, Signals
from evenspin.weakform.terms import NUMBER_OF, OPEN, SHAFT, Kind, Sizes, Term, effect_terms, opened, unit_term
from evenspin.weakform.tolerances import HELD, Tolerances
from evenspin.weakform.unseen import foreign_is_seen, shaft_is_seen
from evenspin.weakform.windows import Bump, Windows

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SHAFT_S, FINE_S, WINDING_S = 12e-3, 3e-3, 4e-3  # half widths
STRETCH_S = 1.0
UNSEEN = 3  # every third stretch validates
REST_SHARE = 0.05  # of a window that may stand still
ROUNDS = 8
RESTS = 0.5  # of its tolerance: a named coordinate that moves less has arrived
ZERO_TERM, D_AXIS = "encoder_offset", 2
ZERO_MOST, ZERO_TRIALS, ZERO_HALVINGS = 1.2, 13, 4  # rad: to 0.0125 of it
FAST = ("stribeck_friction", "inductance_saturation", "dead_time")  # what slow rows average over
REACH = 0.2  # of what a named term may be: the fit with all of them is for the scatter alone
MOST_LEFT_OUT = 8  # causes of unknown kind, one after the other
LATE_PERIODS = 1.5  # from a sample to the middle of the voltage that it leads to
ORDER_NM = 0.006  # of the rated torque: the least line of unknown cause


@dataclass(frozen=True, slots=True)
class Recording:
    """A log, with the windows in which each equation is judged."""

    signals: Signals
    equations: Equations
    unseen: tuple[Flags, ...]  # per part of a residual, of the windows in use
    stretch: tuple[NDArray[np.int64], ...]


@dataclass(frozen=True, slots=True)
class Explained:
    """The terms chosen, at their point; `rivals` are the choices, best first."""

    model: Model
    recordings: Sequence[Recording]
    scale: Scale
    tolerances: Tolerances
    named: tuple[str, ...]
    point: Point
    normal: Normal
    rivals: Sequence[Choice]
    before: Sequence[Sequence[Array]]  # per log and equation, of all windows in use
    after: Sequence[Sequence[Array]]
    top_rad_s: float
    lines: Sequence[str] = field(default_factory=tuple)

    def term(self, name: str) -> Term:
        return next(term for term in self.model.terms if term.name == name)

    @property
    def effects(self) -> list[Acting]:
        """The named effects of the table with their parameters."""
        found: list[Acting] = []
        for name in self.named:
            term = self.term(name)
            if term.hypothesis is not None:
                found.append((term.effect, term.hypothesis.to_params(self.point[name])))
        return found

    @property
    def foreign(self) -> list[str]:
        return [name for name in self.named if self.term(name).kind is Kind.FOREIGN]


def recording_of(
    signals: Signals, plant: dict[str, float], rest_rad_s: float, first_stretch: int, kept: Flags | None = None
) -> Recording:
    """`kept`: rows that nothing is fitted to; every third second where there are none given."""
    period_s = signals.period_s
    shaft = Windows.over(len(signals), Bump.of(SHAFT_S, period_s))
    fine = Windows.over(len(signals), Bump.of(FINE_S, period_s))
    still = np.abs(signals.speed_rad_s) < rest_rad_s
    shaft, fine = (w.where(w.all_of(signals.good) & (w.share_of(still) < REST_SHARE)) for w in (shaft, fine))
    winding = None
    if signals.has_voltages:
        winding = Windows.over(len(signals), Bump.of(WINDING_S, period_s))
        winding = winding.where(winding.all_of(signals.good))
    equations = Equations(signals, plant, shaft, fine, winding, 0.25 * rest_rad_s)
    numbers = tuple((w.centre[w.used] * period_s // STRETCH_S).astype(np.int64) for w in equations.windows())
    unseen = tuple(
        number % UNSEEN == UNSEEN - 1 if kept is None else w.at_rows(kept)
        for number, w in zip(numbers, equations.windows(), strict=True)
    )
    return Recording(signals, equations, unseen, tuple(number + first_stretch for number in numbers))


def explain(
    logs: Sequence[Signals],
    plant: dict[str, float],
    base: Sequence[Acting],
    scale: Scale,
    tolerances: Tolerances,
    progress: Callable[[str, float], None] | None = None,
    estimated: Sequence[str] = (),
    shafts: bool = True,
    kept: Sequence[Flags] | None = None,
    without: frozenset[str] = frozenset(),
) -> Explained:
    """`estimated`: numbers of the plant that the logs gave themselves; the effects on them are no deviation. `shafts`:
    whether a compliant one is searched. `kept`: of each log, the rows that nothing is fitted to. `without`: terms that
    are left out."""
    say = progress or (lambda what, share: None)
    top_rad_s = max(float(np.percentile(np.abs(log.speed_rad_s), 99.0)) for log in logs)
    rest_rad_s = 0.012 * top_rad_s
    recordings = []
    for number, log in enumerate(logs):
        recordings.append(recording_of(log, plant, rest_rad_s, 100000 * number, kept[number] if kept else None))
    equations = [each.equations for each in recordings]
    has_angle = all(log.shows_orders for log in logs)
    slow = any(log.period_s >= SLOW_S for log in logs)
    has_voltages = any(log.has_voltages for log in logs)
    orders = cogging_orders(scale)
    if not has_voltages:  # where errors of a current sensor show, which the winding separates from torque of the shaft
        orders = sorted({*orders, scale.pole_pairs, 2 * scale.pole_pairs})
    has_load = any(log.loaded(scale.rated_torque_nm) for log in logs)
    if not has_voltages and not has_load:
        tolerances = tolerances.without_scale(hypotheses(scale))
    given, tolerances = tolerances, tolerances.between_rows() if slow else tolerances
    sizes = Sizes(scale, tolerances, plant["pwm_hz"], top_rad_s)
    terms = effect_terms(sizes, has_angle, has_voltages, orders, has_load)
    terms = [term for term in terms if not (slow and term.effect in FAST)]
    terms = [opened(term) if NUMBER_OF.get(term.effect) in estimated else term for term in terms]
    terms += _unit_terms(recordings, plant, tolerances, estimated)
    terms += [t for t in foreign_terms(scale, plant, top_rad_s, has_voltages) if t.name not in without]
    model = Model(equations, base, terms, LATE_PERIODS / plant["pwm_hz"])
    edges = Edges(tolerances.torque * scale.rated_torque_nm, tolerances.volts * plant["dc_link_v"])
    point = model.start()
    start = dict(point)
    if has_voltages:
        point |= electrical_zero(model, point)
    named: frozenset[str] = frozenset()
    rivals: list[Choice] = []
    normal: Normal | None = None
    whole = last = point
    gatherer = Gatherer(
        model, [[~flags for flags in each.unseen] for each in recordings], [each.stretch for each in recordings]
    )
    for number in range(ROUNDS):
        say("fitting", 0.1 + 0.1 * number)
        pieces = gatherer.pieces(point, named)
        toward = pull_of(terms, point)
        normal = normal_of(pieces, prior_of(terms, _all_free(terms), REACH), toward)
        rivals = choices(terms, normal, point, edges)
        best = rivals[0]
        whole, last = settled(terms, point, best.step, best.names), point
        point = moved(terms, point, best.step, best.names)
        if number == 0:
            added = [t for t in _line_terms(model, whole, recordings, scale, has_angle) if t.name not in without]
            added += (
                []
                if slow or not shafts
                else _shaft_terms(gatherer, pieces, normal, prior_of(terms, best.names), toward, sizes)
            )
            terms += added
            for term in added:
                point[term.name] = start[term.name] = term.off.copy()
            again = bool(added)
        else:
            again = False
        if best.names == named and number > 0 and not again and _rests(terms, best):
            break
        named = best.names
    assert normal is not None
    names = sorted(named, key=lambda name: -_gain(name, rivals))
    before = [model.residual(_units_of(terms, start, point), log) for log in range(len(logs))]
    after = [model.residual(whole, log) for log in range(len(logs))]
    unseen = [each.unseen for each in recordings]
    if any(term.effect == SHAFT and term.name in named for term in terms):
        stiff = {term.name: term.off if term.effect == SHAFT else whole[term.name] for term in terms}
        rigid = [model.residual(stiff, log, shaft_only=True) for log in range(len(logs))]
        if not shaft_is_seen(unseen, after, rigid, before):
            return explain(
                logs, plant, base, scale, given, progress, estimated, shafts=False, kept=kept, without=without
            )
    foreign = frozenset(term.name for term in terms if term.kind is Kind.FOREIGN and term.name in named)
    known = next((choice for choice in rivals if not choice.names & foreign), None)
    if foreign and known is not None and len(without) < MOST_LEFT_OUT:
        plain = settled(terms, last, known.step, known.names)
        if not foreign_is_seen(unseen, after, [model.residual(plain, log) for log in range(len(logs))]):
            return explain(
                logs, plant, base, scale, given, progress, estimated, shafts, kept=kept, without=without | foreign
            )
    return Explained(
        model, recordings, scale, tolerances, tuple(names), whole, normal, rivals, before, after, top_rad_s
    )


def electrical_zero(model: Model, point: Point) -> Point:
    """Too large for a linear step, and the d axis alone tells it: there the flux of the magnets induces nothing."""

    def left(angle_rad: float) -> float:
        at = {**point, ZERO_TERM: np.array([angle_rad])}
        rest = [model.residual(at, log) for log, each in enumerate(model.logs) if each.winding is not None]
        return sum(float(np.median(np.abs(parts[D_AXIS]))) for parts in rest)

    if ZERO_TERM not in point:
        return {}
    coarse = np.linspace(-ZERO_MOST, ZERO_MOST, ZERO_TRIALS)
    best = min(coarse, key=left)
    pitch = coarse[1] - coarse[0]
    for _ in range(ZERO_HALVINGS):
        pitch *= 0.5
        best = min((best - pitch, best, best + pitch), key=left)
    return {ZERO_TERM: np.array([best])}


def cogging_orders(scale: Scale) -> list[int]:
    if scale.slots <= 0:
        return [6 * scale.pole_pairs]
    return sorted({math.lcm(scale.slots, 2 * scale.pole_pairs), scale.slots})


def _all_free(terms: Sequence[Term]) -> set[str]:
    """Every effect, with the first of its variants: they look alike."""
    first = {term.effect: term.name for term in reversed(terms) if term.variant}
    return {t.name for t in terms if t.kind is Kind.EFFECT and (not t.variant or first[t.effect] == t.name)}


def _unit_terms(
    recordings: Sequence[Recording], plant: dict[str, float], tolerances: Tolerances, estimated: Sequence[str]
) -> list[Term]:
    terms = [
        unit_term(LD, OPEN if "ld_h" in estimated else tolerances.inductance, 0.01),
        unit_term(LQ, OPEN if "lq_h" in estimated else tolerances.inductance, 0.01),
    ]
    for number, each in enumerate(recordings):
        terms.append(late_current(f"{CURRENT_LATE}@{number}", each.signals.period_s, plant, number))
        if each.signals.has_voltages:
            period_s = 1.0 / plant["pwm_hz"]
            terms.append(
                unit_term(
                    f"{LATE}@{number}",
                    max(LATE_PERIODS * period_s, 0.5 * each.signals.period_s),
                    0.1 * period_s,
                    log=number,
                )
            )
            terms.append(unit_term(f"{TURNED}@{number}", LATE_PERIODS * period_s, 0.1 * period_s, log=number))
            terms.append(answer_term(f"{ANSWER}@{number}", plant, number))
            if len(recordings) > 1:
                terms.append(
                    unit_term(
                        f"{ZERO}@{number}", 0.01 * tolerances.times.get("encoder_offset", 1.0) / HELD, 1e-3, log=number
                    )
                )
    return terms


def _line_terms(
    model: Model, point: Point, recordings: Sequence[Recording], scale: Scale, has_angle: bool
) -> list[Term]:
    """Lines of unknown cause in what the first choice leaves of the torque."""
    least_nm = ORDER_NM * scale.rated_torque_nm
    p = scale.pole_pairs
    known = [1.0, 2.0, p, 2.0 * p, 6.0 * p, *cogging_orders(scale)]
    found: dict[str, Term] = {}
    for log, each in enumerate(recordings):
        windows, s = each.equations.shaft, each.signals
        left = model.residual(point, log, shaft_only=True)[0]
        if has_angle:
            for order, _ in foreign_orders(
                left, windows.at_centre(s.theta_m_rad), windows.at_centre(s.speed_rad_s), windows, known
            ):
                term = order_term(order, least_nm)
                found.setdefault(term.name, term)
        if len(recordings) == 1:
            for hz, _ in foreign_frequencies(left, windows.at_centre(s.t_s), windows):
                term = frequency_term(hz, least_nm)
                found.setdefault(term.name, term)
    return list(found.values())


def _shaft_terms(
    gatherer: Gatherer, pieces: Sequence[Piece], normal: Normal, prior: Array, toward: Array, sizes: Sizes
) -> list[Term]:
    fits = [np.ones(len(piece.r), dtype=bool) for piece in pieces]
    return shaft_candidates(gatherer, left_of(pieces, fits, normal.inflation, prior, toward), sizes)


def _rests(terms: Sequence[Term], best: Choice) -> bool:
    at, moves = 0, 0.0
    for term in terms:
        step = best.step[at : at + len(term)]
        at += len(term)
        if term.name in best.names and term.kind is Kind.EFFECT:
            main = ~term.details
            moves = max(moves, float(np.max(np.abs(step[main] / term.held[main]))))
    return moves < RESTS


def _units_of(terms: Sequence[Term], start: Point, point: Point) -> Point:
    """Nothing named, with the delays that were found: these are of the log, not of the machine."""
    return {
        term.name: point[term.name] if term.name.startswith((LATE, TURNED, ANSWER, CURRENT_LATE)) else start[term.name]
        for term in terms
    }


def _gain(name: str, rivals: Sequence[Choice]) -> float:
    """What leaving a name out costs."""
    without = [choice.cost for choice in rivals if name not in choice.names]
    return min(without) - rivals[0].cost if without else math.inf
