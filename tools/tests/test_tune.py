"""`evenspin tune`: gains with the margins that they claim, on machines of every size, in a file that all take."""

from __future__ import annotations

import json
import math
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from evenspin.bench import Drive
from evenspin.errors import InputError
from evenspin.model import load_machine
from evenspin.model.machine import builtin_models
from evenspin.tune.gains import complete, first_gains
from evenspin.tune.goals import GOALS
from evenspin.tune.loops import current_margins, speed_loop, speed_margins
from evenspin.tune.methods import speed_verdict, speed_verdicts
from evenspin.tune.ripple import repetitive_gains
from evenspin.tune.trial import ripple_of, speed_trial, top_speed
from evenspin.tune.tuning import limits_of, tune
from random_machines import random_machine

SERVO = builtin_models()["servo"]
# The motors of a first user: with the default gains the first tripped within 3.5 ms, the second at once.
LIGHT = """
name = "light"
[plant]
pole_pairs = 7
resistance_ohm = 0.1
ld_h = 50e-6
lq_h = 50e-6
psi_wb = 5e-3
inertia_kgm2 = 5e-5
viscous_nms = 2e-5
rated_current_a = 8.0
dc_link_v = 24.0
counts_per_rev = 4096
"""
HIGH = """
name = "high"
[plant]
pole_pairs = 4
resistance_ohm = 1.2
ld_h = 6e-3
lq_h = 9e-3
psi_wb = 0.11
inertia_kgm2 = 2e-3
viscous_nms = 1e-3
rated_current_a = 7.0
dc_link_v = 400.0
counts_per_rev = 131072
"""


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


@pytest.mark.parametrize("crossover_hz", [100.0, 400.0])
def test_the_margin_of_the_current_loop_is_that_of_an_integrator_with_one_and_a_half_periods(
    crossover_hz: float,
) -> None:
    """k_p = w L, k_i = w R cancels the winding: w / s with the delay of calculation and hold, on paper."""
    plant = {"pwm_hz": 1e4, "resistance_ohm": 0.5, "ld_h": 5e-3}
    w = 2.0 * math.pi * crossover_hz
    found = current_margins(plant, "d", w * 5e-3, w * 0.5)
    assert found.crossover_hz == pytest.approx(crossover_hz, rel=0.01)
    assert found.phase_deg == pytest.approx(90.0 - math.degrees(w * 1.5e-4), abs=0.5)
    assert found.delay_s == pytest.approx(math.radians(found.phase_deg) / w, rel=0.02)


def test_the_gain_margin_of_the_speed_loop_is_where_a_pole_leaves_the_unit_circle() -> None:
    machine = load_machine(SERVO)
    drive = complete(machine.drive)
    margins = speed_margins(speed_loop(machine.plant, drive, 40.0))

    def radius(part: float) -> float:
        names = ("speed_kp_a_per_unit", "speed_ki_a_per_unit_s")
        louder = {**drive, **{name: part * margins.gain * drive[name] for name in names}}
        return speed_loop(machine.plant, louder, 40.0).radius

    assert radius(0.97) < 1.0 < radius(1.03)


def test_an_unstable_loop_has_no_margin() -> None:
    machine = load_machine(SERVO)
    drive = complete(machine.drive) | {"speed_kp_a_per_unit": 20.0}
    assert speed_margins(speed_loop(machine.plant, drive, 40.0)).phase_deg == 0.0
    assert current_margins(machine.plant, "q", 100.0, 1e5).phase_deg == 0.0


@pytest.mark.parametrize("goal", GOALS)
@pytest.mark.parametrize("text", [LIGHT, HIGH], ids=["24 V, 50 uH", "400 V"])
def test_motors_on_which_the_defaults_trip_start_take_a_load_reverse_and_run_fast(
    tmp_path: Path, text: str, goal: str
) -> None:
    machine = load_machine(written(tmp_path / "m.toml", text))
    found = tune(machine, goal, methods=False)
    assert found.good, found.problems
    assert found.gains.speed.phase_deg >= GOALS[goal].speed_margin_deg
    assert found.gains.speed_worst.distance >= GOALS[goal].corner_distance
    for trial in found.trials:
        assert trial.peak_a < found.drive["over_current_a"]


def test_the_goals_differ_as_their_names_say(tmp_path: Path) -> None:
    machine = load_machine(written(tmp_path / "m.toml", HIGH))
    stiff, smooth, quiet = (tune(machine, goal, methods=False) for goal in ("stiff", "smooth", "quiet"))

    def dip(found) -> float:
        return next(r.dip_rad_s for r in found.trials[0].responses if r.stretch.name == "load step")

    assert dip(stiff) < 0.85 * dip(smooth) < 0.7 * dip(quiet)


@pytest.mark.parametrize("seed", [2, 9])
def test_machines_drawn_at_random_are_tuned(tmp_path: Path, seed: int) -> None:
    drawn = random_machine(seed)
    text = drawn.toml().replace("[plant]", f"[plant]\nrated_current_a = {0.5 * drawn.max_current_a}")
    found = tune(load_machine(written(tmp_path / "m.toml", text)), "smooth", methods=False)
    assert found.good, found.problems


