"""Inductance that falls with the current, by the inverse square of the current at which it has halved."""

import math

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale


def hypothesis(scale: Scale) -> Hypothesis:
    amps = scale.rated_current_a

    def params(z: Array) -> Params:
        return {
            "i_sat_a": 1.0 / math.sqrt(float(z[0])) if z[0] > (1e-3 / amps) ** 2 else 0.0,
            "by_amplitude": float(z[1]),
            "by_slope": float(z[2]),
        }

    return Hypothesis(
        "inductance_saturation",
        (
            Coordinate("inverse_square", (0.35 / amps) ** 2, 0.0, (4.0 / amps) ** 2),
            Coordinate("by_amplitude", 0.3, 0.0, 1.0),
            Coordinate("by_slope", 0.3, 0.0, 1.0),
        ),
        params,
        lambda z: math.sqrt(max(float(z[0]), 0.0)) * amps / 0.15,
        ((0.0, 0.5, 0.5),),
    )
