"""A constant torque of one direction."""

import numpy as np

from evenspin.effects.hypothesis import Array, Hypothesis, Params, Scale, single


def hypothesis(scale: Scale) -> Hypothesis:
    torque = scale.rated_torque_nm
    return single("load_torque", "torque_nm", 0.02 * torque, -torque, torque, scale.small_torque_nm)


def brake_nm(params: Params, theta_m_rad: Array, speed_rad_s: Array, direction: Array) -> Array:
    return np.full_like(speed_rad_s, params["torque_nm"])
