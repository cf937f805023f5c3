"""Flux linkage over its nominal value; its tolerance has a sigma of 0.4 %."""

from evenspin.effects.hypothesis import Hypothesis, Scale, factor


def hypothesis(scale: Scale) -> Hypothesis:
    return factor("torque_constant", 0.04, 0.012)
