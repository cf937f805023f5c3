"""What a log does not separate: one name with `or`, and what would separate it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from evenspin.balance.shaft_regression import Drive, drive_of_speeds
from evenspin.balance.verdict import OR
from evenspin.weakform.analysis import Explained

WEAK_MAGNET = 0.25  # a torque per ampere further off than this is none: hot magnets and a wrong zero take less
SCALE = ("inertia", "torque_constant", "encoder_offset")  # the torque balance has their ratio alone
AT_POLES = ("cogging", "current_offset")  # torque of the shaft, or of a current that is not there
VOLTAGES = "the commanded voltages"


@dataclass(frozen=True, slots=True)
class Recorded:
    """What of a machine was recorded, as far as it separates effects."""

    voltages: bool
    load: bool  # that moves
    pole_pairs: int
    drive: Drive

    @classmethod
    def of(cls, found: Explained) -> Recorded:
        logs = [recording.signals for recording in found.recordings]
        speeds = [each.equations.shaft.at_centre(each.signals.speed_rad_s) for each in found.recordings]
        return cls(
            any(log.has_voltages for log in logs),
            any(log.loaded(found.scale.rated_torque_nm) for log in logs),
            found.scale.pole_pairs,
            drive_of_speeds(np.concatenate(speeds)),
        )


def called(effect: str, params: Mapping[str, float], recorded: Recorded) -> tuple[str, str]:
    """The name of an effect, and what would separate the effects in it."""
    drag = recorded.drive.drag()
    if effect in drag and len(drag) > 1:
        return OR.join(drag), recorded.drive.separator()
    if recorded.voltages:
        return effect, ""
    if effect == "current_offset" or (effect == "cogging" and params["order"] == recorded.pole_pairs):
        return OR.join(AT_POLES), f"{VOLTAGES}, or a turn by hand with the current at zero,"
    if effect == "inertia" and not recorded.load:
        factor = params["factor"]
        if 1.0 - WEAK_MAGNET < factor < 1.0:  # a wrong zero takes torque away, and never adds any
            return OR.join(SCALE[:2]), f"{VOLTAGES}, or a measured load,"
        if 1.0 <= factor < 1.0 / (1.0 - WEAK_MAGNET):
            return OR.join(SCALE), f"{VOLTAGES}, or a measured load,"
    if effect == "torque_constant" and params["factor"] < 1.0:
        return OR.join(SCALE[1:]), VOLTAGES
    return effect, ""
