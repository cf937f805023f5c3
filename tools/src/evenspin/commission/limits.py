"""What the owner of a motor knows: how much current, speed and voltage it bears.

And the parameters of a drive that knows no more than that.

Nothing of another motor is left in it: gains that are harmless for every winding, one pole pair, no flux, protection
from the limits. `motor_psi_wb` and `motor_lq_h` only say how large the surge of a start may become.
"""

from __future__ import annotations

from dataclasses import dataclass

from evenspin.errors import InputError
from evenspin.native import tables

ASKED_PART = 0.8  # of the largest current: what a loop may ask for; the rest is for its overshoot, and beyond it trips
OVER_VOLTAGE_PART = 1.25
UNDER_VOLTAGE_PART = 0.5
OVER_SPEED_PART = 1.25
ALIGN_PERIODS = 48_000
ALIGN_PART = 0.5  # of the largest current
KEPT = ("encoder_counts", "offset_limit_a", "offset_calibration_periods")  # of the board, not of a motor


@dataclass(frozen=True, slots=True)
class Bounds:
    """Peak of a phase, rad/s, V; 0: the owner does not say."""

    max_current_a: float
    max_speed_rad_s: float = 0.0
    max_voltage_v: float = 0.0

    def __post_init__(self) -> None:
        for name, value, most in (
            ("--max-current", self.max_current_a, 1000.0),
            ("--max-speed", self.max_speed_rad_s, 20000.0),
            ("--max-voltage", self.max_voltage_v, 1000.0),
        ):
            if not (0.0 < value <= most or (value == 0.0 and name != "--max-current")):
                raise InputError("commission", name, value, f"above 0 and at most {most:g}", "correct the value")


def blank(bounds: Bounds, supply_v: float, speed: float) -> dict[str, float]:
    """Parameters of a drive that knows its motor's limits and nothing else. `speed`: that trips it, rad/s."""
    limit = ASKED_PART * bounds.max_current_a
    over_v = bounds.max_voltage_v or OVER_VOLTAGE_PART * supply_v
    if over_v <= supply_v:
        raise InputError(
            "commission", "--max-voltage", over_v, f"above the supply, {supply_v:.4g} V", "raise it, or leave it out"
        )
    words = {"current_controller": "pi", "speed_source": "pll", "method": "pi", "position_method": "ppi"}
    numbers = {
        "pole_pairs": 1.0, "encoder_offset_rad": 0.0, "encoder_reversed": 0.0,
        "current_kp_v_per_a": 0.0, "current_ki_v_per_as": 0.0, "voltage_limit_v": 0.0,
        "motor_resistance_ohm": 0.0, "motor_ld_h": 1e-3, "motor_lq_h": 1e-3, "motor_psi_wb": 1e-6,
        "pll_kp_per_s": 754.0, "pll_ki_per_s2": 142122.0, "speed_divider": 10.0, "speed_inline": 0.0,
        "speed_error_gain": 1.0, "speed_kp_a_per_unit": 0.0, "speed_ki_a_per_unit_s": 0.0,
        "iq_limit_a": limit, "id_limit_a": limit, "observer_limit_a": limit,
        "over_current_a": bounds.max_current_a, "over_voltage_v": over_v,
        "under_voltage_v": UNDER_VOLTAGE_PART * supply_v,
        "over_speed_rad_s": speed, "profile_speed_rad_s": 0.5 * speed, "encoder_jump_rad": 0.05,
        "align_periods": float(ALIGN_PERIODS), "align_turns": 1.0, "align_rest_s": 20.0,
        "align_current_a": ALIGN_PART * limit,
        "zero_check": 0.0, "plausibility_share": 0.0, "auto_run": 0.0,
        "restart_limit": 0.0,  # a step that trips counts its attempts itself
    }  # fmt: skip
    numbers |= {name: tables().params[name].to_number(word) for name, word in words.items()}
    # Whatever else another motor may have needed is as the firmware has it.
    rest = {name: field.default for name, field in tables().params.items() if name not in KEPT}
    numbers = rest | numbers
    return {
        name: min(max(value, tables().params[name].minimum), tables().params[name].maximum)
        for name, value in numbers.items()
    }
