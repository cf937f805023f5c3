"""Fifth and seventh harmonic of the magnet flux."""

import math

import numpy as np

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale


def hypothesis(scale: Scale) -> Hypothesis:
    return Hypothesis(
        "flux_harmonics",
        (Coordinate("ripple", 0.02, -0.5, 0.5), Coordinate("unequal", 0.02, -0.5, 0.5)),
        _params,
        lambda z: float(np.hypot(*z)) / 0.003,
        ((0.0, 0.0),),
    )


def orders(scale: Scale) -> tuple[int, ...]:
    return (6 * scale.pole_pairs,)


def _params(z: Array) -> Params:
    """Ripple of the q axis and of the d axis; the second is (1 - 2 fifth_share) of the first."""
    ripple = float(z[0]) if abs(z[0]) > 0.2 * abs(z[1]) else math.copysign(0.2 * abs(float(z[1])), float(z[0]))
    share = 0.5 * (1.0 - float(z[1]) / ripple) if ripple != 0.0 else 0.5
    return {"torque_ripple_rel": abs(ripple), "sign": math.copysign(1.0, ripple), "fifth_share": share}
