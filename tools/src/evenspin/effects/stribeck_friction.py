"""More dry friction at standstill than in motion."""

import math

import numpy as np

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale


def hypothesis(scale: Scale) -> Hypothesis:
    """Nonlinear in the Stribeck speed: from a grid of it, with the amplitude by a linear fit."""
    torque = scale.rated_torque_nm
    return Hypothesis(
        "stribeck_friction",
        (
            Coordinate("torque_nm", 0.02 * torque, 0.0, torque, 0.02 * torque),
            Coordinate("log_speed", 0.1, math.log(0.1), math.log(60.0), 0.5),
        ),
        lambda z: {"torque_nm": float(z[0]), "speed_rad_s": math.exp(float(z[1])), "shape": 2.0},
        lambda z: abs(float(z[0])) / scale.small_torque_nm,
        tuple((0.03 * torque, math.log(w)) for w in (0.8, 2.5, 6.0, 15.0)),
        linear=False,
        amplitude=0,
    )


def brake_nm(params: Params, theta_m_rad: Array, speed_rad_s: Array, direction: Array) -> Array:
    low = np.abs(speed_rad_s / params["speed_rad_s"]) ** params.get("shape", 2.0)
    return np.asarray(params["torque_nm"] * direction * np.exp(-low))
