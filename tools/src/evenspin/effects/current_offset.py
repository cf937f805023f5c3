"""Offsets of the current sensors."""

import numpy as np

from evenspin.effects.hypothesis import Array, Hypothesis, Params, Scale, pair


def hypothesis(scale: Scale) -> Hypothesis:
    """Counts from 28 mA on: what the calibration at the start leaves."""
    amps = scale.rated_current_a
    return pair("current_offset", ("offset_a_a", "offset_b_a"), 0.01 * amps, 0.028, amps)


def orders(scale: Scale) -> tuple[int, ...]:
    return (scale.pole_pairs,)


def current_error_a(params: Params, ia_a: Array, ib_a: Array) -> tuple[Array, Array]:
    return np.full_like(ia_a, params["offset_a_a"]), np.full_like(ib_a, params["offset_b_a"])
