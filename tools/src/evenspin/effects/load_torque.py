"""A constant torque of one direction."""

from evenspin.effects.hypothesis import Hypothesis, Scale, single


def hypothesis(scale: Scale) -> Hypothesis:
    torque = scale.rated_torque_nm
    return single("load_torque", "torque_nm", 0.02 * torque, -torque, torque, scale.small_torque_nm)
