"""The list of misses, on verdicts made by hand."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from evenspin.blind.misses import markdown
from evenspin.blind.score import score_set
from evenspin.blind.truth import Truth

FAN = {"name": "fan_load", "parameters": {}}
INERTIA = {"name": "inertia", "parameters": {"factor": 1.2}}
GAPS = {"gap_before": 1.0, "gap_after": 0.2}


def page(tmp_path: Path, truth: Truth, verdict: dict[str, Any] | None) -> str:
    if verdict is not None:
        (tmp_path / "case_0001.json").write_text(json.dumps(GAPS | verdict))
    (tmp_path / "case_0002.json").write_text(json.dumps(GAPS | {"verdict": []}))
    truths = {"case_0001": truth, "case_0002": Truth([], seed=5)}
    return markdown(score_set(truths, tmp_path), truths, tmp_path)


def test_a_case_that_is_right_is_not_in_the_list_and_the_seed_is_said(tmp_path: Path) -> None:
    text = page(tmp_path, Truth([INERTIA], seed=7), {"verdict": ["inertia"]})
    assert "Every verdict is exactly right." in text and "case_0001" not in text
    assert "Drawn with seed 5, 7;" in text


def test_a_name_that_is_missing_is_listed_with_what_it_opens_and_how_far_it_came(tmp_path: Path) -> None:
    truth = Truth([INERTIA], [FAN], gap_alone={"inertia": 0.4, "fan_load": 0.2}, gap_floor=0.15)
    verdict = {"verdict": ["unknown"], "details": {"size_spread": {"inertia": 0.31}}}
    (line,) = [line for line in page(tmp_path, truth, verdict).splitlines() if line.startswith("| case_0001 |")]
    assert "| inertia + fan_load | unknown |" in line
    assert "inertia opens 0.400 alone at a floor of 0.150, found, its size differs by 0.31 over the log" in line


def test_a_name_that_is_not_there_is_listed_with_its_confidence(tmp_path: Path) -> None:
    truth = Truth([], [FAN], gap_alone={"fan_load": 0.2}, gap_floor=0.15)
    text = page(tmp_path, truth, {"verdict": ["viscous_friction"], "confidence": {"viscous_friction": 0.77}})
    assert "what is foreign opens 0.200 alone at a floor of 0.150" in text
    assert "viscous_friction is not there, said with a confidence of 0.77" in text


def test_a_case_without_a_verdict_is_listed(tmp_path: Path) -> None:
    assert "| case_0001 | inertia | nothing | no verdict |" in page(tmp_path, Truth([INERTIA]), None)


def test_simulations_and_time_are_said_where_the_verdicts_have_them(tmp_path: Path) -> None:
    text = page(tmp_path, Truth([INERTIA]), {"verdict": ["inertia"], "details": {"simulations": 300, "seconds": 12.4}})
    assert "300 median, 300 at most" in text and "12 s median" in text
