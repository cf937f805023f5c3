"""Inertia and friction from a pseudo-random torque: on motions in closed form, and on the simulated drive."""

import json
import tomllib

import numpy as np
import pytest
from evenspin.errors import InputError
from evenspin.identify.mechanics import identify_mechanics
from evenspin.identify.prbs import plan
from evenspin.identify.source import Run
from evenspin.model import load_machine
from evenspin.model.machine import builtin_models
from evenspin.native import tables
from scipy.signal import cont2discrete, max_len_seq

TS = 5e-4
J, B, T0 = 2e-3, 5e-3, 0.03


def run_of(torque, *, counts=None, noise_nm=0.0, speed=0.0, inertia=J):
    """The shaft under a torque that is held over each sample, exactly; the angle as an encoder shows it."""
    system = (
        np.array([[0.0, 1.0], [0.0, -B / inertia]]),
        np.array([[0.0], [1.0 / inertia]]),
        np.eye(2),
        np.zeros((2, 1)),
    )
    step, push, *_ = cont2discrete(system, TS)
    state, theta = np.array([0.3, speed]), np.empty(len(torque))
    for k, each in enumerate(torque):
        theta[k] = state[0]
        state = step @ state + push[:, 0] * (each - T0)
    if counts:
        theta = np.floor(theta / (2.0 * np.pi) * counts) / counts * 2.0 * np.pi
    # a log shows the torque between two of its samples as the mean of both
    shown = np.concatenate((torque[:1], 0.5 * (torque[1:] + torque[:-1])))
    noise = noise_nm * np.random.default_rng(2).standard_normal(len(torque))
    return Run("prbs", TS, theta, np.zeros(len(torque)), shown + noise)


def sequence(amplitude=0.1, mean=T0 + B * 40.0, bit=100):
    return mean + amplitude * np.repeat(2.0 * max_len_seq(7)[0] - 1.0, bit)


@pytest.mark.parametrize(("counts", "noise_nm"), [(None, 0.0), (4000, 0.0), (131072, 0.002)])
def test_a_motion_in_closed_form_gives_back_its_parameters(counts, noise_nm):
    found = identify_mechanics([run_of(sequence(), counts=counts, noise_nm=noise_nm, speed=40.0)])

    assert found.inertia_kgm2.value == pytest.approx(J, rel=3e-3)
    assert found.viscous_nms.value == pytest.approx(B, rel=1e-2)
    assert found.constant_nm.value == pytest.approx(T0, rel=3e-2)


def test_the_interval_holds_the_truth_and_is_not_idle():
    found = identify_mechanics([run_of(sequence(), noise_nm=0.02, speed=40.0)])

    assert abs(found.inertia_kgm2.value - J) < 1.5 * found.inertia_kgm2.half < 0.03 * J
    assert abs(found.viscous_nms.value - B) < 1.5 * found.viscous_nms.half < 0.2 * B


def test_turning_backwards_gives_the_same_numbers():
    there = run_of(sequence(), speed=40.0)
    back = Run("back", TS, -there.theta_rad, there.speed_ref_rad_s, -there.torque_nm)

    found = identify_mechanics([back])

    assert found.inertia_kgm2.value == pytest.approx(J, rel=3e-3)
    assert found.constant_nm.value == pytest.approx(T0, rel=3e-2)


def test_two_logs_are_fitted_together():
    runs = [run_of(sequence(bit=bit), speed=40.0) for bit in (60, 100)]

    found = identify_mechanics(runs)

    assert found.inertia_kgm2.value == pytest.approx(J, rel=3e-3)
    assert len(found.t_s) > len(identify_mechanics(runs[:1]).t_s)


@pytest.mark.parametrize(("run", "reported"), [
    (run_of(np.full(8000, T0 + B * 40.0), counts=4000, noise_nm=0.001, speed=40.0), "inertia"),
    (run_of(sequence(amplitude=5e-4), counts=4000, noise_nm=0.01, speed=40.0), "inertia"),
    (Run("locked", TS, np.full(9000, 1.0), np.zeros(9000), sequence()[:9000]), "windows"),
    (run_of(sequence()[:400], speed=40.0), "windows"),
])  # fmt: skip
def test_data_that_are_not_enough_are_refused_with_the_reason(run, reported):
    with pytest.raises(InputError) as refusal:
        identify_mechanics([run])

    assert reported in str(refusal.value)
    assert "\n" not in str(refusal.value)


# ---- the experiment ------------------------------------------------------------------------------------------------


def machine_and_drive(name):
    machine = load_machine(builtin_models()[name])
    return machine, {key: field.default for key, field in tables().params.items()} | dict(machine.drive)


