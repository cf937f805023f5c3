"""Winding resistance over its nominal value; its tolerance has a sigma of 1.2 %."""

from evenspin.effects.hypothesis import Hypothesis, Scale, factor


def hypothesis(scale: Scale) -> Hypothesis:
    return factor("winding_resistance", 0.1, 0.036)
