"""A run in numbers: each steady state, each change, and in position mode each turn."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.orders import strongest_orders
from evenspin.analysis.segments import RAD_S, Segment, measure_segment, segments
from evenspin.analysis.segments import SIGNALS as STEADY_SIGNALS
from evenspin.analysis.transients import dip, settling_time_s
from evenspin.model.scenario_schema import CONTROL
from evenspin.model.setup import Setup
from evenspin.sim import Record

Array = NDArray[np.float64]

SPEED_INPUT = "speed_ref_rad_s"
SETTLED_SHARE = 0.02  # of the reference
TURN_RAD = 2.0 * math.pi
MOST_TURNS = 12  # of one motion with a row each; a longer one has its first and its last ones
AT_REST_RAD_S = 1e-6
LEAST_ROWS = 8

# What measuring needs, and whether the drive ran at all.
SIGNALS = (*STEADY_SIGNALS, "state", "fault", "iq_ref_a")
POSITION_SIGNALS = ("position_ref_rad", "position_error_rad", "velocity_ref_rad_s")


def controls_position(setup: Setup) -> bool:
    curve = setup.inputs.get("control_mode")
    return curve is not None and CONTROL["position"] in curve.value


def speed_pieces(setup: Setup, record: Record) -> list[dict[str, Any]]:
    """From one change to the next: `measure_segment`, and

    changed                       names of what changed at its start
    speed_rms_rpm, speed_pp_rpm   ripple of the steady state, all of it
    orders                        its largest lines, [{per_turn, rpm}], per turn of the rotor
    settled_s                     after the change, until the speed stays within 2 % of the reference; None: it does not
    dip_rpm                       after the first time that the reference was reached, where it was what changed
    """
    return [_speed_piece(setup, record, segment) for segment in segments(setup)]


def _speed_piece(setup: Setup, record: Record, segment: Segment) -> dict[str, Any]:
    found: dict[str, Any] = dict(measure_segment(record, segment, setup.plant["pole_pairs"]))
    if not found:
        return found
    whole = record.between(segment.start_s, segment.end_s)
    steady = whole.between(segment.steady_s, segment.end_s)
    speed, reference = steady["true_speed_rad_s"] / RAD_S, segment.speed_ref_rad_s
    found["changed"] = list(segment.changed)
    found["speed_rms_rpm"] = float(speed.std())
    found["speed_pp_rpm"] = float(speed.max() - speed.min())
    lines = strongest_orders(speed, steady["true_theta_m_rad"])
    found["orders"] = [{"per_turn": round(order, 3), "rpm": amplitude} for order, amplitude in lines]
    actual = whole["true_speed_rad_s"]
    band = SETTLED_SHARE * abs(reference)
    found["settled_s"] = settling_time_s(whole["t_s"], actual, reference, band) if reference else math.nan
    if SPEED_INPUT in segment.changed:
        reached = np.flatnonzero(np.diff(np.sign(actual - reference)) != 0)
        found["dip_rpm"] = dip(actual[reached[0] + 1 :], reference) / RAD_S if len(reached) else math.nan
    return found


def position_pieces(setup: Setup, record: Record) -> list[dict[str, Any]]:
    """Each stretch in which the profile moves, turn by turn, and each in which it rests. Errors are command less
    encoder, mrad: `error_rms_mrad` without its mean, `error_mean_mrad`, `error_max_mrad` from zero.

    `settled_s`: at rest, until the error stays below 1 mrad, or two counts of a coarser encoder.
    """
    velocity = record["velocity_ref_rad_s"]
    moving = np.abs(velocity) > AT_REST_RAD_S
    edges = np.flatnonzero(np.diff(moving.astype(np.int8))) + 1
    found = []
    for rows in np.split(np.arange(len(record)), edges):
        if len(rows) < LEAST_ROWS:
            continue
        for part in _turns(record, rows) if moving[rows[0]] else [rows]:
            if len(part) >= LEAST_ROWS:
                found.append(_position_piece(setup, record, part, bool(moving[rows[0]])))
    return found


def _turns(record: Record, rows: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """Whole turns of the command from where the motion begins; what is left is its end."""
    travelled = np.abs(record["position_ref_rad"][rows] - record["position_ref_rad"][rows[0]]) / TURN_RAD
    turn = np.floor(np.maximum(travelled - 1e-6, 0.0)).astype(int)
    parts = [rows[turn == number] for number in np.unique(turn)]
    half = MOST_TURNS // 2
    return parts if len(parts) <= MOST_TURNS else [*parts[:half], *parts[-half:]]


def _position_piece(setup: Setup, record: Record, rows: NDArray[np.intp], moves: bool) -> dict[str, Any]:
    error = 1e3 * record["position_error_rad"][rows]
    command = record["position_ref_rad"][rows] / TURN_RAD
    t_s = record["t_s"][rows]
    speed = (record["true_speed_rad_s"][rows] - record["velocity_ref_rad_s"][rows]) / RAD_S
    resolution_mrad = 1e3 * TURN_RAD / max(setup.plant["counts_per_rev"], 1.0)
    settled = math.nan if moves else settling_time_s(t_s, error, 0.0, max(2.0 * resolution_mrad, 1.0))
    return {
        "start_s": float(t_s[0]),
        "end_s": float(t_s[-1]),
        "moves": moves,
        "from_turn": float(command[0]),
        "to_turn": float(command[-1]),
        "speed_ref_rpm": float(record["velocity_ref_rad_s"][rows].mean() / RAD_S),
        "error_rms_mrad": float(error.std()),
        "error_mean_mrad": float(error.mean()),
        "error_max_mrad": float(np.abs(error).max()),
        "speed_rms_rpm": float(speed.std()),
        "iq_mean_a": float(record["true_iq_a"][rows].mean()),
        "settled_s": settled,
    }
