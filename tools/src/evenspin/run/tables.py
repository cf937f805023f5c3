"""The tables of a run: steady states and changes, and motions in position mode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from evenspin.tableview import TableView, number

STEADY = {
    "start_s": "from s",
    "end_s": "to s",
    "speed_ref_rpm": "ref. rpm",
    "speed_mean_rpm": "mean rpm",
    "speed_rms_rpm": "rms rpm",
    "iq_mean_a": "iq A",
    "n1_pct": "n1 %",
    "n2_pct": "n2 %",
    "q1_pct": "q1 %",
    "q2_pct": "q2 %",
    "distortion_pct": "D %",
}
CHANGES = {
    "start_s": "at s",
    "speed_ref_rpm": "ref. rpm",
    "overshoot_rpm": "over rpm",
    "dip_rpm": "dip rpm",
    "settled_s": "settled after s",
}
POSITION = {
    "start_s": "from s",
    "end_s": "to s",
    "from_turn": "from turn",
    "to_turn": "to turn",
    "speed_ref_rpm": "rpm",
    "error_rms_mrad": "error rms mrad",
    "error_mean_mrad": "mean mrad",
    "error_max_mrad": "largest mrad",
    "speed_rms_rpm": "speed rms rpm",
    "iq_mean_a": "iq A",
    "settled_s": "settled s",
}
STEADY_TEXT = (
    "The steady state before the next change: rms of all ripple, n (speed) and q (current) by electrical order in % of "
    "the mean, D distortion of the stator current; orders: the largest, per turn of the rotor."
)
CHANGES_TEXT = "After each change. Settled: within 2 % of the reference for good."
POSITION_TEXT = (
    "Each motion turn by turn, and each rest. Error: command less encoder, rms without its mean. Speed: about the "
    "command. Settled: at rest, until the error stays below 1 mrad or two counts of the encoder."
)
ALL_OF_IT = 100.0  # %: more than the mean itself is no ripple of it


def run_tables(summary: Mapping[str, Any]) -> list[TableView]:
    """What there is to show: motions of position mode, and speeds where a speed was asked for."""
    views = [position_table(summary)] if summary["motions"] else []
    turns = any(piece["speed_ref_rpm"] for piece in summary["segments"])
    return [*views, steady_table(summary), changes_table(summary)] if turns or not views else views


def steady_table(summary: Mapping[str, Any]) -> TableView:
    rows = [(*(_cell(key, piece[key]) for key in STEADY), _orders(piece)) for piece in summary["segments"]]
    header = (*STEADY.values(), "orders: rpm")
    return TableView(f"{summary['scenario']}, {summary['method']}", STEADY_TEXT, header, rows, left=0)


def changes_table(summary: Mapping[str, Any]) -> TableView:
    rows = [
        (*(_cell(key, piece[key]) for key in CHANGES), ", ".join(piece["changed"]) or "start")
        for piece in summary["segments"]
    ]
    return TableView("Changes", CHANGES_TEXT, (*CHANGES.values(), "what changed"), rows, left=0)


def position_table(summary: Mapping[str, Any]) -> TableView:
    rows = [tuple(_cell(key, piece[key]) for key in POSITION) for piece in summary["motions"]]
    title = f"{summary['scenario']}, {summary['method']}, position"
    return TableView(title, POSITION_TEXT, tuple(POSITION.values()), rows, left=0)


def _cell(key: str, value: float | None) -> str:
    """A percentage of a mean near zero says nothing."""
    return "-" if key.endswith("_pct") and value is not None and value > ALL_OF_IT else number(value)


def _orders(piece: Mapping[str, Any]) -> str:
    return ", ".join(f"{each['per_turn']:.4g}: {number(each['rpm'])}" for each in piece["orders"]) or "-"
