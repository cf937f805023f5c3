"""Dead time of the bridge, and how its loss goes through zero current, which differs from inverter to inverter."""

import numpy as np

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale

EDGES_LEAST = 0.02  # a smaller share of the loss at edges is none: the simulation is faster without


def hypothesis(scale: Scale) -> Hypothesis:
    amps = scale.rated_current_a
    return Hypothesis(
        "dead_time",
        (
            Coordinate("dead_time_s", 1e-6, 0.0, 1.9e-5),
            Coordinate("soft_a", 0.01 * amps, 0.0, 0.05 * amps),
            Coordinate("by_edges", 0.3, 0.0, 1.0),
        ),
        _params,
        lambda z: abs(float(z[0])) / 1e-7,
        ((0.0, 0.005 * amps, 0.5 * EDGES_LEAST),),
    )


def orders(scale: Scale) -> tuple[int, ...]:
    return (6 * scale.pole_pairs,)


def _params(z: Array) -> Params:
    by_edges = float(z[2]) if z[2] > EDGES_LEAST else 0.0
    shape = {"soft_a": float(z[1]), "by_edges": by_edges} if z[0] > 0.0 else {}
    return {"dead_time_s": float(z[0]), **shape}


def lost_v(params: Params, i_a: Array, dc_link_v: Array, pwm_hz: float) -> Array:
    """Mean loss of a phase over a period; how edges share it does not show in rows slower than the PWM."""
    soft_a = max(params.get("soft_a", 0.0), 1e-9)
    return np.asarray(params["dead_time_s"] * pwm_hz * dc_link_v * np.tanh(i_a / soft_a))
