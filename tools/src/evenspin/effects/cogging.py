"""Cogging: a torque tied to the angle, at an order that slots and poles make."""

import math

import numpy as np

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale, polar


def hypothesis(scale: Scale) -> Hypothesis:
    """At `scale.cogging_order`, else that of slots and poles, else 6 per electrical turn."""
    torque = scale.rated_torque_nm
    made = slot_order(scale.pole_pairs, scale.slots) if scale.slots > 0 else 6 * scale.pole_pairs
    order = float(scale.cogging_order or made)
    return Hypothesis(
        "cogging",
        (Coordinate("sine", 0.02 * torque), Coordinate("cosine", 0.02 * torque)),
        lambda z: {**polar(z, "amplitude_nm", "phase_rad"), "order": order},
        lambda z: float(np.hypot(*z)) / scale.small_torque_nm,
        ((0.0, 0.0),),
        rests=True,
    )


def orders(scale: Scale) -> tuple[int, ...]:
    return (slot_order(scale.pole_pairs, scale.slots), scale.slots) if scale.slots > 0 else ()


def slot_order(pole_pairs: int, slots: int) -> int:
    """Cogging periods per turn: least common multiple of slots and poles."""
    return math.lcm(slots, 2 * pole_pairs)


def brake_nm(params: Params, theta_m_rad: Array, speed_rad_s: Array, direction: Array) -> Array:
    angle = params["order"] * theta_m_rad + params.get("phase_rad", 0.0)
    return np.asarray(params["amplitude_nm"] * np.sin(angle))
