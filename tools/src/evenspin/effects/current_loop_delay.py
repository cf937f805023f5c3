"""PWM periods beyond the nominal delay."""

from evenspin.effects.hypothesis import Hypothesis, Scale, single


def hypothesis(scale: Scale) -> Hypothesis:
    return single("current_loop_delay", "extra_periods", 0.3, 0.0, 6.0, 0.03)
