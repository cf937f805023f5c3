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


def flux_wb(params: Params, psi_wb: float, theta_e_rad: Array) -> tuple[Array, Array]:
    ripple_wb = params.get("sign", 1.0) * params["torque_ripple_rel"] * psi_wb
    d_wb = -(1.0 - 2.0 * params.get("fifth_share", 0.5)) * ripple_wb * np.sin(6.0 * theta_e_rad)
    return d_wb, ripple_wb * np.cos(6.0 * theta_e_rad)
