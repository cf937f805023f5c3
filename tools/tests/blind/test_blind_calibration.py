"""Confidence and intervals against the truth, on verdicts made by hand."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from evenspin.blind.calibration import calibrate, markdown
from evenspin.blind.truth import Truth

COGGING = {"name": "cogging", "parameters": {"amplitude_nm": 0.05, "phase_rad": 6.2, "order": 24.0}}
FAN = {"name": "fan_load", "parameters": {}}
TRUTHS = {"case_0001": Truth([COGGING]), "case_0002": Truth([], [FAN]), "case_0003": Truth([])}


def written(folder: Path, **verdicts: dict[str, Any]) -> Path:
    for case, verdict in verdicts.items():
        (folder / f"{case}.json").write_text(json.dumps(verdict))
    return folder


def interval(value: float, half: float) -> dict[str, float]:
    return {"value": value, "low": value - half, "high": value + half}


def test_names_are_counted_by_confidence_with_the_share_that_is_right(tmp_path: Path) -> None:
    results = written(
        tmp_path,
        case_0001={"confidence": {"cogging": 0.97, "inertia": 0.6}},
        case_0002={"confidence": {"unknown": 0.99}},
        case_0003={"confidence": {"inertia": 0.7}},
    )

    levels = calibrate(TRUTHS, results).levels

    assert [(level.low, level.names, level.right) for level in levels] == [(0.5, 2, 0.0), (0.95, 2, 1.0)]
    assert [level.said for level in levels] == pytest.approx([0.65, 0.98])
    # two names are off by 0.65, two by 0.02
    assert calibrate(TRUTHS, results).error == pytest.approx((2 * 0.65 + 2 * 0.02) / 4)


def test_intervals_count_as_holding_the_truth_also_across_the_turn(tmp_path: Path) -> None:
    found = {"amplitude_nm": interval(0.052, 0.001), "phase_rad": interval(0.01, 0.1), "order": interval(24.0, 0.0)}

    calibration = calibrate(TRUTHS, written(tmp_path, case_0001={"intervals": {"cogging": found}}))

    # the amplitude is off by two half widths, the phase by 0.093 of 0.1 rad; the order is no measurement
    assert calibration.intervals == 2
    assert calibration.coverage == (0.5, 1.0)
    assert calibration.of_parameter == (("cogging.amplitude_nm", 1, 0.0), ("cogging.phase_rad", 1, 1.0))


def test_without_verdicts_nothing_is_claimed(tmp_path: Path) -> None:
    calibration = calibrate(TRUTHS, tmp_path)

    assert calibration.levels == ()
    assert all(math.isnan(share) for share in calibration.coverage)
    assert "0 intervals of 95 %: - hold the truth" in markdown(calibration)
