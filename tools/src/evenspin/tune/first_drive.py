"""Limits and first gains of a drive, for a motor of which the name plate is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from evenspin.motor.files import plain, ranges_of
from evenspin.motor.limits import Limits, beyond_board, limit_parameters
from evenspin.motor.resolve import Resolved
from evenspin.native import tables
from evenspin.tune.gains import first_gains


@dataclass(frozen=True, slots=True)
class FirstDrive:
    """`drive`: parameters by name, with `comments`; `board`: numbers of [plant] of a board on which the limits fit."""

    drive: Mapping[str, float]
    comments: Mapping[str, str]
    board: Mapping[str, float]

    def words(self) -> dict[str, Any]:
        """The parameters as TOML has them."""
        return {name: plain(tables().params[name], value) for name, value in self.drive.items()}


def first_drive(found: Resolved) -> FirstDrive:
    plant = found.plant
    peak_a, top_rad_s = found.peak_current_a, found.max_speed_rad_s
    limits = limit_parameters(
        Limits(
            peak_a.value,
            plant["rated_current_a"],
            plant["dc_link_v"],
            top_rad_s.value,
            plant.get("board_current_a", 0.0),
            plant.get("board_dc_link_v", 0.0),
        )
    )
    gains = first_gains(plant, limits, ranges_of(found))
    comments = {
        "iq_limit_a": f"peak current: {peak_a.comment}",
        "over_speed_rad_s": f"of the largest speed: {top_rad_s.comment}",
    } | gains.comments
    return FirstDrive(limits | gains.drive, comments, beyond_board(limits, plant))
