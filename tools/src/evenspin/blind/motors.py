"""Motors that never were, with a drive designed for them by the rules of the format's example drive.

Current loop: kp = w_c L, ki = w_c R. Speed loop: kp = w_s J / (1.5 p psi), ki = kp w_s / 5, iq limit 1.6 x rated.
Tracking filter: double pole at w_f. Bandwidths vary around 400, 12 and 60 Hz.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

WINDINGS = (  # slots, pole pairs
    (12, 4),
    (12, 5),
    (18, 3),
    (36, 3),
    (24, 4),
    (27, 3),
    (9, 4),
    (12, 7),
    (24, 2),
    (36, 2),
    (24, 10),
    (24, 11),
    (9, 3),
    (6, 2),
    (48, 4),
    (18, 8),
)
DC_LINKS_V = (24.0, 36.0, 48.0, 60.0, 72.0, 96.0, 120.0, 150.0, 200.0, 270.0, 325.0)
ENCODER_COUNTS = (1000, 1024, 2000, 2048, 2500, 4000, 4096, 5000, 8000, 8192, 10000, 16384)
FULL_SPEED_RAD_S = 600.0 * math.pi / 30.0
PWM_HZ = 10000.0


def _digits(value: float, digits: int = 3) -> float:
    """As a data sheet would say it."""
    return float(f"{value:.{digits}g}")


def draw_motor(rng: np.random.Generator) -> dict[str, Any]:
    """meta.json of a drive, without its name and experiments."""
    while True:
        meta = _try_motor(rng)
        if meta is not None:
            return meta


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _try_motor(rng: np.random.Generator) -> dict[str, Any] | None:
    slots, pole_pairs = WINDINGS[rng.integers(len(WINDINGS))]
    resistance_ohm = _digits(_log_uniform(rng, 0.1, 5.0))
    l_h = _digits(resistance_ohm * _log_uniform(rng, 0.8e-3, 5e-3))
    salient = rng.uniform() < 0.15  # most motors of this kind have their magnets on the surface
    lq_h = _digits(l_h * rng.uniform(1.1, 1.4)) if salient else l_h
    rated_a = _digits(math.sqrt(_log_uniform(rng, 10.0, 80.0) / (1.5 * resistance_ohm)), 2)
    emf_v = rng.uniform(1.5, 6.0) * resistance_ohm * rated_a  # at full speed
    psi_wb = _digits(emf_v / (pole_pairs * FULL_SPEED_RAD_S))
    nm_per_a = 1.5 * pole_pairs * psi_wb
    torque_nm = _digits(nm_per_a * rated_a, 2)
    inertia_kgm2 = _digits(torque_nm / _log_uniform(rng, 1500.0, 6000.0), 2)
    viscous_nms = _digits(rng.uniform(0.02, 0.08) * torque_nm / FULL_SPEED_RAD_S, 2)

    # Loaded with 60 % of the rated torque at full speed, and the largest step of the locked rotor.
    drop_v = math.hypot(
        pole_pairs * FULL_SPEED_RAD_S * psi_wb + 0.6 * resistance_ohm * rated_a,
        0.6 * pole_pairs * FULL_SPEED_RAD_S * lq_h * rated_a,
    )
    need_v = math.sqrt(3.0) * max(drop_v, 1.3 * resistance_ohm * rated_a) * rng.uniform(1.4, 2.6)
    links = [link for link in DC_LINKS_V if link >= need_v]
    if not links or not 0.1e-3 <= l_h <= 10e-3:
        return None

    current_rad_s = 2.0 * math.pi * rng.uniform(300.0, 480.0)
    speed_rad_s = 2.0 * math.pi * rng.uniform(8.0, 16.0)
    filter_rad_s = 2.0 * math.pi * rng.uniform(45.0, 80.0)
    speed_kp = speed_rad_s * inertia_kgm2 / nm_per_a
    return {
        "motor": {
            "pole_pairs": pole_pairs,
            "resistance_ohm": resistance_ohm,
            "ld_h": l_h,
            "lq_h": lq_h,
            "psi_wb": psi_wb,
            "inertia_kgm2": inertia_kgm2,
            "viscous_nms": viscous_nms,
            "rated_current_a": rated_a,
            "rated_torque_nm": torque_nm,
            "slots": slots,
        },
        "dc_link_v": links[0],
        "pwm_hz": PWM_HZ,
        "encoder": {"counts_per_rev": int(rng.choice(ENCODER_COUNTS))},
        "current_loop": {
            "ts_s": 1.0 / PWM_HZ,
            "kp_v_per_a": current_rad_s * l_h,
            "ki_v_per_as": current_rad_s * resistance_ohm,
            "computation_delay_periods": 1,
            "angle_advance_periods": 1.5,
            "v_limit": "dc_link_v/sqrt(3)",
        },
        "speed_loop": {
            "ts_s": 0.001,
            "kp_a_per_rad_s": speed_kp,
            "ki_a_per_rad": speed_kp * speed_rad_s / rng.uniform(4.0, 6.0),
            "iq_limit_a": 1.6 * rated_a,
        },
        "speed_filter": {
            "type": "tracking_pll",
            "ts_s": 1.0 / PWM_HZ,
            "kp": 2.0 * filter_rad_s,
            "ki": filter_rad_s**2,
        },
        "current_noise_a": _digits(0.003 * rated_a * rng.uniform(0.6, 1.6)),
        "current_lsb_a": 4.0 * _digits(rated_a * rng.uniform(0.8, 1.3), 2) / 2048.0,
    }
