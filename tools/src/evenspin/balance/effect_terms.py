"""The candidates: effects of the simulator's table as columns of the torque balance.

A balance sees torque on the shaft and nothing else, so only these effects can be identified. Each has the name of the
table, with the columns that it adds and what its coefficients must be like to be that effect.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.motion import Motion

Array = NDArray[np.float64]

STRIBECK_SHARES = (0.02, 0.03, 0.045, 0.07, 0.1, 0.15, 0.22, 0.33)  # of the highest speed: candidates for w_s
STEPS_BELOW_STRIBECK = 4.0  # speed changes per row by less than w_s over this, or no row has low speed


@dataclass(frozen=True, slots=True)
class Term:
    """Coefficients `keys` times `columns`. `must`: why these values are not that effect, or None."""

    effect: str
    keys: tuple[str, ...]
    columns: tuple[Array, ...]
    must: Callable[[Sequence[float]], str | None] = lambda values: None
    extra: tuple[tuple[str, float], ...] = ()


def positive(what: str) -> Callable[[Sequence[float]], str | None]:
    def check(values: Sequence[float]) -> str | None:
        return None if values[0] > 0.0 else f"wrong sign: {what}"

    return check


def coulomb(motion: Motion) -> Term:
    column = motion.smooth(np.sign(motion.raw_speed_rad_s))
    return Term("coulomb_friction", ("torque_a_equiv",), (column,), positive("friction would drive"))


def drag(motion: Motion, effect: str) -> Term:
    """Friction or load of one direction, or of one speed: the log does not separate them."""
    return Term(effect, ("torque_a_equiv",), (motion.smooth(np.sign(motion.raw_speed_rad_s)),))


def load(motion: Motion) -> Term:
    return Term("load_torque", ("torque_a_equiv",), (motion.smooth(np.ones_like(motion.t_s)),))


def stribeck(motion: Motion, speed_rad_s: float) -> Term:
    w = motion.raw_speed_rad_s
    column = motion.smooth(np.sign(w) * np.exp(-((w / speed_rad_s) ** 2)))
    check = positive("friction grows less than linearly with speed, the opposite of a Stribeck rise at low speed")
    return Term("stribeck_friction", ("torque_a_equiv",), (column,), check, (("speed_rad_s", speed_rad_s),))


def stribeck_family(motion: Motion) -> list[Term]:
    """One term per Stribeck speed that the log can show."""
    w = motion.raw_speed_rad_s
    top = float(np.quantile(np.abs(w[motion.good]), 0.99))
    step = float(np.median(np.abs(np.diff(w[motion.good]))))
    return [stribeck(motion, share * top) for share in STRIBECK_SHARES if share * top > STEPS_BELOW_STRIBECK * step]


def line(motion: Motion, order: float) -> Term:
    """What repeats with the angle; `angle_orders` judges it; here it keeps the other coefficients unbiased."""
    assert motion.theta_rad is not None
    columns = tuple(motion.smooth(f(order * motion.theta_rad)) for f in (np.sin, np.cos))
    return Term(f"line_{order:g}", ("sin_a", "cos_a"), columns)


def viscous(motion: Motion) -> Term:
    return Term("viscous_friction", ("viscous_as_per_rad",), (motion.speed_rad_s,))


def inertia(motion: Motion) -> Term:
    return Term("inertia", ("inertia_as2_per_rad",), (motion.accel_rad_s2,))


def curvature(motion: Motion) -> Array:
    """Not an effect of the table: friction that bends with speed, over all speeds."""
    w = motion.raw_speed_rad_s
    return motion.smooth(w * np.abs(w))
