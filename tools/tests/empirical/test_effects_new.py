"""`evenspin effects new`: the drafted files compile, and pass what every effect of the table has to pass."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from evenspin.empirical.equations_c import EQUATIONS
from evenspin.empirical.sketch import equation_of, files_of

ROOT = Path(__file__).parents[3]
OVER = {"top_rad_s": 60.0, "span_s": 40.0, "start_s": 0.0, "travel_rad": 80.0, "middle_rad": 12.0}
FOUND = {  # parameters as verdict.json has them
    "speed_odd": {"exponent": 2.01, "torque_nm": 0.32},
    "speed_even": {"exponent": 1.0, "torque_nm": -0.05},
    "angle_line": {"order": 11.0, "speed_exponent": 2.0, "turns_over": 1.0, "torque_nm": 0.37, "phase_rad": -0.67},
    "position_bump": {"centre_rad": 31.0, "width_rad": 6.0, "torque_nm": 0.2},
    "position_spring": {"torque_nm": 0.4},
    "time_load": {"time_constant_s": 9.0, "torque_nm": 0.1, "torque_nm_at_start": 0.0},
    "time_friction": {"time_constant_s": 6.4, "torque_nm": -0.015, "torque_nm_at_start": 0.0},
    "time_viscous": {"time_constant_s": 6.4, "torque_nm": 0.1, "torque_nm_at_start": 0.0},
    "time_magnet": {"time_constant_s": 20.0, "share": 0.05, "share_at_start": 0.0},
    "time_resistance": {"time_constant_s": 13.3, "resistance_ohm": 0.56, "resistance_ohm_at_start": 0.0},
    "torque_frequency": {"frequency_hz": 19.3, "torque_nm": 0.1, "phase_rad": 1.1},
    "supply_frequency": {"frequency_hz": 100.0, "share": 0.06, "phase_rad": 0.3},
}


def verdict_of(families: list[str]) -> dict[str, object]:
    terms = [
        {"family": name, "form": f"what a {name} does */", "parameters": FOUND[name], "measured_over": OVER}
        for name in families
    ]
    return {"verdict": ["unknown"], "empirical": terms}


def a_checkout(folder: Path) -> Path:
    (folder / "sim_host/effects").mkdir(parents=True)
    (folder / "tools/src/evenspin/effects").mkdir(parents=True)
    (folder / "tests/sim_host").mkdir(parents=True)
    return folder


@pytest.fixture
def verdict(tmp_path: Path) -> Path:
    path = tmp_path / "verdict.json"
    path.write_text(json.dumps(verdict_of(["speed_odd", "angle_line", "cross_saturation"][:2])))
    return path


def test_every_family_that_is_drafted_is_tried_here():
    assert set(FOUND) == set(EQUATIONS)


SHORT = ("speed_odd", "angle_line")
WITH_THE_MOTION = ("speed_odd", {"exponent": 2.0, "torque_nm": -0.1})  # which no friction does
FRACTIONAL = ("angle_line", {**FOUND["angle_line"], "order": 3.47, "speed_exponent": 0.0, "turns_over": 0.0})


@pytest.mark.parametrize(
    "drafted",
    [
        pytest.param([(name, FOUND[name]) for name in SHORT], id="two"),
        pytest.param([*FOUND.items(), WITH_THE_MOTION, FRACTIONAL], id="all", marks=pytest.mark.search),
    ],
)
def test_drafted_effects_build_and_pass_the_tests_of_every_effect_and_their_own(
    tmp_path: Path, drafted: list[tuple[str, dict[str, float]]]
) -> None:
    for name in ("control", "hal", "firmware", "sim_host", "cmake", "tests"):
        shutil.copytree(ROOT / name, tmp_path / name)
    shutil.copy(ROOT / "CMakeLists.txt", tmp_path)
    plant = tmp_path / "sim_host/plant/plant.h"  # room for all drafts at once
    plant.write_text(plant.read_text().replace("#define SIM_EFFECTS_MAX 32", "#define SIM_EFFECTS_MAX 48"))
    names = []
    for number, (family, parameters) in enumerate(drafted):
        equation = equation_of({"family": family, "parameters": parameters, "measured_over": OVER})
        assert equation is not None
        names.append(f"draft_{number}")
        for place, text in files_of(names[-1], equation, f"what a {family} does */").items():
            (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / place).write_text(text)

    configured = run("cmake", "-S", tmp_path, "-B", tmp_path / "build", "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Debug")
    assert configured.returncode == 0, configured.stderr[-2000:]
    tests = ["test_effects", *(f"test_effect_{name}" for name in names)]
    built = run("cmake", "--build", tmp_path / "build", "--parallel", "2", "--target", *tests)
    assert built.returncode == 0, built.stdout[-3000:]
    wanted = "^(" + "|".join(tests) + ")$"
    ran = run("ctest", "--test-dir", tmp_path / "build", "-R", wanted, "--output-on-failure")
    assert ran.returncode == 0, ran.stdout[-3000:]
    assert f"out of {len(tests)}" in ran.stdout


def run(*words: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(word) for word in words], text=True, capture_output=True, check=False)


def test_the_command_writes_an_effect_a_test_and_a_module_where_it_has_an_order(evenspin, verdict, tmp_path):
    root = a_checkout(tmp_path / "checkout")

    said = evenspin("effects", "new", "windage", "--from", str(verdict), "--root", str(root)).out
    evenspin("effects", "new", "gear", "--from", str(tmp_path), "--term", "2", "--root", str(root))

    assert "sim_host/effects/windage.c" in said and "RULES" in said
    written = (root / "sim_host/effects/windage.c").read_text()
    # 0.32 N m at 60 rad/s is 0.32 (100 / 60)^2.01 = 0.893 N m at 100 rad/s
    assert '"torque_nm", "N m"' in written and "0.0, 0.0, 10000.0, SIM_AMPLITUDE, 0.8934" in written
    assert (root / "tests/sim_host/effects/test_effect_windage.c").is_file()
    assert not (root / "tools/src/evenspin/effects/windage.py").exists()
    assert "return (11,)" in (root / "tools/src/evenspin/effects/gear.py").read_text()


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("cogging", None, "the table has this effect"),
        ("Fan", None, "an identifier of small letters"),
        ("2fan", None, "an identifier of small letters"),
        ("fan-out", None, "an identifier of small letters"),
        ("../fan", None, "an identifier of small letters"),
        ("double", None, "an identifier of small letters"),
        ("lambda", None, "no word of the command"),
        ("show", None, "no word of the command"),
        ("taken", None, "new"),
        ("windage", '{"verdict": ["cogging"]}', "at least one term"),
        ("windage", '{"empirical": []}', "at least one term"),
        ("windage", "[1, 2]", "at least one term"),
        ("windage", "no JSON", "must be JSON"),
        ("windage", '{"empirical": [{"family": "speed_odd"}]}', "run `evenspin gap` again"),
        (
            "windage",
            json.dumps({"empirical": [{"family": "reversal", "form": "x", "parameters": {}, "measured_over": {}}]}),
            "that a hook of the simulator can have",
        ),
        (
            "windage",
            json.dumps({"empirical": [{"family": "speed_odd", "form": "x", "parameters": {}, "measured_over": {}}]}),
            "the numbers of its family",
        ),
    ],
)
def test_what_no_effect_can_be_made_of_is_refused_in_one_line(evenspin, verdict, tmp_path, name, content, said):
    root = a_checkout(tmp_path / "checkout")
    (root / "tests/sim_host/effects").mkdir()
    (root / "tests/sim_host/effects/test_effect_taken.c").touch()
    before = sorted(root.rglob("*"))
    if content is not None:
        verdict.write_text(content)

    run = evenspin("effects", "new", name, "--from", str(verdict), "--root", str(root))

    assert run.status == 2 and said in run.err and len(run.err.strip().splitlines()) == 1
    assert sorted(root.rglob("*")) == before


def test_a_term_that_the_verdict_does_not_have_and_a_folder_without_sources_are_refused(evenspin, verdict, tmp_path):
    root = a_checkout(tmp_path / "checkout")

    third = evenspin("effects", "new", "fan", "--from", str(verdict), "--term", "3", "--root", str(root))
    nowhere = evenspin("effects", "new", "fan", "--from", str(verdict), "--root", str(tmp_path / "no"))

    assert (third.status, nowhere.status) == (2, 2)
    assert "--term = 3: must be 1 .. 2" in third.err
    assert "a checkout with sim_host/effects" in nowhere.err
