"""What rho of robust driving control has to cover: the torque error of a model anywhere within its intervals."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from evenspin.design.rdc_intervals import Motion, table_of, uncertainty
from evenspin.errors import InputError

FOUND = {
    "inertia_kgm2": 0.0078, "viscous_nms": 0.034,
    "coulomb_nm": 0.387, "static_nm": 0.457, "stribeck_rad_s": 0.55, "shape": 1.9,
    "lines": [
        {"cycles": 24.0, "amplitude_nm": 0.1, "phase_rad": 1.2,
         "half_interval_95": {"cycles": 1e-4, "amplitude_nm": 0.001, "phase_rad": 0.02}},
        {"cycles": 4.0, "amplitude_nm": 0.02, "phase_rad": 0.5,
         "half_interval_95": {"cycles": 1e-3, "amplitude_nm": 0.0005, "phase_rad": 0.05}},
    ],
    "interval_95": {
        "inertia_kgm2": [0.0077, 0.0079], "viscous_nms": [0.033, 0.035], "coulomb_nm": [0.380, 0.394],
        "static_nm": [0.450, 0.464], "stribeck_rad_s": [0.50, 0.60], "shape": [1.7, 2.1],
    },
}  # fmt: skip
MOTION = Motion(3.0, 20.0, 10.0)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "identified.json"
    path.write_text(json.dumps(FOUND), encoding="utf-8")
    return path


def torque(values: dict, lines: list, v: float, accel: float, angle: float) -> float:
    slow = np.exp(-((v / values["stribeck_rad_s"]) ** values["shape"]))
    friction = values["viscous_nms"] * v + values["coulomb_nm"] + (values["static_nm"] - values["coulomb_nm"]) * slow
    tied = sum(line["amplitude_nm"] * np.sin(line["cycles"] * angle + line["phase_rad"]) for line in lines)
    return values["inertia_kgm2"] * accel + friction + tied


def test_no_model_within_the_intervals_is_off_by_more_and_one_is_off_by_nearly_as_much(file: Path) -> None:
    """Against 4000 models and moments drawn at random, half of them at ends of the intervals."""
    found = uncertainty(file, MOTION)
    rng = np.random.default_rng(1)
    middle = {name: FOUND[name] for name in FOUND["interval_95"]}
    worst = 0.0
    for trial in range(4000):
        at_ends = trial % 2 == 0
        share = (lambda: float(rng.choice([0.0, 1.0]))) if at_ends else (lambda: float(rng.uniform()))
        values = {name: low + share() * (high - low) for name, (low, high) in FOUND["interval_95"].items()}
        lines = []
        for line in FOUND["lines"]:
            half = line["half_interval_95"]
            lines.append({key: line[key] + (2.0 * share() - 1.0) * half[key] for key in half})
        v, angle = rng.uniform(0.0, MOTION.speed_rad_s), 2.0 * np.pi * MOTION.turns * rng.uniform(0.9, 1.0)
        error = torque(values, lines, v, MOTION.accel_rad_s2, angle) - torque(middle, FOUND["lines"], v, 20.0, angle)
        worst = max(worst, abs(error))
    assert worst <= found.sum_nm * 1.0001
    assert worst > 0.6 * found.sum_nm


def test_each_part_is_what_it_is_by_hand(file: Path) -> None:
    parts = uncertainty(file, Motion(0.0, 20.0, 10.0)).parts

    assert parts["inertia_kgm2"] == pytest.approx(1e-4 * 20.0)
    assert parts["static_nm"] == pytest.approx(0.007)  # at standstill: all of the static friction, nothing of the rest
    assert parts["coulomb_nm"] == parts["viscous_nms"] == 0.0
    # amplitude 0.001, and 0.1 turned by 0.02 rad and 10 turns of 1e-4 cycles
    assert parts["line 1"] == pytest.approx(0.001 + 0.1 * (0.02 + 2e-3 * np.pi), rel=1e-3)


def test_a_line_that_has_drifted_by_half_a_turn_is_off_by_twice_its_size_and_no_more(file: Path) -> None:
    assert uncertainty(file, Motion(1.0, 0.0, 1e6)).parts["line 2"] == pytest.approx(0.0005 + 2.0 * 0.02)


def test_rho_below_the_sum_is_marked_and_above_is_good(file: Path) -> None:
    found = uncertainty(file, MOTION)

    assert table_of(found, 1.01 * found.sum_nm).marks[-1] == "good"
    assert table_of(found, 0.99 * found.sum_nm).marks[-1] == "bad"
    assert found.rss_nm < found.sum_nm


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        ("[1, 2]", "interval_95"),
        ("{", "file"),
        ('{"interval_95": {}}', "interval_95"),
        ('{"interval_95": {"inertia_kgm2": [2, 1]}}', "low first"),
        ('{"interval_95": {"inertia_kgm2": "ab"}}', "[low, high]"),
        ('{"interval_95": {"inertia_kgm2": [0, NaN]}}', "a finite number"),
        ('{"interval_95": {}, "lines": [3]}', "lines[1]"),
        ('{"interval_95": {}, "lines": [{"half_interval_95": {}}]}', "lines[1].amplitude_nm"),
    ],
)
def test_a_file_that_is_no_identification_is_refused_in_one_line(tmp_path: Path, text: str, reported: str) -> None:
    path = tmp_path / "x.json"
    path.write_text(text, encoding="utf-8")

    with pytest.raises(InputError) as caught:
        uncertainty(path, MOTION)
    assert reported in str(caught.value) and len(str(caught.value).splitlines()) == 1


def test_the_command_says_whether_rho_covers_it(evenspin, file: Path) -> None:
    said = evenspin("design", "rdc", "--identified", file, "--speed-rpm", "30", "--accel-rad-s2", "20", "--json")

    content = json.loads(said.out)
    expected = uncertainty(file, Motion(np.pi, 20.0, 10.0))
    assert content["uncertainty"]["sum_nm"] == pytest.approx(expected.sum_nm)
    assert "rho = 0.15 N m covers it" in said.err


@pytest.mark.parametrize("words", [("--turns", "3"), ("--speed-rpm", "3"), ("--accel-rad-s2", "3")])
def test_a_motion_without_an_identification_has_no_effect_and_is_refused(evenspin, words) -> None:
    said = evenspin("design", "rdc", *words)

    assert (said.status, said.out, said.err.count("\n")) == (2, "", 1)
    assert "--identified" in said.err
