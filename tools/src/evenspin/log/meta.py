"""meta.json: nominal motor data and controller, with the keys of the measured-log format."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from evenspin.model.setup import Setup
from evenspin.native import tables

MOTOR_KEYS = (
    "pole_pairs",
    "resistance_ohm",
    "ld_h",
    "lq_h",
    "psi_wb",
    "inertia_kgm2",
    "viscous_nms",
    "rated_current_a",
    "rated_torque_nm",
    "slots",
)
FILTER_TYPES = {"pll": "tracking_pll", "mt": "mt", "fir": "fir"}


def meta_of(setup: Setup, case: str, experiments: Sequence[str]) -> dict[str, Any]:
    """What the log states about the drive: nominal values, never the hidden effects."""
    plant, drive = setup.plant, setup.drive
    current_ts_s = 1.0 / plant["pwm_hz"]
    speed_ts_s = drive["speed_divider"] * current_ts_s
    unit = drive["speed_error_gain"]  # gains are per unit of the error; the format wants them per mechanical rad/s
    source = tables().params["speed_source"].to_text(drive["speed_source"])
    limit_v = drive["voltage_limit_v"]
    return {
        "case": case,
        "motor": {key: _number(key, plant[key]) for key in MOTOR_KEYS},
        "dc_link_v": plant["dc_link_v"],
        "pwm_hz": plant["pwm_hz"],
        "encoder": {"counts_per_rev": _number("counts_per_rev", plant["counts_per_rev"])},
        "current_loop": {
            "ts_s": current_ts_s,
            "kp_v_per_a": drive["current_kp_v_per_a"],
            "ki_v_per_as": drive["current_ki_v_per_as"],
            "computation_delay_periods": 1,
            "angle_advance_periods": drive["angle_advance_periods"],
            "v_limit": limit_v if limit_v > 0.0 else "dc_link_v/sqrt(3)",
        },
        "speed_loop": {
            "ts_s": speed_ts_s,
            "kp_a_per_rad_s": drive["speed_kp_a_per_unit"] * unit,
            "ki_a_per_rad": drive["speed_ki_a_per_unit_s"] * unit,
            "iq_limit_a": drive["iq_limit_a"],
        },
        "speed_filter": {
            "type": FILTER_TYPES[source],
            "ts_s": speed_ts_s if source == "mt" else current_ts_s,
            "kp": drive["pll_kp_per_s"],
            "ki": drive["pll_ki_per_s2"],
        },
        "current_noise_a": plant["current_noise_a"],
        "current_lsb_a": plant["current_lsb_a"],
        "experiments": list(experiments),
    }


def _number(key: str, value: float) -> float | int:
    """Whole numbers are written as such."""
    return int(value) if tables().model[key].kind == "integer" else value
