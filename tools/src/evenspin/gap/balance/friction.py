"""A log that sweeps the speed: which friction, which load. The first half fits, the second half validates."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from evenspin.gap.balance import terms
from evenspin.gap.balance.angle_zero import find_zero, with_zero
from evenspin.gap.balance.grid import Flags
from evenspin.gap.balance.motion import Motion
from evenspin.gap.balance.nominal import Nominal
from evenspin.gap.balance.regression import Fit, fit, rms
from evenspin.gap.balance.terms import Term

Array = NDArray[np.float64]

SIGMA_S = 8e-3  # smoothing: above the jitter of the time stamps, below any sweep of the speed
CHANCE = 1e-4  # a term is significant when chance would do as well less often than this
SHARE = 0.05  # of the residue on the half that fits: less is not worth a name
VALID_SHARE = 0.03  # of the residue on the half that validates
STILL_SHARE = 0.01  # of the highest speed: a rotor slower than this for long may stick, and friction is then anything
SLOW_SHARE = 0.2  # of the highest speed
BINS = 12  # of speed, for what is left


@dataclass(frozen=True, slots=True)
class Evidence:
    """What speaks for and against one effect. Drops are shares of the residue that the effect takes away."""

    effect: str
    named: bool
    values: dict[str, float]
    p_value: float
    fit_drop: float
    validation_drop: float
    said: str


@dataclass(frozen=True, slots=True)
class Remainder:
    """What is left in the validation half."""

    rms_a: float
    told_rms_a: float  # the part of it that speed and direction of acceleration tell, from the other half
    curvature_p: float
    curvature: float  # A per (rad/s)^2: below 0 friction grows less than linearly
    drift_share: float  # change of the dry friction over the log, relative
    drift_p: float
    slow_below_rad_s: float
    slow_rms_a: float  # of the residue below that speed
    fast_rms_a: float  # and above


@dataclass(frozen=True, slots=True)
class FrictionResult:
    motion: Motion
    fit_rows: Flags
    validation_rows: Flags
    final: Fit
    terms: tuple[Term, ...]
    evidence: tuple[Evidence, ...]
    before: Array  # residue of the balance over the whole grid, A
    after: Array
    before_rms_a: float
    after_rms_a: float
    remainder: Remainder
    lines_seen: bool  # of the model, at some zero of the angle


def halves(rows: Flags) -> tuple[Flags, Flags]:
    """First and second half of the usable rows."""
    used = np.flatnonzero(rows)
    first, second = np.zeros_like(rows), np.zeros_like(rows)
    first[used[: len(used) // 2]] = True
    second[used[len(used) // 2 :]] = True
    return first, second


def moving_rows(motion: Motion) -> Flags:
    """Rows at which friction is defined: those where the rotor does not rest."""
    w = motion.raw_speed_rad_s
    top = float(np.quantile(np.abs(w[motion.good]), 0.99))
    still = motion.smooth((np.abs(w) < STILL_SHARE * top).astype(float)) > 0.8
    return motion.good & ~still


def known_part(motion: Motion, nominal: Nominal | None) -> Array:
    """What the model says that the current has to do, A."""
    if nominal is None:
        return np.zeros_like(motion.iq_a)
    known = nominal.inertia_as2 * motion.accel_rad_s2 + nominal.viscous_as * motion.speed_rad_s
    dry = nominal.friction(motion.raw_speed_rad_s)
    if motion.theta_rad is not None:
        dry = dry + sum(line(motion.theta_rad) for line in nominal.lines)
    return known + motion.smooth(dry)


def weigh_friction(motion: Motion, nominal: Nominal | None) -> FrictionResult:
    rows = moving_rows(motion)
    first, second = halves(rows)
    if nominal is not None and nominal.lines:
        bare = motion.iq_a - known_part(motion, with_zero(nominal, None))
        nominal = with_zero(nominal, find_zero(motion, nominal.lines, bare, first))
    y = motion.iq_a - known_part(motion, nominal)
    base = [terms.inertia(motion), terms.viscous(motion)]
    families = _families(motion)
    chosen: list[Term] = []
    for _ in families:
        best = _best(base + chosen, families, chosen, y, first, second)
        if best is None:
            break
        chosen.append(best)
    chosen = _drop_superfluous(base, chosen, y, first, second)
    chosen = [_refined(base + chosen, term, motion, y, first) for term in chosen]
    final = _fit(base + chosen, y, first)
    after = y - _explained(base + chosen, final)
    before = y if nominal is not None else y - _explained(base, _fit(base, y, first))
    evidence = _evidence(base, families, chosen, y, first, second)
    left = Remainder(
        rms(after[second]),
        *_told(motion, after, first, second),
        *_curved(base + chosen, motion, y, rows),
        *_drift(base + chosen, motion, y, rows, nominal),
        *_slow_and_fast(motion, after, second),
    )
    return FrictionResult(
        motion,
        first,
        second,
        final,
        (*base, *chosen),
        evidence,
        before,
        after,
        rms(before[second]),
        rms(after[second]),
        left,
        nominal is not None and bool(nominal.lines),
    )


def _families(motion: Motion) -> list[list[Term]]:
    """Each effect with its variants, of which the best is taken."""
    found = [[terms.coulomb(motion)], [terms.load(motion)], terms.stribeck_family(motion)]
    if motion.theta_rad is not None:
        found.append([terms.misalignment(motion)])
    return [family for family in found if family]


def _names(used: Sequence[Term]) -> list[str]:
    return [f"{term.effect}.{key}" for term in used for key in term.keys]


def _fit(used: Sequence[Term], y: Array, rows: Flags) -> Fit:
    return fit(_names(used), [column[rows] for term in used for column in term.columns], y[rows])


def _explained(used: Sequence[Term], found: Fit) -> Array:
    columns = [column for term in used for column in term.columns]
    return np.column_stack(columns) @ found.value


def _residues(used: Sequence[Term], y: Array, first: Flags, second: Flags) -> tuple[Fit, float, float]:
    found = _fit(used, y, first)
    after = y - _explained(used, found)
    return found, rms(after[first]), rms(after[second])


def _weigh(used: list[Term], term: Term, y: Array, first: Flags, second: Flags) -> Evidence:
    """What this term does beside the others."""
    others = [other for other in used if other.effect != term.effect]
    _, fit_without, valid_without = _residues(others, y, first, second)
    found, fit_with, valid_with = _residues([*others, term], y, first, second)
    names = [f"{term.effect}.{key}" for key in term.keys]
    values = [found[name] for name in names]
    p = found.p_value(names)
    fit_drop, valid_drop = 1.0 - fit_with / fit_without, 1.0 - valid_with / valid_without
    wrong = term.must(values)
    if wrong is not None:
        said = wrong
    elif p > CHANCE:
        said = f"not significant (p = {p:.2g})"
    elif fit_drop < SHARE:
        said = f"takes only {100.0 * fit_drop:.1f} % off the residue that is fitted"
    elif valid_drop < VALID_SHARE:
        said = f"changes the residue of the validation half by {-100.0 * valid_drop:+.1f} % only"
    else:
        said = f"takes {100.0 * valid_drop:.0f} % off the residue of the validation half"
    named = wrong is None and p <= CHANCE and fit_drop >= SHARE and valid_drop >= VALID_SHARE
    numbers = dict(zip(term.keys, values, strict=True)) | dict(term.extra)
    return Evidence(term.effect, named, numbers, p, fit_drop, valid_drop, said)


def _strongest(used: list[Term], family: list[Term], y: Array, first: Flags, second: Flags) -> tuple[Term, Evidence]:
    """Of the variants, the one that fits best; one that may be named goes before one that may not."""
    weighed = [(term, _weigh(used, term, y, first, second)) for term in family]
    return max(weighed, key=lambda pair: (pair[1].fit_drop, pair[1].named))


def _best(
    used: list[Term], families: list[list[Term]], chosen: list[Term], y: Array, first: Flags, second: Flags
) -> Term | None:
    taken = {term.effect for term in chosen}
    weighed = [_strongest(used, f, y, first, second) for f in families if f[0].effect not in taken]
    good = [(evidence.fit_drop, term) for term, evidence in weighed if evidence.named]
    return max(good, key=lambda pair: pair[0])[1] if good else None


def _drop_superfluous(base: list[Term], chosen: list[Term], y: Array, first: Flags, second: Flags) -> list[Term]:
    """An effect that the later ones made superfluous goes."""
    for term in list(chosen):
        if not _weigh(base + chosen, term, y, first, second).named:
            chosen = [other for other in chosen if other is not term]
    return chosen


def _refined(used: list[Term], term: Term, motion: Motion, y: Array, first: Flags) -> Term:
    """The Stribeck speed between the values of its family."""
    if term.effect != "stribeck_friction":
        return term
    others = [other for other in used if other.effect != term.effect]
    start = dict(term.extra)["speed_rad_s"]

    def residue(log_ratio: float) -> float:
        return rms(_fit([*others, terms.stribeck(motion, start * math.exp(log_ratio))], y, first).residual)

    best = minimize_scalar(residue, bounds=(-0.5, 0.5), method="bounded", options={"xatol": 0.01})
    return terms.stribeck(motion, start * math.exp(float(best.x)))


def _evidence(
    base: list[Term], families: list[list[Term]], chosen: list[Term], y: Array, first: Flags, second: Flags
) -> tuple[Evidence, ...]:
    """For every effect: what it adds to, or takes from, the model that was found."""
    taken = {term.effect: term for term in chosen}
    weighed = [
        _strongest(base + chosen, [taken[f[0].effect]] if f[0].effect in taken else f, y, first, second)[1]
        for f in families
    ]
    return tuple(sorted(weighed, key=lambda e: (not e.named, -e.fit_drop)))


def _told(motion: Motion, after: Array, first: Flags, second: Flags) -> tuple[float]:
    """How much of what is left a table over speed and sign of acceleration tells: made from one half, of the other."""
    w = motion.speed_rad_s
    edges = np.quantile(w[first | second], np.linspace(0.0, 1.0, BINS + 1)[1:-1])
    cell = 2 * np.searchsorted(edges, w) + (motion.accel_rad_s2 > 0.0)
    told = np.zeros_like(after)
    for number in range(2 * BINS):
        inside = first & (cell == number)
        if np.any(inside):
            told[cell == number] = np.mean(after[inside])
    gain = rms(after[second]) ** 2 - rms((after - told)[second]) ** 2
    return (float(np.sqrt(max(gain, 0.0))),)


def _slow_and_fast(motion: Motion, after: Array, second: Flags) -> tuple[float, float, float]:
    speed = np.abs(motion.speed_rad_s)
    limit = SLOW_SHARE * float(np.quantile(speed[second], 0.99))
    slow = speed < limit
    return limit, rms(after[second & slow]), rms(after[second & ~slow])


def _curved(used: list[Term], motion: Motion, y: Array, rows: Flags) -> tuple[float, float]:
    term = Term("curvature", ("a_per_rad2_s2",), (terms.curvature(motion),))
    found = _fit([*used, term], y, rows)
    name = "curvature.a_per_rad2_s2"
    return found.p_value([name]), found[name]


def _drift(used: list[Term], motion: Motion, y: Array, rows: Flags, nominal: Nominal | None) -> tuple[float, float]:
    """Does the dry friction change over the log? Relative change from its start to its end."""
    span_s = motion.t_s[rows][-1] - motion.t_s[rows][0]
    ramp = (motion.t_s - np.mean(motion.t_s[rows])) / span_s
    dry = terms.coulomb(motion)
    found = _fit(
        [*[t for t in used if t.effect != dry.effect], dry, Term("drift", ("a",), (ramp * dry.columns[0],))], y, rows
    )
    known_a = nominal.coulomb_a if nominal is not None else 0.0
    level = abs(found["coulomb_friction.torque_a_equiv"] + known_a)
    return (found["drift.a"] / level if level > 0.0 else 0.0), found.p_value(["drift.a"])
