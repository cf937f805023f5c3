"""A low-pass in the current measurement."""

from evenspin.effects.hypothesis import Hypothesis, Scale, single


def hypothesis(scale: Scale) -> Hypothesis:
    return single("current_filter", "tau_s", 3e-5, 0.0, 3e-3, 5e-6)
