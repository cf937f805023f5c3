"""What is hidden in a log of another drive: effects beyond what BENCH lets a unit be, and effects without a name."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from evenspin.blind import vocabulary
from evenspin.blind.bench_drives import Drive
from evenspin.blind.referee import FACTORS, Parameters

Values = dict[str, float]
Draw = Callable[[np.random.Generator, Drive, int], Values]

ELECTRICAL = ("dead_time", "winding_resistance", "inductance_saturation", "encoder_offset")  # only voltages show them
OF_THE_ANGLE = ("cogging", "misalignment", "flux_harmonics", "encoder_eccentricity", "current_offset", "current_gain")
SHAFT = ("two_mass", "backlash")
SHAFT_ROWS_HZ = 1000.0  # slower logs cannot show the resonance
UNLOGGED_LOAD = "unlogged_load"  # steps of a load machine whose torque is not in the log


def _about(rng: np.random.Generator, *sizes: float) -> Callable[[int], float]:
    return lambda size: sizes[size] * float(rng.uniform(0.85, 1.15))


def _of_rated_nm(effect: str, *sizes: float, sign: bool = False, phase: bool = False) -> Draw:
    def draw(rng: np.random.Generator, drive: Drive, size: int) -> Values:
        turned = float(rng.choice((-1.0, 1.0))) if sign else 1.0
        torque_nm = turned * _about(rng, *sizes)(size) * drive.meta["motor"]["rated_torque_nm"]
        if not phase:
            return {"torque_nm": torque_nm}
        return {"amplitude_nm": torque_nm, "phase_rad": float(rng.uniform(0.0, math.tau))}

    return draw


def _factor(*sizes: float, more: float = 0.5) -> Draw:
    def draw(rng: np.random.Generator, drive: Drive, size: int) -> Values:
        off = _about(rng, *sizes)(size)
        return {"factor": 1.0 + off if rng.uniform() < more else 1.0 / (1.0 + off)}

    return draw


def _cogging(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    found = _of_rated_nm("cogging", 0.01, 0.02, 0.045, phase=True)(rng, drive, size)
    motor = drive.meta["motor"]
    order = math.lcm(motor["slots"], 2 * motor["pole_pairs"]) if rng.uniform() < 0.8 else motor["slots"]
    return found | {"order": float(order)}


def _stribeck(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    found = _of_rated_nm("stribeck_friction", 0.02, 0.04, 0.08)(rng, drive, size)
    return found | {"speed_rad_s": float(rng.uniform(0.05, 0.15)) * drive.full_speed_rad_s}


def _misalignment(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    found = _of_rated_nm("misalignment", 0.012, 0.025, 0.06, phase=True)(rng, drive, size)
    return found | {"second_rel": float(rng.choice((0.0, 0.3, 0.6))), "phase2_rad": float(rng.uniform(0.0, math.tau))}


def _offset(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    offset_a = _about(rng, 0.02, 0.035, 0.07)(size) * drive.meta["motor"]["rated_current_a"]
    angle = rng.uniform(0.0, math.tau)
    return {"offset_a_a": float(offset_a * math.cos(angle)), "offset_b_a": float(offset_a * math.sin(angle))}


def _gain(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    half = 0.5 * float(rng.choice((-1.0, 1.0))) * _about(rng, 0.05, 0.08, 0.14)(size)
    return {"gain_a": 1.0 + half, "gain_b": 1.0 - half}


def _dead_time(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {"dead_time_s": _about(rng, 0.006, 0.012, 0.025)(size) / drive.meta["pwm_hz"]}


def _ripple(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {"torque_ripple_rel": _about(rng, 0.015, 0.03, 0.06)(size), "sign": float(rng.choice((-1.0, 1.0)))}


def _eccentricity(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {"amplitude_rad": _about(rng, 0.004, 0.008, 0.016)(size), "phase_rad": float(rng.uniform(0.0, math.tau))}


def _zero(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {"angle_el_rad": float(rng.choice((-1.0, 1.0))) * _about(rng, 0.3, 0.4, 0.55)(size)}


def _saturation(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {"i_sat_a": _about(rng, 2.0, 1.3, 0.9)(size) * drive.meta["motor"]["rated_current_a"]}


def _as_in_cases(name: str) -> Draw:
    return lambda rng, drive, size: {**vocabulary.EFFECTS, **vocabulary.OUTSIDE}[name](rng, drive.meta, size)


EFFECTS: dict[str, Draw] = {
    "current_offset": _offset,
    "current_gain": _gain,
    "dead_time": _dead_time,
    "cogging": _cogging,
    "flux_harmonics": _ripple,
    "coulomb_friction": _of_rated_nm("coulomb_friction", 0.02, 0.04, 0.08),
    "stribeck_friction": _stribeck,
    "viscous_friction": _factor(0.8, 1.5, 3.0, more=1.0),
    "inertia": _factor(0.12, 0.25, 0.5),
    "load_torque": _of_rated_nm("load_torque", 0.02, 0.04, 0.1, sign=True),
    "misalignment": _misalignment,
    "encoder_eccentricity": _eccentricity,
    "encoder_offset": _zero,
    "torque_constant": _factor(0.06, 0.1, 0.16, more=0.3),
    "winding_resistance": _factor(0.25, 0.4, 0.8, more=0.8),
    "inductance_saturation": _saturation,
    "two_mass": _as_in_cases("two_mass"),
    "backlash": _as_in_cases("backlash"),
}


def _fan(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {
        "torque_nm_s2": _about(rng, 0.06, 0.12, 0.25)(size)
        * drive.meta["motor"]["rated_torque_nm"]
        / drive.full_speed_rad_s**2
    }


def _unlogged_load(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {"torque_nm": _about(rng, 0.1, 0.2, 0.4)(size) * drive.meta["motor"]["rated_torque_nm"]}


# The second: only voltages show it.
OUTSIDE: dict[str, tuple[Draw, bool]] = {
    "fan_load": (_fan, False),
    "foreign_order_torque": (_as_in_cases("foreign_order_torque"), False),
    "friction_drift": (_as_in_cases("friction_drift"), False),
    "fixed_frequency_torque": (_as_in_cases("fixed_frequency_torque"), False),
    "torque_bursts": (_as_in_cases("torque_bursts"), False),
    UNLOGGED_LOAD: (_unlogged_load, False),
    "resistance_drift": (_as_in_cases("resistance_drift"), True),
    "phase_unbalance": (_as_in_cases("phase_unbalance"), True),
}


def true_values(effect: str, values: Values, hidden: Parameters, nominal: Parameters) -> Values:
    """What an effect is beside the model file, the deviation of the unit included: what an estimate has to hold."""
    if effect == "current_gain":
        return {f"gain_{x}": values[f"gain_{x}"] * hidden[f"sensor.gain_{x}"] for x in "ab"}
    if effect == "current_offset":
        return {f"offset_{x}_a": values[f"offset_{x}_a"] + hidden[f"sensor.offset_{x}_a"] for x in "ab"}
    if f"{effect}.factor" in FACTORS:
        name = FACTORS[f"{effect}.factor"]
        return {"factor": hidden[name] / nominal[name]}
    return values