@pytest.mark.parametrize("name", ["tang2020-rig1", "tang2020-rig2", "guo2024"])
def test_the_plan_is_safe_for_the_machine(name):
    machine, drive = machine_and_drive(name)

    wanted = plan(machine, drive)

    assert 0.0 < wanted.amplitude_a <= 0.5 * machine.plant["rated_current_a"]
    assert wanted.speed_rad_s + wanted.expected_swing_rad_s < 0.5 * drive["over_speed_rad_s"]
    assert wanted.expected_swing_rad_s <= 0.301 * wanted.speed_rad_s
    assert len(wanted.signs) == 127 and set(wanted.signs) == {-1.0, 1.0}


@pytest.mark.parametrize("model", ["tang2020-rig1", "tang2020-rig2", "guo2024"])
def test_the_simulated_drive_with_its_encoder_gives_both_within_two_percent(evenspin, tmp_path, model):
    said = evenspin("identify", "mechanics", "--method", "prbs", "--run", "sim", model, "--json", tmp_path / "m.json")

    found = json.loads((tmp_path / "m.json").read_text())
    plant = load_machine(builtin_models()[model]).plant
    assert said.status == 0
    assert found["inertia_kgm2"] == pytest.approx(plant["inertia_kgm2"], rel=0.02)
    assert found["viscous_nms"] == pytest.approx(plant["viscous_nms"], rel=0.02)
    low, high = found["interval_95"]["inertia_kgm2"]
    assert 0.0 < high - low < 0.02 * plant["inertia_kgm2"]


def test_what_is_found_does_not_follow_what_the_model_of_the_drive_assumes(evenspin, tmp_path):
    """The plant has 1.4 times the inertia that the plan counts with: an effect, which the plan does not know."""
    text = builtin_models()["tang2020-rig2"].read_text() + "\n[effects.inertia]\nfactor = 1.4\n"
    (tmp_path / "heavy.toml").write_text(text)

    said = evenspin("identify", "mechanics", "--run", "sim", tmp_path / "heavy.toml", "--json")

    assert json.loads(said.out)["inertia_kgm2"] == pytest.approx(1.4 * 9e-4, rel=0.02)


def test_the_output_holds_model_log_and_report_and_the_log_gives_the_same(evenspin, tmp_path):
    out = tmp_path / "out"

    said = evenspin(
        "identify", "mechanics", "--run", "sim", "tang2020-rig2", "--out", out, "--json", tmp_path / "a.json"
    )
    again = evenspin("identify", "mechanics", out / "log", "--json", tmp_path / "b.json", "--plot", tmp_path / "b.svg")

    assert (said.status, again.status) == (0, 0)
    first, second = (json.loads((tmp_path / name).read_text()) for name in ("a.json", "b.json"))
    assert second["inertia_kgm2"] == pytest.approx(first["inertia_kgm2"], rel=1e-5)
    assert "<svg" in (tmp_path / "b.svg").read_text()
    model = tomllib.loads((out / "model.toml").read_text())
    assert model["plant"]["inertia_kgm2"] == pytest.approx(first["inertia_kgm2"], rel=1e-5)
    assert model["drive"]["observer_viscous_nms"] == pytest.approx(first["viscous_nms"], rel=1e-5)
    assert load_machine(out / "model.toml").plant["pole_pairs"] == 5
    assert (out / "report.html").is_file()


def test_a_dry_run_moves_nothing_and_tells_the_plan(evenspin, tmp_path):
    said = evenspin("identify", "mechanics", "--run", "sim", "tang2020-rig2", "--dry-run", "--out", tmp_path / "out")

    assert said.status == 0
    assert "amplitude_a = " in said.out and "bit_s = " in said.out
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("words", "reported"), [
    (("--run", "sim"), "MODEL"),
    (("--run", "bench", "tang2020-rig2"), "--run"),
    (("--run", "sim", "tang"), "MODEL"),
    ((), "LOG"),
    (("none.csv",), "existing file"),
    (("none.csv", "--dry-run"), "--dry-run"),
    (("none.csv", "--bits", "8"), "--bits"),
    (("--run", "sim", "tang2020-rig2", "--bits", "30"), "--bits"),
    (("--run", "sim", "tang2020-rig2", "--bit-s", "0"), "--bit-s"),
    (("--run", "sim", "tang2020-rig2", "--amplitude-a", "1000"), "--amplitude-a"),
    (("--run", "sim", "tang2020-rig2", "--amplitude-a", "nan"), "--amplitude-a"),
    (("--run", "sim", "tang2020-rig2", "--speed-rpm", "0"), "--speed-rpm"),
    (("--run", "sim", "tang2020-rig2", "--speed-rpm", "1e5"), "--speed-rpm"),
    (("--run", "sim", "tang2020-rig2", "--window-s", "0.001"), "--window-s"),
    (("--run", "sim", "tang2020-rig2", "--window-s", "nan"), "--window-s"),
    (("--run", "sim", "tang2020-rig2", "--amplitude-a", "0.001"), "viscous"),
])  # fmt: skip
def test_bad_input_is_one_line_that_names_the_culprit(evenspin, words, reported):
    said = evenspin("identify", "mechanics", *words)

    assert said.status == 2
    assert said.err.count("\n") == 1
    assert reported in said.err
