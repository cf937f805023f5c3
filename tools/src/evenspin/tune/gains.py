"""Parameters of the drive from bandwidths, each as large as its goal, its margins and its encoder allow."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from evenspin.errors import InputError
from evenspin.model.machine import DRIVE_FROM_PLANT
from evenspin.native import tables
from evenspin.tune.corners import Ranges, corners, range_of
from evenspin.tune.goals import CURRENT_WORST_DEG, CURRENT_WORST_GAIN, DEFAULT, GOALS, SPEED_GAIN, Goal
from evenspin.tune.loops import NONE, Margins, current_margins, speed_loop, speed_margins

Numbers = Mapping[str, float]

STEP = 0.85  # of a bandwidth, when the one before was too much
SLOWEST = 1e-3  # of the first bandwidth
MOST_GAIN = 1e3
MOTION_SHARE = 1.0 / 256.0  # of over_speed_rad_s: what the motion check takes for a motion
MOTION_TORQUE = 0.1  # of the largest torque: what a load may leave for the acceleration
STALL_RAD = 2.0 * math.pi / 256.0
PLL_HZ, FINE_PLL_HZ, FINE_COUNTS = 100.0, 300.0, 50_000.0  # a fine encoder leaves the tracking filter little to smooth


@dataclass(frozen=True)
class Gains:
    """Parameters, what they came from, and the margins: of the model as it is, and the worst of its tolerances."""

    drive: dict[str, float]
    comments: dict[str, str]
    current: Mapping[str, Margins]
    current_worst: Margins
    speed: Margins
    speed_worst: Margins
    worst_case: str
    remarks: list[str] = field(default_factory=list)


def complete(drive: Numbers) -> dict[str, float]:
    """With the defaults of what is not stated."""
    return {name: each.default for name, each in tables().params.items()} | dict(drive)


def model_parameters(plant: Numbers) -> dict[str, float]:
    """What a drive knows of its motor."""
    found = {name: plant[source] for name, source in DRIVE_FROM_PLANT.items()}
    return {
        name: min(max(value, tables().params[name].minimum), tables().params[name].maximum)
        for name, value in found.items()
    }


def first_gains(plant: Numbers, limits: Numbers, ranges: Ranges, goal: Goal = GOALS[DEFAULT]) -> Gains:
    """Current, speed, observers and position; no simulation. `plant` may leave out what a simulation alone needs."""
    plant = {name: each.default for name, each in tables().model.items()} | dict(plant)
    drive = dict(limits) | model_parameters(plant)
    comments: dict[str, str] = {}
    current, worst_current = _current(plant, ranges, goal, drive, comments)
    rated_a = plant["rated_current_a"] or 0.5 * drive["iq_limit_a"]
    speed, worst_speed, worst_case = _speed(plant, ranges, goal, drive, comments, rated_a)
    _observers(plant, drive, comments)
    _position(plant, goal, drive, comments, rated_a)
    _motion(plant, drive, comments)
    return Gains(rounded(drive), comments, current, worst_current, speed, worst_speed, worst_case)


def rounded(drive: Numbers) -> dict[str, float]:
    """Five digits, within the range of each parameter."""
    found = {}
    for name, value in drive.items():
        limits = tables().params[name]
        number = float(value) if limits.kind != "float" else float(f"{value:.6g}")
        found[name] = min(max(number, limits.minimum), limits.maximum)
    return found


# ---- current


def _current(
    plant: Numbers, ranges: Ranges, goal: Goal, drive: dict[str, float], comments: dict[str, str]
) -> tuple[dict[str, Margins], Margins]:
    """k_p = w L, k_i = w R; the smaller inductance, since both axes have the same gains."""
    inductance, resistance = min(plant["ld_h"], plant["lq_h"]), plant["resistance_ohm"]
    w = 2.0 * math.pi * goal.current_hz
    while w > SLOWEST * 2.0 * math.pi * goal.current_hz:
        kp = w * inductance
        ki = max(w * resistance, kp * w / 20.0)  # a slow winding would leave a long tail after a change of the back-EMF
        nominal = {axis: current_margins(plant, axis, kp, ki) for axis in "dq"}
        if kp <= MOST_GAIN and all(m.phase_deg >= goal.current_margin_deg and m.gain >= 2.0 for m in nominal.values()):
            worst = _worst_current(plant, ranges, kp, ki)
            if worst.phase_deg >= CURRENT_WORST_DEG and worst.gain >= CURRENT_WORST_GAIN:
                drive["current_kp_v_per_a"], drive["current_ki_v_per_as"] = kp, ki
                comments["current_kp_v_per_a"] = f"w min(Ld, Lq), w = 2 pi {w / (2.0 * math.pi):.0f} Hz"
                comments["current_ki_v_per_as"] = "w R" if ki == w * resistance else "k_p w / 20: the winding is slow"
                return nominal, worst
        w *= STEP
    raise InputError("tune", "current loop", f"{goal.current_hz:g} Hz", "possible with its margins", "check R and L")


def _worst_current(plant: Numbers, ranges: Ranges, kp: float, ki: float) -> Margins:
    found = []
    for axis in "dq":
        for inductance in range_of(f"l{axis}_h", plant, ranges):
            for resistance in range_of("resistance_ohm", plant, ranges):
                machine = {**plant, f"l{axis}_h": inductance, "resistance_ohm": resistance}
                found.append(current_margins(machine, axis, kp, ki))
    return min(found, key=lambda margins: margins.phase_deg)


# ---- speed


def _speed(
    plant: Numbers, ranges: Ranges, goal: Goal, drive: dict[str, float], comments: dict[str, str], rated_a: float
) -> tuple[Margins, Margins, str]:
    """k_p = w J / K_t, k_i = w k_p / ratio; judged at a slow and at a fast speed of the whole sampled loop."""
    per_a = 1.5 * plant["pole_pairs"] * plant["psi_wb"]
    unit = min(max(plant["pole_pairs"], 1.0), 100.0)
    counts = plant["counts_per_rev"] or drive["encoder_counts"]
    drive |= {"speed_divider": 10.0, "speed_inline": 0.0, "speed_error_gain": unit}
    comments["speed_error_gain"] = "electrical rad/s"
    ts_s = drive["speed_divider"] / plant["pwm_hz"]
    count = 2.0 * math.pi / (counts * ts_s)  # rad/s of a count in a sample
    _speed_source(drive, comments, counts)
    most_kp = goal.count_current_part * rated_a / count
    first = w = 2.0 * math.pi * goal.speed_hz
    speeds = (min(2.0 * count, 0.3 * drive["over_speed_rad_s"]), 0.5 * drive["over_speed_rad_s"])
    machines = corners(plant, ranges)
    while w > SLOWEST * first:
        kp = w * plant["inertia_kgm2"] / per_a
        if kp > most_kp:
            w = min(most_kp * per_a / plant["inertia_kgm2"], w * 0.999)
            comments["speed_kp_a_per_unit"] = "as much as the encoder allows"
            kp = w * plant["inertia_kgm2"] / per_a
        drive["speed_kp_a_per_unit"] = kp / unit
        drive["speed_ki_a_per_unit_s"] = kp * w / (goal.integral_ratio * unit)
        nominal = min((_speed_margins(plant, drive, v) for v in speeds), key=lambda m: m.distance)
        if nominal.phase_deg >= goal.speed_margin_deg and nominal.gain >= SPEED_GAIN:
            worst = {name: _speed_margins(machine, drive, speeds[0]) for name, machine in machines.items()}
            name = min(worst, key=lambda key: worst[key].distance)
            if worst[name].distance >= goal.corner_distance:
                text = comments.get("speed_kp_a_per_unit", "")
                of = f"w J / K_t, w = 2 pi {w / (2.0 * math.pi):.3g} Hz"
                comments["speed_kp_a_per_unit"] = f"{of}, {text}" if text else of
                comments["speed_ki_a_per_unit_s"] = f"k_p w / {goal.integral_ratio:g}"
                return nominal, worst[name], name
        w *= STEP
    raise InputError("tune", "speed loop", f"{goal.speed_hz:g} Hz", "possible with its margins", "check J and psi")


def _speed_source(drive: dict[str, float], comments: dict[str, str], counts: float) -> None:
    """M/T is right at every speed."""
    drive["speed_source"] = tables().params["speed_source"].to_number("mt")
    w = 2.0 * math.pi * (FINE_PLL_HZ if counts >= FINE_COUNTS else PLL_HZ)
    drive |= {"pll_kp_per_s": 2.0 * w, "pll_ki_per_s2": w * w}
    comments["pll_kp_per_s"] = f"tracking filter of {w / (2.0 * math.pi):g} Hz"


def _speed_margins(plant: Numbers, drive: Numbers, speed_rad_s: float) -> Margins:
    loop = speed_loop(plant, complete(drive), speed_rad_s)
    return speed_margins(loop) if loop.radius < 1.0 else NONE


# ---- observers, position, protection of the motion


def _observers(plant: Numbers, drive: dict[str, float], comments: dict[str, str]) -> None:
    lag = plant["lq_h"] / drive["current_kp_v_per_a"] * plant["pwm_hz"]  # time constant of the current loop, periods
    drive["observer_actuation_samples"] = min(max(1.5 + lag, 0.5), 12.0)
    comments["observer_actuation_samples"] = "1.5 and the time constant of the current loop"


def _position(plant: Numbers, goal: Goal, drive: dict[str, float], comments: dict[str, str], rated_a: float) -> None:
    unit = drive["speed_error_gain"]
    per_a = 1.5 * plant["pole_pairs"] * plant["psi_wb"]
    kv = 0.8 * drive["speed_kp_a_per_unit"] * unit
    w = kv * per_a / plant["inertia_kgm2"]
    drive["position_kv_a_per_rad_s"] = kv
    drive["position_ti_s"] = min(max(2.0 * goal.integral_ratio / w, 1e-4), 100.0)
    drive["position_kp_per_s"] = w / 5.0
    ts_s = drive["speed_divider"] / plant["pwm_hz"]
    drive["ilc_lead"] = min(max(round(2.0 / (w * ts_s)), 1), 31)
    comments["ilc_lead"] = "delay of the velocity loop"
    comments["position_kv_a_per_rad_s"] = f"velocity loop of {w / (2.0 * math.pi):.3g} Hz, 0.8 of the speed loop"
    comments["position_kp_per_s"] = "a fifth of the velocity loop"
    speed = drive["profile_speed_rad_s"]
    acceleration = 0.3 * per_a * drive["iq_limit_a"] / plant["inertia_kgm2"]
    drive["profile_accel_rad_s2"] = min(acceleration, 1e6)
    comments["profile_accel_rad_s2"] = "0.3 of the largest torque over the inertia"
    drive["following_error_rad"] = min(max(3.0 * speed / drive["position_kp_per_s"], 0.1), 100.0)
    comments["following_error_rad"] = "three times the lag at profile_speed_rad_s"
    cutoff = tables().params["src_cutoff_per_rad"].default
    drive["src_period_turn"] = 1.0 - math.sqrt(2.0) / cutoff / (2.0 * math.pi)
    comments["src_period_turn"] = "whatever repeats once a turn"


def _motion(plant: Numbers, drive: dict[str, float], comments: dict[str, str]) -> None:
    """A heavy machine needs longer until its motion shows."""
    per_a = 1.5 * plant["pole_pairs"] * plant["psi_wb"]
    slow = MOTION_TORQUE * per_a * drive["iq_limit_a"] / plant["inertia_kgm2"]  # rad/s^2
    drive["speed_deviation_s"] = min(max(0.036, MOTION_SHARE * drive["over_speed_rad_s"] / slow), 60.0)
    drive["stall_s"] = min(max(0.08, 2.0 * math.sqrt(2.0 * STALL_RAD / slow)), 60.0)
    comments["speed_deviation_s"] = comments["stall_s"] = "a tenth of the largest torque would show a motion by then"
