"""Gains of the current sensors."""

from evenspin.effects.hypothesis import Coordinate, Hypothesis, Scale


def hypothesis(scale: Scale) -> Hypothesis:
    """Only the mismatch counts: a common gain is not distinguishable from the torque constant."""
    return Hypothesis(
        "current_gain",
        (Coordinate("gain_a", 0.03, -0.5, 0.5), Coordinate("gain_b", 0.03, -0.5, 0.5)),
        lambda z: {"gain_a": 1.0 + float(z[0]), "gain_b": 1.0 + float(z[1])},
        lambda z: abs(float(z[0] - z[1])) / 0.008,
        ((0.0, 0.0),),
    )


def orders(scale: Scale) -> tuple[int, ...]:
    return (2 * scale.pole_pairs,)
