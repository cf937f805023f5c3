"""Torque once and twice per turn of the shaft."""

import numpy as np

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale, polar


def hypothesis(scale: Scale) -> Hypothesis:
    probe = 0.02 * scale.rated_torque_nm
    return Hypothesis(
        "misalignment",
        (
            Coordinate("sine", probe),
            Coordinate("cosine", probe),
            Coordinate("sine2", probe, beside=0),
            Coordinate("cosine2", probe, beside=0),
        ),
        _params,
        lambda z: float(np.linalg.norm(z)) / scale.small_torque_nm,
        ((0.0,) * 4,),
    )


def orders(scale: Scale) -> tuple[int, ...]:
    return (1, 2)


def _params(z: Array) -> Params:
    first, second = polar(z[:2], "a", "p"), polar(z[2:], "a", "p")
    amplitude = max(first["a"], 2e-6 * second["a"], 1e-12)
    return {
        "amplitude_nm": amplitude,
        "phase_rad": first["p"],
        "second_rel": second["a"] / amplitude,
        "phase2_rad": second["p"],
    }


def brake_nm(params: Params, theta_m_rad: Array, speed_rad_s: Array, direction: Array) -> Array:
    first = np.sin(theta_m_rad + params.get("phase_rad", 0.0))
    second = np.sin(2.0 * theta_m_rad + params.get("phase2_rad", 0.0))
    return np.asarray(params["amplitude_nm"] * (first + params.get("second_rel", 0.0) * second))
