"""An encoder disc off centre."""

import math

import numpy as np

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale, polar


def hypothesis(scale: Scale) -> Hypothesis:
    """Counts from a quarter of a count on, and from 0.2 mrad."""
    edge = max(2e-4, 0.25 * math.tau / max(scale.counts_per_rev, 1.0))
    return Hypothesis(
        "encoder_eccentricity",
        (Coordinate("sine", 0.003, -0.4, 0.4), Coordinate("cosine", 0.003, -0.4, 0.4)),
        lambda z: polar(z, "amplitude_rad", "phase_rad"),
        lambda z: float(np.hypot(*z)) / edge,
        ((0.0, 0.0),),
    )


def orders(scale: Scale) -> tuple[int, ...]:
    return (1,)


def angle_error_rad(params: Params, theta_m_rad: Array, pole_pairs: float) -> Array:
    return np.asarray(params["amplitude_rad"] * np.sin(theta_m_rad + params.get("phase_rad", 0.0)))
