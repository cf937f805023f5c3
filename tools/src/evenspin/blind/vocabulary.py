"""What can be hidden in a blind case: the effects of the table at three sizes, and effects that it does not have.

How large and at which order an effect is drawn is this module's own on purpose: it checks what the search assumes.

Sizes are relative to the motor. The smallest is outside the tolerance of a unit; whether it can be found at all is
shown by `gap_alone` in the truth file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np

from evenspin.native import tables

SIZES = ("small", "medium", "large")
KINDS = ("single", "pair", "triple", "none", "outside", "beside")  # beside: a known effect, and one outside
UNKNOWN = "unknown"

Motor = Mapping[str, Any]  # meta.json of the case
Values = dict[str, float]
Draw = Callable[[np.random.Generator, Motor, int], Values]


def _about(rng: np.random.Generator, *sizes: float) -> Callable[[int], float]:
    """One of the sizes, give or take 15 %."""
    return lambda size: sizes[size] * rng.uniform(0.85, 1.15)


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice((-1.0, 1.0)))


def _phase(rng: np.random.Generator) -> float:
    return float(rng.uniform(0.0, 2.0 * math.pi))


def _rated(meta: Motor) -> tuple[float, float]:
    return meta["motor"]["rated_current_a"], meta["motor"]["rated_torque_nm"]


def cogging_order(motor: Mapping[str, Any]) -> int:
    return math.lcm(int(motor["slots"]), 2 * int(motor["pole_pairs"]))


def _current_offset(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    rated_a, _ = _rated(meta)
    offset_a = max((0.03, 0.04, 0.06)[size], _about(rng, 0.01, 0.02, 0.05)(size) * rated_a)
    angle = _phase(rng)
    return {"offset_a_a": offset_a * math.cos(angle), "offset_b_a": offset_a * math.sin(angle)}


def _current_gain(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    half = 0.5 * _sign(rng) * _about(rng, 0.015, 0.03, 0.06)(size)
    return {"gain_a": 1.0 + half, "gain_b": 1.0 - half}


def _dead_time(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"dead_time_s": _about(rng, 0.9e-6, 1.7e-6, 3.2e-6)(size)}


def _cogging(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    _, torque_nm = _rated(meta)
    order = cogging_order(meta["motor"])
    if rng.uniform() < 0.15:  # a single uneven magnet or tooth
        order = int(meta["motor"]["slots"])
    amplitude_nm = _about(rng, 0.008, 0.015, 0.04)(size) * torque_nm
    return {"amplitude_nm": amplitude_nm, "phase_rad": _phase(rng), "order": float(order)}


def _flux_harmonics(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"torque_ripple_rel": _about(rng, 0.012, 0.025, 0.05)(size), "sign": _sign(rng)}


def _coulomb(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"torque_nm": _about(rng, 0.012, 0.03, 0.06)(size) * _rated(meta)[1]}


def _stribeck(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {
        "torque_nm": _about(rng, 0.015, 0.03, 0.06)(size) * _rated(meta)[1],
        "speed_rad_s": float(rng.uniform(4.0, 14.0)),
    }


def _factor(*sizes: float, more: float = 1.0) -> Draw:
    """A factor as far above or below 1 as a size says; `more`: share of those above."""

    def draw(rng: np.random.Generator, meta: Motor, size: int) -> Values:
        off = _about(rng, *sizes)(size)
        return {"factor": 1.0 + off if rng.uniform() < more else 1.0 / (1.0 + off)}

    return draw


def _load_torque(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"torque_nm": _sign(rng) * _about(rng, 0.015, 0.03, 0.08)(size) * _rated(meta)[1]}


def _misalignment(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    second = 0.0 if rng.uniform() < 1.0 / 3.0 else float(rng.uniform(0.2, 0.8))
    return {
        "amplitude_nm": _about(rng, 0.01, 0.02, 0.05)(size) * _rated(meta)[1],
        "phase_rad": _phase(rng),
        "second_rel": second,
        "phase2_rad": _phase(rng) if second else 0.0,
    }


def _eccentricity(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"amplitude_rad": _about(rng, 0.003, 0.007, 0.015)(size), "phase_rad": _phase(rng)}


def _encoder_offset(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    count_el_rad = 2.0 * math.pi / meta["encoder"]["counts_per_rev"] * meta["motor"]["pole_pairs"]
    return {"angle_el_rad": _sign(rng) * max(_about(rng, 0.035, 0.07, 0.15)(size), count_el_rad)}


def _delay(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"extra_periods": (0.5, 1.0, 2.0)[size]}


def _saturation(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"i_sat_a": _about(rng, 3.0, 1.8, 1.1)(size) * _rated(meta)[0]}


def _of_total(load_over_rotor: float) -> float:
    """Inertia of the load over the total, as the effects count it."""
    return load_over_rotor / (1.0 + load_over_rotor)


def _two_mass(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {
        "f_res_hz": float(np.exp(rng.uniform(np.log(40.0), np.log(180.0)))),
        "load_ratio": _of_total(_about(rng, 0.3, 0.8, 2.0)(size)),
        "damping_ratio": float(rng.uniform(0.02, 0.08)),
    }


def _backlash(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {
        "gap_rad": _about(rng, 0.012, 0.025, 0.06)(size),
        "load_ratio": _of_total(float(rng.uniform(0.4, 2.0))),
        "f_res_hz": float(rng.uniform(80.0, 220.0)),
        "damping_ratio": float(rng.uniform(0.05, 0.2)),
    }


def _current_filter(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"tau_s": _about(rng, 40e-6, 80e-6, 160e-6)(size)}


EFFECTS: dict[str, Draw] = {
    "current_offset": _current_offset,
    "current_gain": _current_gain,
    "dead_time": _dead_time,
    "cogging": _cogging,
    "flux_harmonics": _flux_harmonics,
    "coulomb_friction": _coulomb,
    "stribeck_friction": _stribeck,
    "viscous_friction": _factor(0.15, 0.3, 0.7, more=0.6),
    "inertia": _factor(0.06, 0.12, 0.25, more=0.5),
    "load_torque": _load_torque,
    "misalignment": _misalignment,
    "encoder_eccentricity": _eccentricity,
    "encoder_offset": _encoder_offset,
    "current_loop_delay": _delay,
    "torque_constant": _factor(0.02, 0.04, 0.09, more=0.3),
    "winding_resistance": _factor(0.05, 0.12, 0.3, more=0.75),
    "inductance_saturation": _saturation,
    "two_mass": _two_mass,
    "backlash": _backlash,
    "current_filter": _current_filter,
}


def go_together(names: Collection[str]) -> bool:
    """There is one shaft."""
    effects = tables().effects
    return sum(name in effects and effects[name].acts_on == "shaft" for name in set(names)) < 2


def _fixed_frequency(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {
        "amplitude_nm": _about(rng, 0.02, 0.04, 0.08)(size) * _rated(meta)[1],
        "frequency_hz": float(rng.uniform(6.0, 45.0)),
        "phase_rad": _phase(rng),
    }


def _foreign_order(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    p = int(meta["motor"]["pole_pairs"])
    known = {1, 2, p, 2 * p, 6 * p, int(meta["motor"]["slots"]), cogging_order(meta["motor"])}
    order = rng.choice([n for n in (2.5, 3.6, 5, 7, 7.5, 9, 11, 13, 3.05, 4.95) if n not in known])
    amplitude_nm = _about(rng, 0.015, 0.03, 0.06)(size) * _rated(meta)[1]
    return {"amplitude_nm": amplitude_nm, "phase_rad": _phase(rng), "order": float(order)}


def _resistance_drift(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"rise_rel": _about(rng, 0.15, 0.25, 0.4)(size), "time_s": float(rng.uniform(10.0, 25.0))}


def _friction_drift(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    torque_nm = _about(rng, 0.03, 0.06, 0.12)(size) * _rated(meta)[1]
    return {"torque_nm": torque_nm, "time_s": float(rng.uniform(5.0, 15.0))}


def _supply_ripple(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"amplitude_rel": _about(rng, 0.03, 0.06, 0.1)(size), "frequency_hz": float(rng.choice((100.0, 120.0)))}


def _supply_dips(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"depth_rel": _about(rng, 0.15, 0.25, 0.4)(size), "rate_hz": 2.0, "length_s": 0.03}


def _fan(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    full_rad_s = 20.0 * math.pi
    return {"torque_nm_s2": _about(rng, 0.06, 0.12, 0.25)(size) * _rated(meta)[1] / full_rad_s**2}


def _bursts(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"amplitude_nm": _about(rng, 0.08, 0.15, 0.3)(size) * _rated(meta)[1], "rate_hz": 2.5, "length_s": 0.02}


def _count_loss(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    turns = 30.0  # farthest from the start, in the staircase
    per_count_el_rad = 2.0 * math.pi / meta["encoder"]["counts_per_rev"] * meta["motor"]["pole_pairs"]
    lost = _about(rng, 0.25, 0.45, 0.8)(size) / (turns * per_count_el_rad)
    return {"counts_per_turn": _sign(rng) * lost}


def _code_wheel(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    p = int(meta["motor"]["pole_pairs"])
    known = {6 * p, int(meta["motor"]["slots"]), cogging_order(meta["motor"])}
    order = float(rng.choice([n for n in range(13, 48) if n not in known and n % p]))
    return {"amplitude_rad": _about(rng, 0.05, 0.1, 0.2)(size) / order, "phase_rad": _phase(rng), "order": order}


def _cubic(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"error_rel": -_about(rng, 0.05, 0.09, 0.15)(size)}


def _unbalance(rng: np.random.Generator, meta: Motor, size: int) -> Values:
    return {"rise_rel": _about(rng, 0.15, 0.3, 0.6)(size)}


OUTSIDE: dict[str, Draw] = {
    "fixed_frequency_torque": _fixed_frequency,
    "foreign_order_torque": _foreign_order,
    "resistance_drift": _resistance_drift,
    "friction_drift": _friction_drift,
    "supply_ripple": _supply_ripple,
    "fan_load": _fan,
    "torque_bursts": _bursts,
    "encoder_code_wheel": _code_wheel,
    "phase_unbalance": _unbalance,
    "sensor_cubic": _cubic,
    "encoder_count_loss": _count_loss,
    "supply_dips": _supply_dips,
}
