"""Inertia and friction of the shaft together with the lines over the angle, in one regression.

Left out, a line bends the inertia (a shaft that cogs also speeds up and slows down with it), and a wrong inertia bends
the line. Smoothing decides the rest: noise of the angle enters acceleration and pulls the inertia towards zero, so that
several widths are tried, and what the estimate still does from one to the next is part of its interval.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance import effect_terms
from evenspin.balance.effect_terms import Term
from evenspin.balance.line_search import Views
from evenspin.balance.motion import Motion
from evenspin.balance.nominal_model import Nominal
from evenspin.balance.regression import Fit, fit, inflation
from evenspin.balance.stretches import Stretches
from evenspin.balance.time_grid import Flags

Array = NDArray[np.float64]

LADDER_S = (2.5e-3, 5e-3, 10e-3, 20e-3, 40e-3, 80e-3)
ROWS_PER_SIGMA = 2  # neighbouring smoothed rows repeat each other: this many of each width are used
STILL_SHARE = 0.01  # of the highest speed: a rotor slower than this for long may stick, and friction is then anything
ONE_WAY = 0.03  # share of the rows in the other direction, below which a log has one direction
ONE_SPEED = 100.0  # inflation of the speed by its sign: the range of the speeds is a third of the highest, or less
MACHINE = 0.03  # of a value: what one machine differs by from one log to the next
TRIM = 0.05  # of the rows, at either end of the speeds
LEAST_ROWS = 60
CLOSE = 1.5  # of the logarithm of the half widths
SHORT_S = 10e-3  # where a log is short of such rows, as short as is best
ALL_NOISE = 1e-6
WIDER = 2  # steps of the ladder that a step is held against
INERTIA, VISCOUS = "inertia.inertia_as2_per_rad", "viscous_friction.viscous_as_per_rad"


@dataclass(frozen=True, slots=True)
class Drive:
    """What the log drives: which parts of the friction are separable."""

    one_way: bool
    one_speed: bool

    @property
    def sweeps(self) -> bool:
        return not self.one_speed

    def drag(self) -> tuple[str, ...]:
        """Names that this log does not separate."""
        names: tuple[str, ...] = ("coulomb_friction",)
        names += ("load_torque",) if self.one_way else ()
        return names + (("viscous_friction",) if self.one_speed else ())

    @property
    def friction(self) -> str:
        """The drag as an effect, or as several that it may be."""
        return " or ".join(self.drag())

    def separator(self) -> str:
        """The experiment that would."""
        if self.one_way and self.one_speed:
            return "several speeds in both directions"
        return "the same speeds in the other direction" if self.one_way else "several speeds"


def drive_of(motion: Motion, stretches: Stretches) -> Drive:
    rows = moving_rows(motion, stretches)
    return drive_of_speeds(stretches.slow_rad_s[rows])


def drive_of_speeds(slow: Array) -> Drive:
    """From the speeds at which friction is defined, slow enough for their ripple to be gone."""
    if len(slow) == 0:
        return Drive(one_way=True, one_speed=True)
    backward = float(np.mean(slow < 0.0))
    one_way = min(backward, 1.0 - backward) < ONE_WAY
    low, high = np.quantile(np.abs(slow), (TRIM, 1.0 - TRIM))  # a start or a stop is no second speed
    slow = slow[(np.abs(slow) >= low) & (np.abs(slow) <= high)]
    sign = np.sign(slow)
    return Drive(one_way, inflation(slow, [sign] if one_way else [sign, np.ones_like(sign)]) > ONE_SPEED)


def moving_rows(motion: Motion, stretches: Stretches) -> Flags:
    """Rows at which friction is defined: the rotor turns, in a direction that is certain."""
    w = motion.raw_speed_rad_s
    used = motion.good & ~stretches.idle
    if not np.any(used):
        return used
    top = float(np.quantile(np.abs(w[used]), 0.99))
    still = motion.smooth((np.abs(w) < STILL_SHARE * top).astype(float)) > 0.8
    return used & ~still & motion.sure_sign


def thinned(rows: Flags, motion: Motion) -> Flags:
    stride = max(1, int(motion.smooth.sigma_s / motion.smooth.period_s / ROWS_PER_SIGMA))
    return rows & (np.arange(len(rows)) % stride == 0)


def names_of(used: Sequence[Term]) -> list[str]:
    return [f"{term.effect}.{key}" for term in used for key in term.keys]


def fit_terms(used: Sequence[Term], y: Array, rows: Flags) -> Fit:
    return fit(names_of(used), [column[rows] for term in used for column in term.columns], y[rows])


def dry_terms(motion: Motion, drive: Drive) -> list[Term]:
    """Friction and load as far as the log separates them; the first is the friction."""
    first = (
        effect_terms.coulomb(motion)
        if drive.friction == "coulomb_friction"
        else effect_terms.drag(motion, drive.friction)
    )
    return [first] if drive.one_way else [first, effect_terms.load(motion)]


def base_terms(motion: Motion, drive: Drive) -> list[Term]:
    return [effect_terms.inertia(motion), *([] if drive.one_speed else [effect_terms.viscous(motion)])]


def known_part(motion: Motion, nominal: Nominal | None) -> Array:
    """The current that the model accounts for, A."""
    if nominal is None:
        return np.zeros_like(motion.iq_a)
    known = nominal.inertia_as2 * motion.accel_rad_s2 + nominal.viscous_as * motion.speed_rad_s
    dry = nominal.friction(motion.raw_speed_rad_s)
    if motion.theta_rad is not None:
        dry = dry + sum(line(motion.theta_rad) for line in nominal.lines)
    return known + motion.smooth(dry)


def corrected(used: Sequence[Term], found: Fit, motion: Motion, y: Array, rows: Flags) -> Array:
    """The coefficients without what noise of the angle does to acceleration and speed (corrected least squares)."""
    columns = [column[rows] for term in used for column in term.columns]
    noise = np.array(
        [{INERTIA: motion.accel_noise, VISCOUS: motion.speed_noise}.get(name, 0.0) for name in found.names]
    )
    x = np.column_stack(columns)
    scale = np.sqrt(np.mean(x**2, axis=0)) + 1e-30
    less = (x / scale).T @ (x / scale) / len(x) - np.diag((noise / scale) ** 2)
    right = (x / scale).T @ y[rows] / len(x)
    if np.min(np.diag(less)[noise > 0.0], initial=1.0) <= 0.0 or np.linalg.eigvalsh(less)[0] < -ALL_NOISE:
        return np.where(noise > 0.0, np.inf, found.value)  # all of it is noise
    return np.linalg.pinv(less, rcond=1e-10, hermitian=True) @ right / scale


@dataclass(frozen=True, slots=True)
class Step:
    """One width of the ladder."""

    sigma_s: float
    value: dict[str, float]
    half: dict[str, float]
    moved: dict[str, float]  # by the correction for noise of the angle


def fit_ladder(
    motions: Views, nominal: Nominal | None, drive: Drive, orders: Sequence[float], stretches: Stretches,
    used: Callable[[Motion], list[Term]] | None = None, ladder_s: Sequence[float] = LADDER_S,
) -> list[Step]:  # fmt: skip
    """The same regression at several widths of the smoothing."""
    steps = []
    for sigma_s in ladder_s:
        motion = motions(sigma_s, 0.0)
        rows = thinned(moving_rows(motion, stretches), motion)
        if np.count_nonzero(rows) < LEAST_ROWS:
            continue
        chosen = used(motion) if used else [*base_terms(motion, drive), *dry_terms(motion, drive)]
        chosen += [effect_terms.line(motion, order) for order in orders]
        y = motion.iq_a - known_part(motion, nominal)
        found = fit_terms(chosen, y, rows)
        moved = np.abs(corrected(chosen, found, motion, y, rows) - found.value)
        steps.append(
            Step(
                sigma_s,
                dict(zip(found.names, found.value.tolist(), strict=True)),
                {name: found.half(name) for name in found.names},
                dict(zip(found.names, moved.tolist(), strict=True)),
            )
        )
    return steps


def half_width(steps: Sequence[Step], at: int, name: str) -> float:
    """Half width at this step: its scatter, the noise of the angle, and the difference to wider smoothing."""
    step = steps[at]
    own = math.hypot(step.half[name], step.moved[name])
    others = steps[at + 1 : at + 1 + WIDER] or steps[max(at - 1, 0) : at]
    against = 0.0
    for other in others:  # the wider its interval, the less it counts
        its = math.hypot(other.half[name], other.moved[name])
        against = max(against, abs(other.value[name] - step.value[name]) * own / max(math.hypot(own, its), 1e-300))
    return math.hypot(own, against) if math.isfinite(own) else own


def best_steps(steps: Sequence[Step]) -> tuple[int, int]:
    """Where inertia and friction together are known best, and the shortest smoothing that knows them half as well.

    What is passed quickly, such as friction at low speed, shows at short smoothing only.
    """
    names = [name for name in steps[0].value if not name.startswith("line")]

    def spread(at: int) -> float:
        return float(np.sum([np.log(max(half_width(steps, at, name), 1e-300)) for name in names]))

    sums = np.array([spread(i) for i in range(len(steps))])
    best = int(np.argmin(sums))
    close = sums <= sums[best] + CLOSE * len(names)
    return best, next((i for i in range(len(steps)) if steps[i].sigma_s >= SHORT_S and close[i]), best)
