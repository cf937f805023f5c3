"""The controller of the measured-log format: PI loops, speed loop inside the current interrupt, tracking filter.

What else the drive can do would hide what a log is to show.
"""

from __future__ import annotations

from evenspin.log.meta_numbers import MetaNumbers
from evenspin.native import tables

FORMAT_CONTROLLER = {"method": "pi", "current_controller": "pi", "speed_source": "pll", "speed_inline": "true"}
NO_LIMIT = 1e3  # protection of a drive that is only re-simulated: out of reach


def format_controller() -> dict[str, float]:
    """FORMAT_CONTROLLER as the drive's parameters take it."""
    params = tables().params
    return {name: 1.0 if word == "true" else params[name].to_number(word) for name, word in FORMAT_CONTROLLER.items()}


def controller_of(meta: MetaNumbers) -> dict[str, float]:
    """Parameters of the drive that a meta.json describes, without start-up and without protection."""
    counts = meta.number("encoder", "counts_per_rev")
    return {
        **format_controller(),
        "pole_pairs": meta.number("motor", "pole_pairs"),
        "encoder_counts": counts if counts > 0.0 else 65536.0,
        "current_kp_v_per_a": meta.number("current_loop", "kp_v_per_a"),
        "current_ki_v_per_as": meta.number("current_loop", "ki_v_per_as"),
        "voltage_limit_v": meta.voltage_limit_v(),
        "angle_advance_periods": meta.number("current_loop", "angle_advance_periods"),
        "pll_kp_per_s": meta.number("speed_filter", "kp"),
        "pll_ki_per_s2": meta.number("speed_filter", "ki"),
        "speed_divider": round(meta.number("speed_loop", "ts_s") * meta.number("pwm_hz")),
        "speed_error_gain": 1.0,
        "speed_kp_a_per_unit": meta.number("speed_loop", "kp_a_per_rad_s"),
        "speed_ki_a_per_unit_s": meta.number("speed_loop", "ki_a_per_rad"),
        "iq_limit_a": meta.number("speed_loop", "iq_limit_a"),
        "id_limit_a": NO_LIMIT,
        "over_current_a": NO_LIMIT,
        "over_voltage_v": NO_LIMIT,
        "under_voltage_v": 0.0,
        "over_speed_rad_s": 2000.0,
        "offset_calibration_periods": 0.0,
        "align_periods": 0.0,
        "auto_run": 1.0,
        "plausibility_share": 0.0,
    }
