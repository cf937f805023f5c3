"""Drives of other makes on a bench: motor, controller, sensors; and how far the unit is from its model file.

A drive is a mapping {"motor": {...}, "pwm_hz", ...}, like meta.json of a case but with controllers that are not the
format's. Nothing here is shared with evenspin.log or with the search.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from evenspin.blind.referee import Parameters

PWM_HZ = (8000.0, 16000.0, 20000.0)
WINDINGS = ((12, 4), (12, 5), (18, 3), (36, 3), (9, 4), (12, 7), (24, 2), (9, 3), (6, 2), (36, 2), (24, 4))
DC_LINKS_V = (12.0, 24.0, 36.0, 48.0, 60.0, 80.0, 120.0, 160.0, 325.0, 560.0)
# How far a unit on a bench is from its model file, even within these bounds: relative, or a share of a rated value.
BENCH = {
    "resistance": 0.10,  # 25 K
    "inductance": 0.10,
    "flux": 0.02,
    "inertia": 0.04,
    "viscous": 0.25,
    "offset_of_rated": 0.005,  # of each current sensor
    "gain": 0.012,  # of each current sensor
    "electrical_zero_rad": 0.10,  # new at every power-up
    "dead_time_of_link": 0.0012,  # left by the compensation; 0 or more
    "coulomb_of_rated": 0.004,  # 0 or more
    "load_of_rated": 0.003,
    "cogging_of_rated": 0.002,  # 0 or more
    "eccentricity_rad": 0.0006,  # 0 or more
}


@dataclass(frozen=True, slots=True)
class Drive:
    """What the model file says, and how the drive is controlled."""

    meta: dict[str, Any]  # motor, dc_link_v, pwm_hz, encoder, noise
    controller: Parameters
    full_speed_rad_s: float

    @property
    def nm_per_a(self) -> float:
        return 1.5 * float(self.meta["motor"]["pole_pairs"]) * float(self.meta["motor"]["psi_wb"])


def _digits(value: float, digits: int = 3) -> float:
    return float(f"{value:.{digits}g}")


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw_drive(rng: np.random.Generator) -> Drive:
    while True:
        drive = _try_drive(rng)
        if drive is not None:
            return drive


def _try_drive(rng: np.random.Generator) -> Drive | None:
    pwm_hz = float(rng.choice(PWM_HZ))
    slots, pairs = WINDINGS[rng.integers(len(WINDINGS))]
    salient = rng.uniform() < 0.25
    resistance_ohm = _digits(_log_uniform(rng, 0.05, 5.0))
    ld_h = _digits(resistance_ohm * _log_uniform(rng, max(0.8e-3, 8.0 / pwm_hz), 6e-3))
    lq_h = _digits(ld_h * rng.uniform(1.4, 2.2)) if salient else ld_h
    rated_a = _digits(math.sqrt(_log_uniform(rng, 6.0, 150.0) / (1.5 * resistance_ohm)), 2)
    full_rad_s = _log_uniform(rng, 50.0, 220.0)
    psi_wb = _digits(rng.uniform(2.0, 8.0) * resistance_ohm * rated_a / (pairs * full_rad_s))
    torque_nm = _digits(1.5 * pairs * psi_wb * rated_a, 2)
    inertia_kgm2 = _digits(torque_nm / _log_uniform(rng, 1000.0, 6000.0), 2)
    speed_e_rad_s = pairs * full_rad_s
    need_v = math.sqrt(3.0) * math.hypot(
        speed_e_rad_s * psi_wb + resistance_ohm * rated_a, speed_e_rad_s * lq_h * rated_a
    )
    links = [link for link in DC_LINKS_V if link >= 1.2 * need_v]
    if not links or links[0] > 4.0 * need_v or speed_e_rad_s > 0.25 * pwm_hz:
        return None
    meta = {
        "motor": {
            "pole_pairs": pairs,
            "resistance_ohm": resistance_ohm,
            "ld_h": ld_h,
            "lq_h": lq_h,
            "psi_wb": psi_wb,
            "inertia_kgm2": inertia_kgm2,
            "viscous_nms": _digits(rng.uniform(0.02, 0.06) * torque_nm / full_rad_s, 2),
            "rated_current_a": rated_a,
            "rated_torque_nm": torque_nm,
            "slots": slots,
        },
        "dc_link_v": links[0],
        "pwm_hz": pwm_hz,
        "encoder": {"counts_per_rev": 2 ** int(rng.integers(12, 18))},
        "current_noise_a": _digits(0.003 * rated_a * rng.uniform(0.6, 1.6)),
        "current_lsb_a": 4.0 * _digits(rated_a * rng.uniform(0.8, 1.3), 2) / 4096.0,
    }
    return Drive(meta, _controller(rng, meta, salient, full_rad_s), full_rad_s)


def _controller(rng: np.random.Generator, meta: dict[str, Any], salient: bool, full_rad_s: float) -> Parameters:
    motor, pwm_hz = meta["motor"], float(meta["pwm_hz"])
    nm_per_a = 1.5 * motor["pole_pairs"] * motor["psi_wb"]
    current_rad_s = 2.0 * math.pi * pwm_hz * rng.uniform(0.02, 0.04)
    speed_rad_s = 2.0 * math.pi * rng.uniform(4.0, 15.0)
    tracking_rad_s = 2.0 * math.pi * rng.uniform(40.0, 120.0)
    computation = float(rng.uniform() < 0.75)
    sensorless = rng.uniform() < 0.15
    difference = not sensorless and rng.uniform() < 0.5
    speed_kp = speed_rad_s * motor["inertia_kgm2"] / nm_per_a
    return {
        "other.in_use": 1.0,
        "other.computation_periods": computation,
        "other.speed_by_difference": float(difference),
        "other.speed_filter_s": float(rng.uniform(0.5e-3, 3e-3)),
        "other.angle_from_pll": float(sensorless),
        "other.angle_delay_s": float(rng.uniform(0.5, 2.5)) / pwm_hz if sensorless else 0.0,
        "other.speed_loop_ip": float(rng.uniform() < 0.4),
        "other.most_torque_per_ampere": float(salient),
        "other.feed_forward": float(rng.choice((0.0, 1.0))),
        "other.psi_wb": motor["psi_wb"],
        "other.ld_h": motor["ld_h"],
        "other.lq_h": motor["lq_h"],
        "drive.current_kp_v_per_a": current_rad_s * motor["ld_h"],
        "drive.current_ki_v_per_as": current_rad_s * motor["resistance_ohm"],
        "drive.angle_advance_periods": (0.5 + computation) * float(rng.uniform() < 0.75),
        "drive.speed_periods": round(pwm_hz / 1000.0) * float(rng.choice((0.5, 1.0, 2.0))),
        "drive.speed_kp_a_per_rad_s": speed_kp,
        "drive.speed_ki_a_per_rad": speed_kp * speed_rad_s / rng.uniform(4.0, 7.0),
        "drive.iq_limit_a": 1.5 * motor["rated_current_a"],
        "drive.pll_kp": 2.0 * tracking_rad_s,
        "drive.pll_ki": tracking_rad_s**2,
    }


def nominal_of(drive: Drive) -> Parameters:
    """The referee's parameters of the model file, with the sensors' noise."""
    meta, motor = drive.meta, drive.meta["motor"]
    own = {f"motor.{key}": float(value) for key, value in motor.items() if key not in ("rated_torque_nm", "slots")}
    return (
        own
        | drive.controller
        | {
            "bridge.dc_link_v": meta["dc_link_v"],
            "bridge.pwm_hz": meta["pwm_hz"],
            "sensor.counts_per_rev": float(meta["encoder"]["counts_per_rev"]),
            "sensor.current_noise_a": meta["current_noise_a"],
            "sensor.current_lsb_a": meta["current_lsb_a"],
            "sensor.vdc_noise_v": meta["dc_link_v"] / 1500.0,
            "sensor.vdc_filter_s": 2e-3,
            "sensor.load_noise_nm": 0.006 * motor["rated_torque_nm"],
            "run.step_s": 12.5e-6,
        }
    )


def draw_bench_unit(rng: np.random.Generator, drive: Drive, nominal: Parameters) -> Parameters:
    """A unit on a bench: what BENCH says, every bound drawn evenly."""
    motor = drive.meta["motor"]
    rated_a, rated_nm = motor["rated_current_a"], motor["rated_torque_nm"]

    def both(key: str) -> float:
        return float(rng.uniform(-BENCH[key], BENCH[key]))

    def above(key: str) -> float:
        return float(rng.uniform(0.0, BENCH[key]))

    inductance = 1.0 + both("inductance")
    unit = dict(nominal)
    unit["motor.resistance_ohm"] *= 1.0 + both("resistance")
    unit["motor.ld_h"] *= inductance
    unit["motor.lq_h"] *= inductance
    unit["motor.psi_wb"] *= 1.0 + both("flux")
    unit["motor.inertia_kgm2"] *= 1.0 + both("inertia")
    unit["motor.viscous_nms"] *= 1.0 + both("viscous")
    for sensor in "ab":
        unit[f"sensor.offset_{sensor}_a"] = both("offset_of_rated") * rated_a
        unit[f"sensor.gain_{sensor}"] = 1.0 + both("gain")
    return unit | {
        "encoder_offset.angle_el_rad": both("electrical_zero_rad"),
        "dead_time.dead_time_s": above("dead_time_of_link") / drive.meta["pwm_hz"],
        "dead_time.soft_a": 0.01 * rated_a,
        "coulomb_friction.torque_nm": above("coulomb_of_rated") * rated_nm,
        "load_torque.torque_nm": both("load_of_rated") * rated_nm,
        "cogging.amplitude_nm": above("cogging_of_rated") * rated_nm,
        "cogging.order": float(math.lcm(motor["slots"], 2 * motor["pole_pairs"])),
        "cogging.phase_rad": float(rng.uniform(0.0, math.tau)),
        "encoder_eccentricity.amplitude_rad": above("eccentricity_rad"),
        "encoder_eccentricity.phase_rad": float(rng.uniform(0.0, math.tau)),
    }
