"""From a run of one set with one method to the rows of the table: one per speed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from evenspin.analysis.segments import Segment, measure_segment, segments
from evenspin.model import Setup
from evenspin.sim import Record

SPEED_INPUT = "speed_ref_rad_s"
STEADY = ("n1_pct", "n2_pct", "q1_pct", "q2_pct", "distortion_pct", "iq_mean_a", "speed_mean_rpm")
Row = Mapping[str, Any]


def rows_of(setup: Setup, record: Record, set_name: str, method: str, numeric: str) -> list[Row]:
    """One row per speed. Ripple is that before the load step; `*_after_load` that before the next speed."""
    pole_pairs = setup.plant["pole_pairs"]
    pieces = [(segment, measure_segment(record, segment, pole_pairs)) for segment in segments(setup)]
    starts = [index for index, (segment, _) in enumerate(pieces) if SPEED_INPUT in segment.changed]
    rows: list[Row] = []
    for number, index in enumerate(starts):
        before, after = pieces[index][1], _after_load(pieces, index)
        rows.append(
            {"set": set_name, "method": method, "numeric": numeric, "speed_rpm": round(before["speed_ref_rpm"], 6)}
            | {key: before[key] for key in STEADY}
            | {
                "overshoot_start_rpm": pieces[starts[0]][1]["overshoot_rpm"],
                "overshoot_load_rpm": after.get("overshoot_rpm", math.nan),
                "overshoot_step_rpm": before["overshoot_rpm"] if number > 0 else None,
                "load_dip_rpm": after.get("dip_rpm", math.nan),
            }
            | {_after(key): after.get(key, math.nan) for key in STEADY}
        )
    return rows


def _after_load(pieces: list[tuple[Segment, dict[str, float]]], index: int) -> dict[str, float]:
    """The piece after the load step at this speed."""
    if index + 1 < len(pieces) and SPEED_INPUT not in pieces[index + 1][0].changed:
        return pieces[index + 1][1]
    return {}


def _after(key: str) -> str:
    """n1_pct -> n1_after_load_pct."""
    name, _, unit = key.rpartition("_")
    return f"{name}_after_load_{unit}"
