"""A wrong electrical zero."""

from evenspin.effects.hypothesis import Hypothesis, Scale, single


def hypothesis(scale: Scale) -> Hypothesis:
    return single("encoder_offset", "angle_el_rad", 0.05, -1.4, 1.4, 0.01)
