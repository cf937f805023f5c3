"""Gains of the current sensors."""

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale


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


def current_error_a(params: Params, ia_a: Array, ib_a: Array) -> tuple[Array, Array]:
    return (1.0 - 1.0 / params["gain_a"]) * ia_a, (1.0 - 1.0 / params["gain_b"]) * ib_a
