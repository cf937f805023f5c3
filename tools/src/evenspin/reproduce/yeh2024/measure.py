"""From a motion over ten turns to the row of the table. Errors are command less encoder, rad."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.sim import Record

Array = NDArray[np.float64]
Row = Mapping[str, Any]

TURNS = 10
TURN_RAD = 2.0 * np.pi
MRAD = 1e3
START_S = 0.10  # the first turn counts from here; see docs/reference/yeh2024.md
SIGNALS = ("t_s", "position_ref_rad", "position_error_rad", "fault")


def turn_rows(record: Record, turn: int) -> NDArray[np.intp]:
    """Rows in which the command passes through this turn (from 1)."""
    command = record["position_ref_rad"]
    inside = (command > (turn - 1) * TURN_RAD) & (command <= turn * TURN_RAD)
    if turn == TURNS:
        inside &= command < TURNS * TURN_RAD - 1e-4  # not the time at the target; the signal is a float
    return np.flatnonzero(inside)


def turn_error(record: Record, turn: int, *, from_s: float = 0.0) -> Array:
    rows = turn_rows(record, turn)
    return record["position_error_rad"][rows[record["t_s"][rows] >= from_s]]


def rms_without_mean(error: Array) -> float:
    return float(error.std())


def max_without_mean(error: Array) -> float:
    return float(np.abs(error - error.mean()).max())


def max_range_deg(record: Record, limit_rad: float) -> float:
    """Up to which angle of turn 1 the error without its mean is above the limit."""
    rows = turn_rows(record, 1)
    error = record["position_error_rad"][rows]
    above = np.flatnonzero(np.abs(error - error.mean()) > limit_rad)
    return float(np.degrees(record["position_ref_rad"][rows[above[-1]]])) if len(above) else 0.0


def turn_rms(record: Record) -> list[float]:
    """RMS of each turn after its mean is taken off."""
    return [
        rms_without_mean(turn_error(record, turn, from_s=START_S if turn == 1 else 0.0)) for turn in range(1, TURNS + 1)
    ]


def row_of(record: Record, method: str, speed_rpm: float, numeric: str, models: str) -> Row:
    """`models`: "true", or "all wrong"."""
    rms = turn_rms(record)
    last = turn_error(record, TURNS)
    first = np.concatenate([turn_error(record, turn) for turn in (1, 2, 3)])
    row: dict[str, Any] = {
        "method": method,
        "speed_rpm": speed_rpm,
        "numeric": numeric,
        "turn1_rms": rms[0],
        "turn2_reduction_pct": reduction_pct(rms[0], rms[1]),
        "turn10_reduction_pct": reduction_pct(rms[0], rms[-1]),
        "turn10_rms": rms[-1],
        "avg_turn10": float(last.mean()),
        "max_turn1": max_without_mean(turn_error(record, 1, from_s=START_S)),
        "max_turn1_from_0": max_without_mean(turn_error(record, 1)),
        "max_turn10": max_without_mean(last),
        "raw_max_turns_1_3": float(np.abs(first).max()),
        "raw_max_turn10": float(np.abs(last).max()),
        "turn_rms": rms,
    }
    row["max_reduction_pct"] = reduction_pct(row["max_turn1_from_0"], row["max_turn10"])
    return row if models == "true" else row | {"models": models}


def reduction_pct(before: float, after: float) -> float:
    return 100.0 * (1.0 - after / before)


def find(rows: Sequence[Row], method: str, speed_rpm: float, models: str = "true") -> Row | None:
    for row in rows:
        if (row["method"], row["speed_rpm"], row.get("models", "true")) == (method, speed_rpm, models):
            return row
    return None