def test_a_fine_encoder_counts_through_a_speed_sample_at_a_high_speed(tmp_path: Path) -> None:
    """More than 32767 counts a sample: a measured speed that stood still there would let the motor run away."""
    machine = load_machine(written(tmp_path / "m.toml", HIGH.replace("131072", "1048576")))
    limits, _ = limits_of(machine)
    gains = first_gains(machine.plant, limits, {}, GOALS["smooth"])
    assert gains.drive["speed_source"] == 1.0, "mt"
    assert speed_trial(machine.plant, gains.drive, 0.3, "mt").good


def test_the_top_speed_is_where_the_voltage_ends() -> None:
    """Without load: 0.92 Vdc / sqrt(3) over p psi."""
    plant = load_machine(SERVO).plant
    w = top_speed({**plant, "viscous_nms": 0.0}, {"over_speed_rad_s": 1e4})
    assert w == pytest.approx(0.92 * 150.0 / math.sqrt(3.0) / 0.3, rel=1e-6)


def test_a_repetitive_observer_whose_memory_is_too_short_is_said_with_its_speed(tmp_path: Path) -> None:
    """6112 samples at 10 kHz hold a turn from 98 r/min on; this direct drive ends at 20."""
    text = HIGH.replace("psi_wb = 0.11", "psi_wb = 7.0").replace("pole_pairs = 4", "pole_pairs = 14")
    machine = load_machine(written(tmp_path / "m.toml", text.replace("inertia_kgm2 = 2e-3", "inertia_kgm2 = 2.0")))
    limits, _ = limits_of(machine)
    drive = first_gains(machine.plant, limits, {}, GOALS["smooth"]).drive
    rc = replace(repetitive_gains(machine.plant, drive, GOALS["smooth"]), reason="left out of this test")
    heavy = {**machine.plant, "inertia_kgm2": 2.0}
    found = {v.method: v for v in speed_verdicts(heavy, drive, rc, {}) if v.method == "ro"}
    assert found["ro"].word == "cannot"
    assert "127.6 r/min" in found["ro"].text  # 1.3 times 98.2


def test_an_encoder_that_is_too_coarse_for_an_observer_is_said_with_one_that_is_not(tmp_path: Path) -> None:
    found = {}
    for counts in ("1024", "4096"):
        machine = load_machine(written(tmp_path / "m.toml", LIGHT.replace("_per_rev = 4096", f"_per_rev = {counts}")))
        limits, _ = limits_of(machine)
        drive = first_gains(machine.plant, limits, {}, GOALS["stiff"]).drive
        rc = repetitive_gains(machine.plant, drive, GOALS["stiff"])
        without = ripple_of(machine.plant, drive, 4.5, 12.0)
        found[counts] = speed_verdict(machine.plant, drive, rc, {}, "aro", 4.5, without)
    assert found["1024"].word != "helps"
    assert "1024 counts is too coarse" in found["1024"].text and "4096 counts would do" in found["1024"].text
    assert found["4096"].word == "helps"


def test_the_file_is_taken_by_a_drive_a_model_and_a_run(evenspin, tmp_path: Path) -> None:
    model = written(tmp_path / "m.toml", LIGHT)
    out = tmp_path / "drive.toml"
    said = evenspin("tune", model, "--goal", "quiet", "--no-methods", "--out", out, "--json")
    assert said.status == 0, said.err
    answer = json.loads(said.out)
    assert answer["good"] and answer["margins"]["speed"]["phase_deg"] >= GOALS["quiet"].speed_margin_deg
    written(model, 'drive_file = "drive.toml"\n' + LIGHT)
    values = tomllib.loads(out.read_text())["drive"]
    assert load_machine(model).drive["speed_kp_a_per_unit"] == values["speed_kp_a_per_unit"]
    pushed = evenspin("bench", "config", "push", out, "--port", f"sim:{model}", "--json")
    assert (pushed.status, json.loads(pushed.out)) == (0, {}), pushed.err  # it holds them already
    with Drive.connect(f"sim:{model}") as drive:
        drive.run_speed(50.0)
        drive.sleep(1.0)
        assert drive.read(("speed_rad_s",))["speed_rad_s"] == pytest.approx(50.0, rel=0.02)
    for other in ("[drive]\nauto_run = true\nalign_periods = 0\noffset_calibration_periods = 0\n",):
        run = written(tmp_path / "r.toml", f'name = "r"\nmodel = "m.toml"\nduration_s = 1.0\n{other}\n'
                      "[[event]]\nat_s = 0.0\nspeed_rad_s = 50.0\n")  # fmt: skip
        assert evenspin("run", run, "--out", tmp_path / "out").status == 0


def test_auto_run_is_never_in_a_drive_file(evenspin, tmp_path: Path) -> None:
    """guo2024 has it: a simulation may start by itself, a drive that this file is pushed to must not."""
    out = tmp_path / "drive.toml"
    assert evenspin("tune", "guo2024", "--no-methods", "--out", out).status == 0
    drive = tomllib.loads(out.read_text())["drive"]
    assert not {"auto_run", "align_periods"} & drive.keys()


def test_what_is_wrong_is_one_line(evenspin, tmp_path: Path) -> None:
    said = evenspin("tune", "servo", "--goal", "smoth")
    assert (said.status, len(said.err.splitlines())) == (2, 1) and "smooth" in said.err
    model = written(tmp_path / "m.toml", LIGHT.replace("rated_current_a = 8.0\n", ""))
    said = evenspin("tune", model)
    assert said.status == 2 and "rated_current_a" in said.err and "iq_limit_a" in said.err
    with pytest.raises(InputError, match="goal"):
        tune(load_machine(SERVO), "fast")
