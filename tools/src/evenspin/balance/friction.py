"""Friction and load: stepwise selection of terms on the fitting stretches, checked on the validation stretches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from evenspin.balance import effect_terms, shaft_regression
from evenspin.balance.angle_zero import find_zero, with_zero
from evenspin.balance.effect_terms import Term
from evenspin.balance.line_search import Views
from evenspin.balance.motion import Motion
from evenspin.balance.nominal_model import Nominal, torque_of
from evenspin.balance.regression import Fit, rms
from evenspin.balance.residual_tests import Remainder, Residue, remainder_of
from evenspin.balance.shaft_regression import INERTIA, VISCOUS, Drive, fit_terms, known_part
from evenspin.balance.stretches import Stretches
from evenspin.balance.time_grid import Flags

Array = NDArray[np.float64]

CHANCE = 1e-4  # a term is significant when chance would do as well less often than this
SMALL = 0.02  # of the current, rms: less is not worth a name either
SHARE = 0.05  # of the residue on the stretches that fit: less is not worth a name
VALID_SHARE = 0.03  # of the residue on the stretches that validate
SENSOR = 0.005  # of the current, rms: what a sensor is off by that is no constant factor
ONE_SPEED = 3.0  # times as wide is the interval of an inertia that only the ripple at one speed shows
RISE = "stribeck_friction"


@dataclass(frozen=True, slots=True)
class Evidence:
    """The evidence for and against one effect. Drops are shares of the residue that the effect takes away."""

    effect: str
    named: bool
    small: bool  # too small for a name, however significant: it is fitted, and is a deviation of this unit
    values: dict[str, float]
    p_value: float
    fit_drop: float
    validation_drop: float
    reason: str


@dataclass(frozen=True, slots=True)
class Trial:
    """The data that terms are selected on."""

    y: Array
    first: Flags  # rows that fit
    second: Flags  # rows that validate
    current_a: float  # rms


@dataclass(frozen=True, slots=True)
class FrictionResult:
    motion: Motion
    drive: Drive
    fit_rows: Flags
    validation_rows: Flags
    final: Fit
    half: dict[str, float]  # of the 95 % intervals, with what scatter alone does not cover
    terms: tuple[Term, ...]
    evidence: tuple[Evidence, ...]
    impossible: tuple[str, ...]  # effects that would have to be negative
    before: Array  # residue of the balance over the whole grid, A
    after: Array
    before_rms_a: float
    after_rms_a: float
    remainder: Remainder
    lines_seen: bool  # of the model, at some zero of the angle


def select_friction(
    motions: Views, nominal: Nominal | None, drive: Drive, orders: Sequence[float], stretches: Stretches, shift_s: float
) -> FrictionResult | None:
    """None: too few rows at which the rotor turns. `orders`: lines over the angle, which are fitted along.

    `shift_s`: how far apart in time current and motion of one row may be.
    """
    given = with_zero(nominal, None) if nominal is not None else None  # its lines are found again, not subtracted
    steps = shaft_regression.fit_ladder(motions, given, drive, orders, stretches)
    if not steps:
        return None
    at, short = shaft_regression.best_steps(steps)
    motion = motions(steps[short].sigma_s, 0.0)
    rows = shaft_regression.thinned(shaft_regression.moving_rows(motion, stretches), motion)
    first, second = rows & stretches.fits, rows & ~stretches.fits
    lines = [effect_terms.line(motion, order) for order in orders]
    y = motion.iq_a - known_part(motion, given)
    base = [*shaft_regression.base_terms(motion, drive), *lines]
    families = _families(motion, drive)
    if drive.one_speed and nominal is None:  # at one speed all of it may be the viscous friction that every shaft has
        base.append(shaft_regression.dry_terms(motion, drive)[0])
        families = families[1:]
    impossible, base = _possible(base, families, nominal, y, rows)
    # A single ramp identifies the inertia, and it lies in one stretch: the inertia is that of the whole log throughout.
    torque = y - steps[at].value[INERTIA] * motion.accel_rad_s2
    trial = Trial(torque, first, second, rms(motion.iq_a[rows]))
    shaft_only = [term for term in base if term.effect != "inertia"]
    chosen: list[Term] = []
    for _ in families:
        best = _best(shaft_only + chosen, families, chosen, trial)
        if best is None:
            break
        chosen.append(best)
    chosen = _drop_superfluous(shaft_only, chosen, trial)
    chosen = [_refined(shaft_only + chosen, term, motion, torque, first) for term in chosen]
    plain = [term for term in base + chosen if term not in lines]
    final, half = _final(motions, given, drive, orders, stretches, plain, steps[at].sigma_s, shift_s)
    used = shaft_only + chosen
    on_first = fit_terms(used, torque, first)
    after, rest = torque - _shaft_part(used, lines, on_first), torque - _explained(used, on_first)
    bare = [term for term in base if term not in lines]
    before = _before(motion, nominal, [term for term in bare if term.effect != "inertia"], torque, first)
    if nominal is not None and nominal.inertia_as2 > 0.0:
        before = before + steps[at].value[INERTIA] * motion.accel_rad_s2
    evidence = _evidence(shaft_only, families, chosen, trial)
    left = remainder_of(Residue(motion, drive, y, rest, first, second), base + chosen, families, nominal)
    return FrictionResult(
        motion, drive, first, second, final, half, (*bare, *chosen), evidence, impossible, before, after,
        rms(before[second]), rms(after[second]), left, nominal is not None and bool(nominal.lines),
    )  # fmt: skip


def _before(motion: Motion, nominal: Nominal | None, bare: Sequence[Term], torque: Array, first: Flags) -> Array:
    """What is left without the missing effects: the model, or inertia and viscous friction alone."""
    if nominal is None:
        return torque - _explained(bare, fit_terms(bare, torque, first)) if bare else torque
    zero_rad = find_zero(motion, nominal.lines, torque, first)
    if zero_rad is None or motion.theta_rad is None:
        return torque
    return torque - motion.smooth(torque_of(with_zero(nominal, zero_rad).lines, motion.theta_rad))


def _possible(
    base: list[Term], families: list[list[Term]], nominal: Nominal | None, y: Array, rows: Flags
) -> tuple[tuple[str, ...], list[Term]]:
    """Effects whose value would be negative, and the base without a viscous friction that is negative."""
    full = [*base, *(family[0] for family in families if family[0].effect != "stribeck_friction")]
    found = fit_terms(full, y, rows)
    known = {INERTIA: nominal.inertia_as2, VISCOUS: nominal.viscous_as} if nominal is not None else {}
    impossible = []
    for name in (INERTIA, VISCOUS):
        if name not in found.names:
            continue
        value = found[name] + known.get(name, 0.0)
        if value < -2.0 * found.half(name):
            impossible.append(name.split(".")[0])
        if name == VISCOUS and value < 0.0:
            base = [term for term in base if term.effect != "viscous_friction"]
    return tuple(impossible), base


def _shaft_part(used: Sequence[Term], lines: Sequence[Term], found: Fit) -> Array:
    """What the shaft explains. Lines are fitted along, and reported with a balance of their own."""
    skipped = set(shaft_regression.names_of(lines))
    names = [name for name in shaft_regression.names_of(used) if name not in skipped]
    columns = dict(
        zip(shaft_regression.names_of(used), (column for term in used for column in term.columns), strict=True)
    )
    return sum((found[name] * columns[name] for name in names), np.zeros(1))


def _final(
    motions: Views, given: Nominal | None, drive: Drive, orders: Sequence[float], stretches: Stretches,
    plain: Sequence[Term], sigma_s: float, shift_s: float,
) -> tuple[Fit, dict[str, float]]:  # fmt: skip
    """Values from all rows, and half widths: scatter, noise of the angle, other smoothing, time, and the machine."""

    def same(motion: Motion) -> list[Term]:
        return [again(term, motion) for term in plain]

    def fitted(shift_s: float) -> Fit:
        motion = motions(sigma_s, shift_s)
        rows = shaft_regression.thinned(shaft_regression.moving_rows(motion, stretches), motion)
        used = [*same(motion), *(effect_terms.line(motion, order) for order in orders)]
        return fit_terms(used, motion.iq_a - known_part(motion, given), rows)

    near = [s for s in shaft_regression.LADDER_S if 0.4 * sigma_s < s < 4.5 * sigma_s]
    steps = shaft_regression.fit_ladder(motions, given, drive, orders, stretches, same, near)
    at = next(i for i, step in enumerate(steps) if step.sigma_s == sigma_s)
    final, *moved = (fitted(shift) for shift in (0.0, -shift_s, shift_s))
    known = {INERTIA: given.inertia_as2, VISCOUS: given.viscous_as} if given is not None else {}
    motion = motions(sigma_s, 0.0)
    rows = shaft_regression.moving_rows(motion, stretches)
    half = {}
    for name in shaft_regression.names_of(plain):
        machine = shaft_regression.MACHINE * abs(final[name] + known.get(name, 0.0))
        if name == INERTIA:
            machine, sensor = machine * (ONE_SPEED if drive.one_speed else 1.0), 0.0
        else:
            sensor = SENSOR * rms(motion.iq_a[rows]) / (rms(motion.speed_rad_s[rows]) if name == VISCOUS else 1.0)
        shifted = max(abs(other[name] - final[name]) for other in moved)
        half[name] = math.hypot(shaft_regression.half_width(steps, at, name), shifted, machine, sensor)
    return final, half


def again(term: Term, motion: Motion) -> Term:
    """The same term of another smoothing."""
    if term.effect == "stribeck_friction":
        return effect_terms.stribeck(motion, dict(term.extra)["speed_rad_s"])
    made = {
        "inertia": effect_terms.inertia,
        "viscous_friction": effect_terms.viscous,
        "coulomb_friction": effect_terms.coulomb,
        "load_torque": effect_terms.load,
    }
    return made[term.effect](motion) if term.effect in made else effect_terms.drag(motion, term.effect)


def _families(motion: Motion, drive: Drive) -> list[list[Term]]:
    """Each effect with its variants, of which the best is taken."""
    found = [[term] for term in shaft_regression.dry_terms(motion, drive)]
    if drive.sweeps:
        found.append(effect_terms.stribeck_family(motion))
    return [family for family in found if family]


def _explained(used: Sequence[Term], found: Fit) -> Array:
    columns = [column for term in used for column in term.columns]
    return np.column_stack(columns) @ found.value if columns else np.zeros(1)


def _residues(used: Sequence[Term], trial: Trial) -> tuple[Fit, float, float]:
    found = fit_terms(used, trial.y, trial.first)
    after = trial.y - _explained(used, found)
    return found, rms(after[trial.first]), rms(after[trial.second])


def _evidence_of(used: list[Term], term: Term, trial: Trial) -> Evidence:
    """What this term explains beside the others."""
    others = [other for other in used if other.effect != term.effect]
    _, fit_without, valid_without = _residues(others, trial)
    found, fit_with, valid_with = _residues([*others, term], trial)
    names = [f"{term.effect}.{key}" for key in term.keys]
    values = [found[name] for name in names]
    p = found.p_value(names)
    fit_drop, valid_drop = 1.0 - fit_with / fit_without, 1.0 - valid_with / valid_without
    wrong = term.must(values)
    if wrong is not None:
        reason = wrong
    elif p > CHANCE:
        reason = f"not significant (p = {p:.2g})"
    elif fit_drop < SHARE:
        reason = f"takes only {100.0 * fit_drop:.1f} % off the residue that is fitted"
    elif valid_drop < VALID_SHARE:
        reason = f"changes the residue of the validation stretches by {-100.0 * valid_drop:+.1f} % only"
    else:
        reason = f"takes {100.0 * valid_drop:.0f} % off the residue of the validation stretches"
    named = wrong is None and p <= CHANCE and fit_drop >= SHARE and valid_drop >= VALID_SHARE
    part = 1.0 if term.effect == RISE else rms(term.columns[0][trial.first | trial.second])
    small = abs(values[0]) * part < SMALL * trial.current_a
    numbers = dict(zip(term.keys, values, strict=True)) | dict(term.extra)
    return Evidence(term.effect, named, small, numbers, p, fit_drop, valid_drop, reason)


def _strongest(used: list[Term], family: list[Term], trial: Trial) -> tuple[Term, Evidence]:
    """Of the variants, the one that fits best; one that may be named goes before one that may not."""
    candidates = [(term, _evidence_of(used, term, trial)) for term in family]
    return max(candidates, key=lambda pair: (pair[1].fit_drop, pair[1].named))


def _best(used: list[Term], families: list[list[Term]], chosen: list[Term], trial: Trial) -> Term | None:
    taken = {term.effect for term in chosen}
    open_to = [f for f in families if f[0].effect not in taken and (f[0].effect != RISE or _has_dry(used))]
    candidates = [_strongest(used, f, trial) for f in open_to]
    good = [(evidence.fit_drop, term) for term, evidence in candidates if evidence.named]
    return max(good, key=lambda pair: pair[0])[1] if good else None


def _has_dry(used: Sequence[Term]) -> bool:
    """A rise at low speed is one of dry friction; alone it would only stand for that."""
    return any(term.effect.startswith("coulomb_friction") for term in used)


def _drop_superfluous(base: list[Term], chosen: list[Term], trial: Trial) -> list[Term]:
    """An effect that the later ones made superfluous goes."""
    for term in list(chosen):
        if not _evidence_of(base + chosen, term, trial).named:
            chosen = [other for other in chosen if other is not term]
    return chosen


def _refined(used: list[Term], term: Term, motion: Motion, y: Array, first: Flags) -> Term:
    """The Stribeck speed between the values of its family."""
    if term.effect != "stribeck_friction":
        return term
    others = [other for other in used if other.effect != term.effect]
    start = dict(term.extra)["speed_rad_s"]

    def residue(log_ratio: float) -> float:
        return rms(fit_terms([*others, effect_terms.stribeck(motion, start * math.exp(log_ratio))], y, first).residual)

    best = minimize_scalar(residue, bounds=(-0.5, 0.5), method="bounded", options={"xatol": 0.01})
    return effect_terms.stribeck(motion, start * math.exp(float(best.x)))


def _evidence(base: list[Term], families: list[list[Term]], chosen: list[Term], trial: Trial) -> tuple[Evidence, ...]:
    """For every effect: what it adds to, or takes from, the model that was found."""
    taken = {term.effect: term for term in chosen}
    candidates = [
        _strongest(base + chosen, [taken[f[0].effect]] if f[0].effect in taken else f, trial)[1] for f in families
    ]
    return tuple(sorted(candidates, key=lambda e: (not e.named, -e.fit_drop)))
