"""The limits of a drive for this motor, its supply and its board: what protects, and what it may ask for.

Not one of them is a default of another motor.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from evenspin.errors import InputError
from evenspin.native import tables

TRIP_PART = 1.35  # of the largest current that the loop may ask for: overshoot, ripple and noise stay below
OVER_VOLTAGE_PART = 1.25  # of the supply: what braking may add
UNDER_VOLTAGE_PART = 0.6
OVER_SPEED_PART = 1.25


@dataclass(frozen=True, slots=True)
class Limits:
    """What the limits are calculated from. Currents are peaks of a phase."""

    peak_current_a: float
    rated_current_a: float
    supply_v: float
    max_speed_rad_s: float
    board_current_a: float = 0.0  # 0: not known
    board_dc_link_v: float = 0.0


def limit_parameters(given: Limits) -> dict[str, float]:
    """[drive] parameters."""
    trip_a = TRIP_PART * given.peak_current_a
    if given.board_current_a > 0.0:
        trip_a = min(trip_a, given.board_current_a)
    peak_a = min(given.peak_current_a, trip_a / TRIP_PART)
    over_v = OVER_VOLTAGE_PART * given.supply_v
    if given.board_dc_link_v > 0.0:
        over_v = min(over_v, given.board_dc_link_v)
    if over_v <= given.supply_v:
        must = f"below the largest voltage of the board, {given.board_dc_link_v:g} V"
        raise InputError("limits", "dc_link_v", given.supply_v, must, "another board, or a lower supply")
    speed = OVER_SPEED_PART * given.max_speed_rad_s
    found = {
        "iq_limit_a": peak_a,
        "id_limit_a": peak_a,
        "over_current_a": trip_a,
        "over_voltage_v": over_v,
        "under_voltage_v": UNDER_VOLTAGE_PART * given.supply_v,
        "over_speed_rad_s": speed,
        "align_current_a": min(given.rated_current_a, 0.8 * peak_a),
        "offset_limit_a": min(0.025 * trip_a, 0.5),
        "observer_limit_a": min(given.rated_current_a, peak_a),
        "profile_speed_rad_s": 0.5 * given.max_speed_rad_s,
    }
    return {name: _within(name, value) for name, value in found.items()}


def _within(name: str, value: float) -> float:
    """In the range of the parameter, with four digits."""
    field = tables().params[name]
    rounded = float(f"{value:.4g}")
    if not math.isfinite(rounded):
        raise InputError("limits", name, value, field.allowed(), "check the name plate")
    return min(max(rounded, field.minimum), field.maximum)


def beyond_board(drive: Mapping[str, float], plant: Mapping[str, float]) -> dict[str, float]:
    """Fields of [plant] that a simulated board needs so that these limits fit on it; nothing where they fit anyway."""
    needs = {}
    for field, param in (
        ("board_current_a", "over_current_a"), ("board_dc_link_v", "over_voltage_v"),
        ("board_speed_rad_s", "over_speed_rad_s"),
    ):  # fmt: skip
        if not plant.get(field, 0.0) and drive[param] > tables().params[param].default:
            needs[field] = drive[param]
    clip = tables().model["current_range_a"]
    if drive["over_current_a"] * 1.1 > plant.get("current_range_a", clip.default):
        needs["current_range_a"] = float(f"{1.25 * drive['over_current_a']:.4g}")
    return needs
