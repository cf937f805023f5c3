"""The score of a blind set, on verdicts whose worth is known."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from evenspin.blind.score import markdown, parameter_errors, parameter_table, score_set, size_table
from evenspin.blind.truth import Truth
from evenspin.errors import InputError

COGGING = {"name": "cogging", "parameters": {"amplitude_nm": 0.05, "phase_rad": 6.2, "order": 24.0}}
INERTIA = {"name": "inertia", "parameters": {"factor": 1.25}}
RUB = {"name": "fan_load", "parameters": {"torque_nm_s2": 1e-4}}
TRUTHS = {
    "case_0001": Truth([COGGING], gap_floor=0.15),
    "case_0002": Truth([INERTIA, COGGING], gap_floor=0.15),
    "case_0003": Truth([], gap_floor=0.15),
    "case_0004": Truth([], [RUB], gap_floor=0.15),
}
RIGHT: dict[str, dict[str, Any]] = {
    "case_0001": {"verdict": ["cogging"], "parameters": {"cogging": COGGING["parameters"]}},
    "case_0002": {"verdict": ["cogging", "inertia"], "parameters": {"inertia": {"factor": 1.25}}},
    "case_0003": {"verdict": ["none"]},
    "case_0004": {"verdict": ["unknown"]},
}
GAPS = {"gap_before": 1.15, "gap_after": 0.155}  # 99.5 % of what is above the floor


def written(folder: Path, verdicts: Mapping[str, Mapping[str, Any]]) -> Path:
    for case, verdict in verdicts.items():
        (folder / case).mkdir(parents=True)
        (folder / case / "verdict.json").write_text(json.dumps({"case": case, **GAPS, **verdict}))
    return folder


def test_right_verdicts_reach_every_goal(tmp_path: Path) -> None:
    verdicts = {**RIGHT, "case_0002": RIGHT["case_0002"] | {"parameters": {}}}
    score = score_set(TRUTHS, written(tmp_path, verdicts))

    assert score.missed() == []
    assert score.summary["exact_single"] == score.summary["exact_pair"] == score.summary["unknown_on_outside"] == 1.0
    assert score.summary["named_on_clean"] == score.summary["known_called_unknown"] == 0.0
    assert score.summary["gap_closed_median"] == pytest.approx(0.995)
    assert score.confusion == {"cogging": {"cogging": 1}, "none": {"none": 1}, "fan_load": {"unknown": 1}}


def test_an_empty_list_means_none(tmp_path: Path) -> None:
    score = score_set(TRUTHS, written(tmp_path, RIGHT | {"case_0003": {"verdict": []}}))

    assert score.cases[2].right


@pytest.mark.parametrize(
    ("case", "verdict", "measure", "value"),
    [
        ("case_0001", ["cogging", "inertia"], "exact_single", 0.0),
        ("case_0001", ["cogging", "inertia"], "strongest_right_single", 1.0),
        ("case_0001", ["inertia", "cogging"], "strongest_right_single", 0.0),
        ("case_0001", ["unknown"], "known_called_unknown", 0.5),
        ("case_0002", ["inertia"], "exact_pair", 0.0),
        ("case_0003", ["inertia"], "named_on_clean", 1.0),
        ("case_0003", ["unknown"], "unknown_on_clean", 1.0),
        ("case_0003", ["unknown"], "named_on_clean", 0.0),
        ("case_0004", ["viscous_friction"], "unknown_on_outside", 0.0),
        ("case_0004", ["viscous_friction", "unknown"], "unknown_on_outside", 0.0),
    ],
)
def test_a_wrong_verdict_counts_where_it_belongs(
    tmp_path: Path, case: str, verdict: list[str], measure: str, value: float
) -> None:
    score = score_set(TRUTHS, written(tmp_path, RIGHT | {case: {"verdict": verdict}}))

    assert score.summary[measure] == value


def test_a_case_without_result_is_wrong_and_shown(tmp_path: Path) -> None:
    some = {case: verdict for case, verdict in RIGHT.items() if case != "case_0001"}
    score = score_set(TRUTHS, written(tmp_path, some))

    assert score.summary["strongest_right_single"] == 0.0
    assert score.confusion["cogging"] == {"(no result)": 1}


def test_results_may_lie_side_by_side(tmp_path: Path) -> None:
    for case, verdict in RIGHT.items():
        (tmp_path / f"{case}.json").write_text(json.dumps(verdict))

    score = score_set(TRUTHS, tmp_path)

    assert score.summary["exact_single"] == 1.0
    assert math.isnan(score.summary["gap_closed_median"])  # not reported


def errors(effect: str, true: dict[str, float], found: dict[str, Any]) -> dict[str, float]:
    return dict(parameter_errors(effect, true, found))


def test_phases_differ_by_an_angle_and_orders_are_exact() -> None:
    found = {"amplitude_nm": 0.051, "phase_rad": 6.2 - 2.0 * math.pi + 0.03, "order": 24}

    assert errors("cogging", COGGING["parameters"], found) == pytest.approx(
        {"amplitude_nm": 0.02, "phase_rad": 0.03, "order": 0.0}
    )
    assert errors("cogging", COGGING["parameters"], found | {"order": 12})["order"] == 1.0


def test_offsets_count_as_a_vector() -> None:
    true = {"offset_a_a": 0.3, "offset_b_a": 0.0}

    assert errors("current_offset", true, {"offset_a_a": 0.3, "offset_b_a": 0.006}) == pytest.approx({"offset": 0.02})


def test_only_the_mismatch_of_gains_counts() -> None:
    true = {"gain_a": 1.02, "gain_b": 0.98}

    assert errors("current_gain", true, {"gain_a": 1.02 / 0.98, "gain_b": 1.0})["mismatch"] == pytest.approx(0.0)
    assert errors("current_gain", true, {"gain_a": 1.0, "gain_b": 0.0})["mismatch"] == 1.0


def test_a_factor_is_relative_to_itself_and_a_missing_parameter_is_all_wrong() -> None:
    assert errors("inertia", {"factor": 1.25}, {"factor": 1.275}) == pytest.approx({"factor": 0.02})
    assert errors("inertia", {"factor": 1.25}, {}) == {"factor": 1.0}
    assert errors("inertia", {"factor": 1.25}, {"factor": "much"}) == {"factor": 1.0}


def test_a_second_order_counts_by_its_share() -> None:
    true = {"amplitude_nm": 0.1, "phase_rad": 1.0, "second_rel": 0.5, "phase2_rad": 2.0}
    found = {"amplitude_nm": 0.1, "phase_rad": 1.0, "second_rel": 0.53, "phase2_rad": 2.1}

    assert errors("misalignment", true, found) == pytest.approx(
        {"amplitude_nm": 0.0, "phase_rad": 0.0, "second_rel": 0.03, "phase2_rad": 0.05}
    )


def test_the_markdown_has_the_summary_the_matrix_and_the_parameters(tmp_path: Path) -> None:
    score = score_set(TRUTHS, written(tmp_path, RIGHT))
    text = markdown(score)

    assert "1 single, 1 pair, 1 none, 1 outside." in text
    assert "| exact set right, two effects hidden | 100.0 % | >= 95 % |" in text
    assert "| parameter error, median | 0.0 % | <= 0.5 % |" in text
    assert "| cogging | 1 |  |  |" in text
    assert [row[0] for row in parameter_table(score)][:2] == ["cogging.amplitude_nm", "cogging.order"]


def test_sizes_are_counted_apart(tmp_path: Path) -> None:
    truths = {case: Truth([COGGING], size=size) for case, size in (("a", "large"), ("b", "small"), ("c", "small"))}
    verdicts = {"a": {"verdict": ["cogging"]}, "b": {"verdict": ["cogging"]}, "c": {"verdict": ["inertia"]}}

    assert size_table(score_set(truths, written(tmp_path, verdicts))) == [
        ("single", "small", 2, 0.5),
        ("single", "large", 1, 1.0),
    ]


def test_a_verdict_that_is_no_list_is_one_line(tmp_path: Path) -> None:
    written(tmp_path, RIGHT | {"case_0001": {"verdict": 3}})

    with pytest.raises(InputError, match="verdict = 3: must be a list of names"):
        score_set(TRUTHS, tmp_path)


def test_results_of_other_cases_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="results of these cases"):
        score_set(TRUTHS, written(tmp_path, {"other": RIGHT["case_0001"]}))
