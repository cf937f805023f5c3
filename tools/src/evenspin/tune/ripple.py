"""Repetitive control in the tuned speed loop: lead and learning gain, and the speeds at which it acts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from evenspin.design.rc import Repetitive, design
from evenspin.design.stability import LONGEST
from evenspin.native import tables
from evenspin.tune.gains import complete
from evenspin.tune.goals import Goal
from evenspin.tune.loops import speed_loop

Numbers = Mapping[str, float]

MOST_GAIN = 0.6
LEAST_GAIN = 0.02  # below it learning takes longer than anyone waits
OBSERVER_MEMORY = 6144 - 32  # samples at the PWM rate, DRIVE_OBSERVER_CAPACITY less what interpolation needs


@dataclass(frozen=True, slots=True)
class RepetitiveGains:
    """`bound`: largest stable k_rc with fal at its largest gain; the speeds: mechanical, where the memory acts."""

    drive: dict[str, float]
    bound: float
    slowest_rad_s: float
    fastest_rad_s: float
    reason: str = ""  # why it cannot be used; empty: it can


def repetitive_gains(plant: Numbers, drive: Numbers, goal: Goal) -> RepetitiveGains:
    full = complete(drive)
    loop = speed_loop(plant, full, 0.2 * full["over_speed_rad_s"])
    fal = (full["rc_fal_alpha"], full["rc_fal_delta"])
    found = design(loop, Repetitive(gain=0.1, fal=fal))
    lead = found.recommended_lead
    at_lead = next(each for each in found.by_lead if each.lead == lead)
    bound = at_lead.bound / found.lambda_max
    gain = min(MOST_GAIN, goal.learning_part * bound)
    electrical = 2.0 * math.pi / (plant["pole_pairs"] * loop.ts_s)
    reason = (
        ""
        if gain >= LEAST_GAIN
        else f"the speed loop leaves a learning gain of {bound:.2g}: a faster speed loop would help"
    )
    limit = 0.2 * full["over_speed_rad_s"] * full["speed_error_gain"]
    values = {
        "rc_gain": gain,
        "rc_lead": float(lead),
        "rc_limit_unit": min(limit, tables().params["rc_limit_unit"].maximum),
    }
    return RepetitiveGains(values, bound, electrical / LONGEST, electrical / (lead + 2), reason)


def slowest_of_ro(plant: Numbers) -> float:
    """Speed below which a turn of the shaft does not fit into the memory of the repetitive observer, rad/s."""
    return 2.0 * math.pi * plant["pwm_hz"] / OBSERVER_MEMORY
