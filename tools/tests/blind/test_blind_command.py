"""`evenspin gap blind`: what the command writes and refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from evenspin.blind import cases as making
from evenspin.blind.truth import Truth, read_truth
from evenspin.cli.gap_blind import app
from evenspin.errors import CheckFailedError, InputError
from typer.testing import CliRunner


def call(*words: object) -> str:
    result = CliRunner().invoke(app, [str(word) for word in words])
    if result.exception is not None:
        raise result.exception
    return result.output


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cases without their records: making them is tested elsewhere."""

    def make_case(plan: making.Plan, folder: Path) -> Truth:
        folder.mkdir()
        return Truth([{"name": name, "parameters": {}} for name in plan.names], kind=plan.kind, gap_floor=0.1)

    def make_set(plans, folder, jobs, progress):
        return {plan.case: make_case(plan, folder / plan.case) for plan in plans}

    monkeypatch.setattr(making, "make_set", make_set)


def test_the_truth_lies_beside_the_cases(quick: None, tmp_path: Path) -> None:
    said = json.loads(call("make", "--out", tmp_path / "set", "--count", 3, "--kind", "single", "--json"))

    assert said["count"] == 3
    assert sorted(path.name for path in (tmp_path / "set").iterdir()) == ["case_0001", "case_0002", "case_0003"]
    assert set(read_truth(tmp_path / "set_truth.json")) == {"case_0001", "case_0002", "case_0003"}


def test_folders_that_are_not_there_are_made_for_cases_and_truth(quick: None, tmp_path: Path) -> None:
    place = tmp_path / "new" / "place"

    call("make", "--out", place / "set", "--truth", place / "truth.json", "--kind", "single=1")

    assert set(read_truth(place / "truth.json")) == {"case_0001"}


def test_kinds_may_be_counted_one_by_one(quick: None, tmp_path: Path) -> None:
    call("make", "--out", tmp_path / "set", "--kind", "single=2,pair=3,none=1", "--effects", "cogging,inertia")

    truths = read_truth(tmp_path / "set_truth.json")
    assert sorted(truth.what for truth in truths.values()) == ["none", "pair", "pair", "pair", "single", "single"]
    assert {name for truth in truths.values() for name in truth.verdict} == {"cogging", "inertia"}


MIX_OF_FORTY = {"single": 20, "pair": 6, "triple": 3, "none": 3, "outside": 4, "beside": 4}


def test_a_mix_of_forty_has_all_kinds(quick: None, tmp_path: Path) -> None:
    call("make", "--out", tmp_path / "set")

    kinds = [truth.kind for truth in read_truth(tmp_path / "set_truth.json").values()]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == MIX_OF_FORTY


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--effects", "coging"], "did you mean cogging"),
        (["--kind", "quadruple"], "mix or one of single"),
        (["--kind", "single=x"], "NAME=NUMBER"),
        (["--kind", "single=2", "--count", "3"], "2 as in --kind"),
        (["--kind", "pair", "--effects", "cogging"], "two or more"),
        (["--kind", "pair", "--effects", "two_mass,backlash"], "two or more that go together"),
        (["--kind", "single", "--effects", "fan_load"], "of the vocabulary"),
        (["--kind", "outside", "--effects", "cogging"], "outside of the vocabulary"),
        (["--truth", "SET/truth.json"], "apart from"),
    ],
)
def test_a_wrong_option_is_refused_before_anything_is_made(
    quick: None, tmp_path: Path, words: list[str], said: str
) -> None:
    words = [word.replace("SET", str(tmp_path / "set")) for word in words]

    with pytest.raises(InputError, match=said):
        call("make", "--out", tmp_path / "set", *words)

    assert not (tmp_path / "set").exists()


def test_a_folder_with_something_in_it_is_left_alone(quick: None, tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")

    with pytest.raises(InputError, match="new or empty"):
        call("make", "--out", tmp_path)


@pytest.fixture
def scored(quick: None, tmp_path: Path) -> list[object]:
    call("make", "--out", tmp_path / "set", "--count", 4, "--kind", "single")
    for case, truth in read_truth(tmp_path / "set_truth.json").items():
        (tmp_path / "verdicts" / case).mkdir(parents=True)
        verdict = {"verdict": truth.verdict, "gap_before": 1.1, "gap_after": 0.101}
        (tmp_path / "verdicts" / case / "verdict.json").write_text(json.dumps(verdict))
    return ["score", "--truth", tmp_path / "set_truth.json", "--results", tmp_path / "verdicts"]


def test_score_prints_the_same_as_json_and_writes_markdown(scored: list[object], tmp_path: Path) -> None:
    said = json.loads(call(*scored, "--json", "--markdown", tmp_path / "table.md", "--check"))

    assert said["summary"]["exact_single"] == 1.0
    assert said["summary"]["exact_pair"] is None
    assert said["missed"] == []
    assert "| exact set right, one effect hidden | 100.0 % |" in (tmp_path / "table.md").read_text()
    printed = call(*scored)
    assert "exact set right, one effect hidden" in printed
    assert "<= 0.5 %" in printed  # of the median parameter error: no goal is rounded


def test_a_missed_goal_is_said_by_check(scored: list[object], tmp_path: Path) -> None:
    (tmp_path / "verdicts" / "case_0001" / "verdict.json").write_text('{"verdict": ["unknown"]}')

    assert "missed" in call(*scored)
    with pytest.raises(CheckFailedError, match="known_called_unknown"):
        call(*scored, "--check")


def test_only_the_cases_of_a_folder_are_scored(scored: list[object], tmp_path: Path) -> None:
    (tmp_path / "set" / "case_0002").rmdir()

    said = json.loads(call(*scored, "--cases", tmp_path / "set", "--json"))

    assert [case["case"] for case in said["cases"]] == ["case_0001", "case_0003", "case_0004"]
