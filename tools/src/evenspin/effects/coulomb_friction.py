"""Dry friction of constant size."""

from evenspin.effects.hypothesis import Array, Hypothesis, Params, Scale, single


def hypothesis(scale: Scale) -> Hypothesis:
    torque = scale.rated_torque_nm
    return single("coulomb_friction", "torque_nm", 0.02 * torque, 0.0, torque, scale.small_torque_nm)


def brake_nm(params: Params, theta_m_rad: Array, speed_rad_s: Array, direction: Array) -> Array:
    return params["torque_nm"] * direction
