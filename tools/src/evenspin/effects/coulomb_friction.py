"""Dry friction of constant size, and what it is at standstill, which differs from machine to machine."""

import numpy as np

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale

OFF = 0.0  # of the coordinates of a form
SMOOTH_RAD_S, PRESLIDING_RAD = 0.2, 2e-3  # where the search of a form begins
HOLDS, RISES, BENDS = {1: OFF, 2: OFF}, {1: SMOOTH_RAD_S, 2: OFF}, {1: OFF, 2: PRESLIDING_RAD}


def hypothesis(scale: Scale) -> Hypothesis:
    torque = scale.rated_torque_nm
    return Hypothesis(
        "coulomb_friction",
        (
            Coordinate("torque_nm", 0.02 * torque, 0.0, torque),
            Coordinate("smooth_rad_s", 0.1, OFF, 5.0, form=True),
            Coordinate("presliding_rad", 1e-3, OFF, 0.1, form=True),
        ),
        _params,
        lambda z: abs(float(z[0])) / scale.small_torque_nm,
        ((0.0, OFF, OFF),),
        variants=(HOLDS, RISES, BENDS),
    )


def _params(z: Array) -> Params:
    names = ("smooth_rad_s", "presliding_rad")
    form = {name: float(x) for name, x in zip(names, z[1:], strict=True) if x > OFF and z[0] > 0.0}
    return {"torque_nm": float(z[0]), **form}


def brake_nm(params: Params, theta_m_rad: Array, speed_rad_s: Array, direction: Array) -> Array:
    """Sliding: a form that bends does so within a few encoder counts."""
    smooth_rad_s = params.get("smooth_rad_s", 0.0)
    share = np.tanh(np.abs(speed_rad_s) / smooth_rad_s) if smooth_rad_s > 0.0 else 1.0
    return np.asarray(params["torque_nm"] * direction * share)
