"""Inductance that falls with the current, by the inverse square of the current at which it has halved."""

import math

import numpy as np

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale

PER_AXIS, BY_AMPLITUDE, BY_SLOPE = {1: 0.0, 2: 0.0}, {1: 1.0, 2: 0.0}, {1: 0.0, 2: 1.0}


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
        variants=(PER_AXIS, BY_AMPLITUDE, BY_SLOPE),
    )


SLOPE_LEAST = 0.01  # of the nominal inductance, deep in saturation


def linkage_wb(params: Params, l_h: float, i_a: Array, other_a: Array) -> Array:
    i_sat_a = params["i_sat_a"]
    if i_sat_a == 0.0:
        return l_h * i_a
    end = math.sqrt(1.0 / SLOPE_LEAST - 1.0)
    x, y = i_a / i_sat_a, other_a / i_sat_a
    within = np.clip(x, -end, end)
    own = l_h * i_sat_a * (np.arctan(within) + SLOPE_LEAST * (x - within))
    slope = l_h * np.maximum(1.0 / (1.0 + x * x), SLOPE_LEAST)
    both = l_h * np.maximum(1.0 / (1.0 + x * x + y * y), SLOPE_LEAST)
    own = own + params.get("by_slope", 0.0) * (slope * i_a - own)
    return np.asarray(own + params.get("by_amplitude", 0.0) * (both * i_a - own))
