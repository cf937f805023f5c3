"""A wrong electrical zero."""

import numpy as np

from evenspin.effects.hypothesis import Array, Hypothesis, Params, Scale, single


def hypothesis(scale: Scale) -> Hypothesis:
    return single("encoder_offset", "angle_el_rad", 0.05, -1.4, 1.4, 0.01)


def angle_error_rad(params: Params, theta_m_rad: Array, pole_pairs: float) -> Array:
    return np.full_like(theta_m_rad, params["angle_el_rad"] / pole_pairs)
