"""What counts as a dependence that was named right, wrong, or not at all."""

from __future__ import annotations

import math
from typing import Any

import pytest
from evenspin.blind.foreign_score import page, score_one, summary_of
from evenspin.blind.logs import LogTruth

DRIVE = {"other.angle_delay_s": 0.0, "other.most_torque_per_ampere": 0.0, "other.speed_by_difference": 1.0}
BELT = {"belt": {"amplitude_nm": 0.1, "order": 3.4, "phase_rad": 0.0, "second_rel": 0.35}}
FAN = {"fan": {"torque_nm_s2": 1e-5}}
RESISTANCE = {"winding_resistance": {"factor": 1.5}}


def truth(outside: dict[str, Any], effects: dict[str, Any] | None = None) -> LogTruth:
    kind = "foreign" if outside and not effects else "beside" if outside else "none"
    return LogTruth(
        "a/b.csv", kind, "small", effects or {}, outside, "vesc", 500.0, 60.0, 30000, "dq", False, 0.5, DRIVE
    )


def line(order: float) -> dict[str, Any]:
    return {"depends_on": ["angle"], "family": "angle_line", "form": f"order {order}", "parameters": {"order": order}}


def drag(family: str, power: float) -> dict[str, Any]:
    return {"depends_on": ["speed"], "family": family, "form": "drag", "parameters": {"exponent": power}}


@pytest.mark.parametrize(
    ("outside", "terms", "said"),
    [
        (BELT, [line(3.41)], "right"),
        (BELT, [line(6.8), line(3.4)], "right"),
        (BELT, [line(3.9)], "wrong"),
        (BELT, [], "silent"),
        (FAN, [drag("speed_odd", 2.1)], "right"),
        (FAN, [drag("speed_odd", 1.5)], "wrong"),
        (FAN, [drag("speed_even", 2.0)], "wrong"),
        ({}, [drag("speed_odd", 2.0)], "wrong"),
        ({}, [], "silent"),
    ],
)
def test_a_dependence_is_right_with_its_number_and_parity(outside: dict[str, Any], terms: list[Any], said: str) -> None:
    verdict = {"verdict": ["unknown"], "empirical": terms, "gap_before": 9.0, "gap_after": 2.0}
    score = score_one("log_1_0001", truth(outside), verdict)
    assert score.said == said
    assert score.closed == pytest.approx(7.0 / 8.0)


def test_a_known_effect_beside_it_counts_with_its_parameters() -> None:
    said: dict[str, Any] = {"verdict": ["winding_resistance", "unknown"], "empirical": [line(3.4)], "gap_before": 9.0}
    near = score_one("l", truth(BELT, RESISTANCE), said | {"parameters": {"winding_resistance": {"factor": 1.52}}})
    far = score_one("l", truth(BELT, RESISTANCE), said | {"parameters": {"winding_resistance": {"factor": 1.7}}})
    none = score_one("l", truth(BELT, RESISTANCE), said | {"verdict": ["unknown"]})
    assert (near.known_name, near.known_size) == (True, True)
    assert (far.known_name, far.known_size) == (True, False)
    assert (none.known_name, none.known_size) == (False, False)
    summary = summary_of([near, far, none])
    assert summary["beside_name"] == pytest.approx(2.0 / 3.0)
    assert summary["right"] == 1.0 and math.isnan(summary["false_terms"])
    assert "| belt | 3 | 3 | 0 | 0 |" in page([near, far, none], "1")
