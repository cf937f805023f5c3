"""Offsets of the current sensors."""

from evenspin.effects.hypothesis import Hypothesis, Scale, pair


def hypothesis(scale: Scale) -> Hypothesis:
    """Counts from 28 mA on: what the calibration at the start leaves."""
    amps = scale.rated_current_a
    return pair("current_offset", ("offset_a_a", "offset_b_a"), 0.01 * amps, 0.028, amps)


def orders(scale: Scale) -> tuple[int, ...]:
    return (scale.pole_pairs,)
