"""Dry friction of constant size, and what it is at standstill, which differs from machine to machine."""

import math

import numpy as np

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale

OFF = 0.0  # of the coordinates of a form
SMOOTH_RAD_S, PRESLIDING_RAD = 0.02, 1e-4  # below these a form hardly shows; its coordinate is logarithmic beyond
SMOOTH_MOST_RAD_S, PRESLIDING_MOST_RAD = 5.0, 0.1


def _coordinate(value: float, least: float) -> float:
    return math.log1p(value / least)


def _value(z: float, least: float) -> float:
    return least * math.expm1(float(z))


HOLDS: dict[int, float] = {1: OFF, 2: OFF}
RISES = [{1: _coordinate(speed, SMOOTH_RAD_S), 2: OFF} for speed in (0.1, 0.5, 2.0)]
BENDS = [{1: OFF, 2: _coordinate(travel, PRESLIDING_RAD)} for travel in (1e-3, 1e-2)]


def hypothesis(scale: Scale) -> Hypothesis:
    torque = scale.rated_torque_nm
    return Hypothesis(
        "coulomb_friction",
        (
            Coordinate("torque_nm", 0.02 * torque, 0.0, torque),
            Coordinate("log_smooth", 0.5, OFF, _coordinate(SMOOTH_MOST_RAD_S, SMOOTH_RAD_S), form=True),
            Coordinate("log_presliding", 0.5, OFF, _coordinate(PRESLIDING_MOST_RAD, PRESLIDING_RAD), form=True),
        ),
        _params,
        lambda z: abs(float(z[0])) / scale.small_torque_nm,
        ((0.0, OFF, OFF),),
        variants=(HOLDS, *RISES, *BENDS),
    )


def _params(z: Array) -> Params:
    leasts = {"smooth_rad_s": SMOOTH_RAD_S, "presliding_rad": PRESLIDING_RAD}
    forms = zip(leasts.items(), z[1:], strict=True)
    form = {name: _value(x, least) for (name, least), x in forms if x > OFF and z[0] > 0.0}
    return {"torque_nm": float(z[0]), **form}


def brake_nm(params: Params, theta_m_rad: Array, speed_rad_s: Array, direction: Array) -> Array:
    """Sliding: a form that bends does so within a few encoder counts."""
    smooth_rad_s = params.get("smooth_rad_s", 0.0)
    share = np.tanh(np.abs(speed_rad_s) / smooth_rad_s) if smooth_rad_s > 0.0 else 1.0
    return np.asarray(params["torque_nm"] * direction * share)
