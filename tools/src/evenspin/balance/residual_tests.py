"""What is left where it was not fitted: does it follow the speed, bend with it, drift, or stand at low speed?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance import effect_terms, shaft_regression
from evenspin.balance.effect_terms import Term
from evenspin.balance.motion import Motion
from evenspin.balance.nominal_model import Nominal
from evenspin.balance.regression import rms
from evenspin.balance.shaft_regression import Drive, fit_terms
from evenspin.balance.time_grid import Flags

Array = NDArray[np.float64]

BINS = 12  # of speed, for what is left
SLOW_SHARE = 0.2  # of the highest speed


@dataclass(frozen=True, slots=True)
class Remainder:
    """What is left in the validation stretches."""

    rms_a: float
    predictable_rms_a: float  # the part that speed and direction of acceleration predict, from the other stretches
    curvature_p: float
    curvature: float  # A per (rad/s)^2: below 0 friction grows less than linearly
    curvature_drop: float  # of the residue
    drift_share: float  # change of the dry friction over the log, relative
    drift_p: float
    slow_below_rad_s: float
    slow_rms_a: float  # of the residue below that speed
    fast_rms_a: float  # and above


@dataclass(frozen=True, slots=True)
class Residue:
    """`y`: what the shaft has to explain; `rest`: what it and the lines leave, A."""

    motion: Motion
    drive: Drive
    y: Array
    rest: Array
    first: Flags  # rows that fit
    second: Flags  # rows that validate

    @property
    def rows(self) -> Flags:
        return self.first | self.second


def remainder_of(left: Residue, used: list[Term], families: list[list[Term]], nominal: Nominal | None) -> Remainder:
    return Remainder(
        rms(left.rest[left.second]),
        _predictable_rms(left.motion, left.rest, left.first, left.second),
        *_curved(left, used, families),
        *_drift(left, used, nominal),
        *_slow_and_fast(left.motion, left.rest, left.second),
    )


def _predictable_rms(motion: Motion, after: Array, first: Flags, second: Flags) -> float:
    """Part of the residual that a table over speed and sign of acceleration predicts; the fitting stretches make it."""
    w = motion.speed_rad_s
    edges = np.quantile(w[first | second], np.linspace(0.0, 1.0, BINS + 1)[1:-1])
    cell = 2 * np.searchsorted(edges, w) + (motion.accel_rad_s2 > 0.0)
    predicted = np.zeros_like(after)
    for number in range(2 * BINS):
        inside = first & (cell == number)
        if np.any(inside):
            predicted[cell == number] = np.mean(after[inside])
    gain = rms(after[second]) ** 2 - rms((after - predicted)[second]) ** 2
    return float(np.sqrt(max(gain, 0.0)))


def _slow_and_fast(motion: Motion, after: Array, second: Flags) -> tuple[float, float, float]:
    speed = np.abs(motion.speed_rad_s)
    limit = SLOW_SHARE * float(np.quantile(speed[second], 0.99))
    slow = speed < limit
    return limit, rms(after[second & slow]), rms(after[second & ~slow])


def _curved(found_in: Residue, used: list[Term], families: list[list[Term]]) -> tuple[float, float, float]:
    """Does friction bend with speed? Beside dry friction always, which alone would seem to bend."""
    if not any(term.effect == "viscous_friction" for term in used):
        return 1.0, 0.0, 0.0
    motion, y, rows = found_in.motion, found_in.y, found_in.rows
    names = {term.effect for term in used}
    used = [*used, *(family[0] for family in families[:1] if family[0].effect not in names)]
    term = Term("curvature", ("a_per_rad2_s2",), (effect_terms.curvature(motion),))
    found = fit_terms([*used, term], y, rows)
    name = "curvature.a_per_rad2_s2"
    drop = 1.0 - rms(found.residual) / max(rms(fit_terms(used, y, rows).residual), 1e-300)
    return found.p_value([name]), found[name], drop


def _drift(found_in: Residue, used: list[Term], nominal: Nominal | None) -> tuple[float, float]:
    """Does the dry friction change over the log? Relative change from its start to its end."""
    motion, y, rows = found_in.motion, found_in.y, found_in.rows
    span_s = motion.t_s[rows][-1] - motion.t_s[rows][0]
    ramp = (motion.t_s - np.mean(motion.t_s[rows])) / span_s
    dry = shaft_regression.dry_terms(motion, found_in.drive)[0]
    found = fit_terms(
        [*[t for t in used if t.effect != dry.effect], dry, Term("drift", ("a",), (ramp * dry.columns[0],))], y, rows
    )
    known_a = nominal.coulomb_a if nominal is not None else 0.0
    level = abs(found[f"{dry.effect}.torque_a_equiv"] + known_a)
    return (found["drift.a"] / level if level > 0.0 else 0.0), found.p_value(["drift.a"])
