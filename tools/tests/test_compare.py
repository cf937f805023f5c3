"""The simulator against logs of a drive simulator written by others (tests/data/foreign_drive/README.md).

The floor of 0.15 is theirs: sensor noise, converter steps, and tolerances of the unit, which the nominal model does not
know. 0.165 leaves 10 % for the start angle, known to half an encoder count only.
"""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import pytest
from evenspin.cli.main import main
from evenspin.compare import Replay, case_gap
from evenspin.errors import InputError
from evenspin.log.case import read_case
from evenspin.log.unit import Unit

CASES = Path(__file__).parents[2] / "tests" / "data" / "foreign_drive"
FLOOR = (0.12, 0.165)
HIDDEN = {
    case: {effect["name"]: effect["parameters"] for effect in content["effects"]}
    for case, content in json.loads((CASES / "truth.json").read_text()).items()
}


def test_a_drive_without_hidden_effect_is_reproduced_down_to_its_noise() -> None:
    assert FLOOR[0] < case_gap(CASES / "example_clean").gap < FLOOR[1]


@pytest.mark.parametrize("case", [case for case, effects in HIDDEN.items() if effects])
def test_the_hidden_effect_closes_the_gap_down_to_the_noise(case: str) -> None:
    assert FLOOR[0] < case_gap(CASES / case, HIDDEN[case]).gap < FLOOR[1]


@pytest.mark.parametrize(("case", "least"), [("example_current_offset", 0.3), ("example_coulomb_and_inertia", 0.4)])
def test_without_the_hidden_effect_the_gap_stays_open(case: str, least: float) -> None:
    assert case_gap(CASES / case).gap > least


def test_cogging_with_the_wrong_sign_makes_the_gap_larger() -> None:
    cogging = HIDDEN["example_cogging"]["cogging"]
    wrong = {"cogging": {**cogging, "amplitude_nm": -cogging["amplitude_nm"]}}

    assert case_gap(CASES / "example_cogging", wrong).gap > 1.2 * case_gap(CASES / "example_cogging").gap


def test_a_missing_number_in_meta_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "case"
    shutil.copytree(CASES / "example_clean", folder)
    meta = json.loads((folder / "meta.json").read_text())
    del meta["current_loop"]["kp_v_per_a"]
    (folder / "meta.json").write_text(json.dumps(meta))

    with pytest.raises(InputError, match=r"current_loop\.kp_v_per_a = \(missing\): must be a finite number"):
        case_gap(folder)


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("coging.order=3", "did you mean cogging"),
        ("cogging.size=3", "must be a parameter of cogging"),
        ("cogging.order=x", "must be a number"),
    ],
)
def test_a_wrong_effect_is_one_line_and_exit_2(option: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["compare", str(CASES / "example_clean"), "--effect", option])

    assert stop.value.code == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    "effects",
    [
        {"encoder_eccentricity": {"amplitude_rad": 0.05, "phase_rad": 1.0}},
        {"encoder_offset": {"angle_el_rad": -0.4}},
        {"encoder_eccentricity": {"amplitude_rad": 0.02, "phase_rad": 4.0}, "encoder_offset": {"angle_el_rad": 0.3}},
    ],
)
def test_a_unit_with_a_wrong_encoder_starts_where_the_log_reads(effects: dict[str, dict[str, float]]) -> None:
    case = read_case(CASES / "example_clean")
    record = case.experiments["validation"]
    count_rad = 2.0 * math.pi / case.meta["encoder"]["counts_per_rev"]

    rows = Replay(case.path, case.meta, "validation", record).run(("theta_m_rad", "true_theta_m_rad"), Unit(effects))

    assert rows[0, 0] == pytest.approx(record["theta_m_rad"][0], abs=0.51 * count_rad)
    assert abs(rows[0, 1] - record["theta_m_rad"][0]) > 5.0 * count_rad  # the rotor itself stands elsewhere
