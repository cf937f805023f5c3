"""Guided calibration against machines whose numbers are known, because the simulator was given them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from bench_model import MODEL
from evenspin.bench import Drive, State
from evenspin.bench.calibrate import PROCEDURES, Calibration, calibrate, calibration_toml, inputs_of, undo
from evenspin.bench.errors import DriveFaultError
from evenspin.bench.operator import operator_for
from evenspin.bench.origin import Origin, rests_on
from evenspin.errors import InputError

HIDDEN = "encoder_offset.angle_el_rad=0.2&coulomb_friction.torque_nm=0.05&current_offset.offset_a_a=0.01"
COGGING = "cogging.amplitude_nm=0.1&cogging.order=18&cogging.phase_rad=0.7"


@pytest.fixture
def port(tmp_path: Path) -> str:
    path = tmp_path / "clean.toml"
    path.write_text(MODEL)
    return f"sim:{path}"


def perform(drive: Drive, *names: str) -> Calibration:
    operator = operator_for(drive.link.transport, lambda request: True)
    reported: list[float] = []
    for name in names:
        done = calibrate(drive, operator, name, reported.append)
        assert reported == [] or 0.0 <= min(reported) and max(reported) <= 1.0 + 1e-9
        assert drive.state().state is State.READY
    return done


def test_resistance_and_inductances_are_found_and_stored(port: str) -> None:
    with Drive.connect(port) as drive:
        done = perform(drive, "rl")

        assert done.found.good
        stored = drive.get(["motor_resistance_ohm", "motor_ld_h", "motor_lq_h"])
    # 15 mA of noise on a step of 1.2 A, averaged over 100 samples: below 1 %; the transient carries L in 20 samples
    assert stored["motor_resistance_ohm"] == pytest.approx(0.9, rel=0.04)
    assert stored["motor_ld_h"] == pytest.approx(0.0024, rel=0.08)
    assert stored["motor_lq_h"] == pytest.approx(0.0024, rel=0.08)


@pytest.fixture
def small(tmp_path: Path) -> str:
    """0.1 ohm and 50 uH at the defaults of the firmware: an offset calibration, and gains of another motor."""
    path = tmp_path / "small.toml"
    plant = {"pole_pairs": 7, "resistance_ohm": 0.1, "ld_h": 5e-5, "lq_h": 5e-5, "psi_wb": 5e-3, "inertia_kgm2": 5e-5,
             "viscous_nms": 2e-5, "dc_link_v": 24.0, "counts_per_rev": 4096}  # fmt: skip
    path.write_text('name = "small"\n[plant]\n' + "".join(f"{name} = {value}\n" for name, value in plant.items()))
    return f"sim:{path}"


def test_offsets_wait_for_a_drive_that_was_just_switched_on(small: str) -> None:
    with Drive.connect(small) as drive:
        assert drive.state().state is State.OFFSET_CALIBRATION
        assert perform(drive, "offsets").found.good


def test_a_current_loop_that_does_not_fit_the_motor_is_said_with_what_measures_without_one(small: str) -> None:
    with Drive.connect(small) as drive, pytest.raises(DriveFaultError, match="evenspin commission --port"):
        perform(drive, "rl")


def test_unequal_gains_of_the_sensors_are_not_taken_for_a_motor(port: str) -> None:
    with Drive.connect(f"{port}?current_gain.gain_a=1.15&current_gain.gain_b=0.85") as drive:
        before = drive.get()
        done = perform(drive, "rl")

        assert not done.found.good and "gains of the current sensors" in done.found.note
        assert drive.get() == before


def test_the_commutation_error_is_found_stored_and_gone(port: str) -> None:
    with Drive.connect(f"{port}?{HIDDEN}") as drive:
        found = perform(drive, "rl", "encoder").found
        again = perform(drive, "encoder").found
        stored = drive.get(["encoder_offset_rad", "motor_psi_wb"])

    error = next(v.value for v in found.verdicts if "error" in v.what)
    left = next(v.value for v in again.verdicts if "error" in v.what)
    assert error == pytest.approx(0.2, abs=0.035)  # 2 degrees
    assert abs(left) < 0.01
    assert stored["encoder_offset_rad"] == pytest.approx(-0.2, abs=0.01)
    assert stored["motor_psi_wb"] == pytest.approx(0.1, rel=0.01)


def test_inertia_and_friction_are_found(port: str) -> None:
    with Drive.connect(f"{port}?{HIDDEN}") as drive:
        done = perform(drive, "rl", "encoder", "mechanics")
        stored = drive.get(["observer_inertia_kgm2", "observer_viscous_nms", "rdc_coulomb_nm"])

    assert done.found.good
    assert stored["observer_inertia_kgm2"] == pytest.approx(0.0008, rel=0.05)
    assert stored["observer_viscous_nms"] == pytest.approx(0.002, rel=0.05)
    assert stored["rdc_coulomb_nm"] == pytest.approx(0.05, rel=0.05)


def test_a_virtual_drive_knows_the_motor_of_its_model(tmp_path: Path) -> None:
    """8e-4 kg m^2 is what the model of the machine says; 2 % is what noise and encoder steps leave."""
    with Drive.connect("sim:servo") as drive:
        done = perform(drive, "mechanics")

    assert done.good
    assert done.found.parameters["observer_inertia_kgm2"] == pytest.approx(8e-4, rel=0.02)
    assert [(n.name, n.origin) for n in done.inputs] == [("motor_psi_wb", Origin.MODEL)]


def test_what_rests_on_a_default_is_neither_good_nor_stored() -> None:
    with Drive.connect("sim:servo") as drive:
        default = drive.parameters["motor_psi_wb"].default
        drive.set({"motor_psi_wb": default})
        before = drive.get()
        done = perform(drive, "mechanics")

        assert done.found.good and not done.good
        assert drive.get() == before
    said = "\n".join(done.lines)
    assert "motor_psi_wb = 0.0064 Wb: default, not measured" in said
    assert "`evenspin bench calibrate encoder` measures it" in said
    assert ", good" not in said


def test_a_person_can_answer_for_a_default() -> None:
    with Drive.connect("sim:servo") as drive:
        drive.set({"motor_psi_wb": drive.parameters["motor_psi_wb"].default})
        operator = operator_for(drive.link.transport, lambda request: True)
        reported = [inputs_of(drive, operator, "mechanics", known)[0] for known in ((), ("motor_psi_wb",))]
        with pytest.raises(InputError, match="did you mean motor_psi_wb"):
            inputs_of(drive, operator, "mechanics", ("motor_psi",))

    assert [(n.origin, n.sure) for n in reported] == [(Origin.DEFAULT, False), (Origin.KNOWN, True)]


@pytest.mark.parametrize("name", [name for name, each in PROCEDURES.items() if each.rests_on])
def test_every_number_that_a_calibration_rests_on_is_asked_for(name: str) -> None:
    """A drive without a model: what somebody has set is stored, what equals the firmware's list is a default."""
    with Drive.connect("sim:servo") as drive:
        names = PROCEDURES[name].rests_on
        stored = {each.name: each.origin for each in rests_on(drive, names, {})}
        drive.set({each: drive.parameters[each].default for each in (*names, "encoder_counts")})
        drive.set({"pole_pairs": 4.0})
        default = {each.name: each.origin for each in rests_on(drive, names, {})}

    assert stored == dict.fromkeys(names, Origin.STORED)
    assert default == dict.fromkeys(("pole_pairs", "encoder_counts", *names), Origin.DEFAULT)


def test_cogging_is_found_as_the_line_that_it_is(port: str) -> None:
    with Drive.connect(f"{port}?{COGGING}") as drive:
        perform(drive, "rl", "encoder", "mechanics", "cogging")
        stored = drive.get(["rdc_line1_cycles", "rdc_line1_nm", "rdc_line1_rad"])

    assert stored["rdc_line1_cycles"] == 18.0
    assert stored["rdc_line1_nm"] == pytest.approx(0.1, rel=0.25)  # the speed is not quite even over a tooth
    assert stored["rdc_line1_rad"] == pytest.approx(0.7, abs=0.3)


def test_the_angle_observer_learns_and_the_speed_gets_even() -> None:
    with Drive.connect("sim:tang2020-rig1") as drive:
        done = perform(drive, "learning")
        method = drive.get(["method"])["method"]

    uneven, even = (verdict.value for verdict in done.found.verdicts)
    assert done.found.good and even < 0.5 * uneven
    assert drive.parameters["method"].choices[int(method)] == "aro"
    assert drive.parameters["method"].choices[int(done.before["method"])] == "pi"


@pytest.mark.parametrize(("offset_a", "good"), [(0.01, True), (0.2, False)])
def test_offsets_are_judged_without_a_move(port: str, offset_a: float, good: bool) -> None:
    with Drive.connect(f"{port}?current_offset.offset_a_a={offset_a}") as drive:
        done = perform(drive, "offsets")
        assert not drive.events  # it never left ready

    assert done.found.good is good
    assert done.found.verdicts[0].value == pytest.approx(offset_a, abs=0.005)  # half a step of the converter
    assert ("offset_calibration_periods" in done.found.note) is not good


def test_a_rotor_that_is_held_is_told_and_the_motor_stopped(port: str) -> None:
    with Drive.connect(port) as drive:
        drive.link.transport.drive.lock_rotor(True)
        with pytest.raises(DriveFaultError, match="the rotor does not turn"):
            perform(drive, "encoder")
        assert drive.state().state is State.READY


def test_a_calibration_is_undone(port: str, tmp_path: Path) -> None:
    path = tmp_path / "rl.toml"
    with Drive.connect(port) as drive:
        before = drive.get()
        done = perform(drive, "rl")
        path.write_text(calibration_toml(done, drive))
        assert drive.get() != before

        undo(path, drive)

        assert drive.get() == before


def test_the_command_says_goal_and_moves_and_leaves_a_file(evenspin, port: str, tmp_path: Path) -> None:
    path = tmp_path / "rl.toml"
    reported = evenspin("bench", "calibrate", "rl", "--dry-run")
    done = evenspin("bench", "calibrate", "rl", "--port", port, "--out", path, "--json")
    failed = evenspin(
        "bench", "calibrate", "offsets", "--port", f"{port}?current_offset.offset_a_a=0.2", "--out", tmp_path / "o.toml"
    )

    assert reported.status == 0 and PROCEDURES["rl"].moves in reported.out
    assert done.status == 0 and json.loads(done.out)["good"] is True and PROCEDURES["rl"].goal in done.err
    assert "motor_resistance_ohm" in path.read_text()
    assert failed.status == 1 and "NOT GOOD" in failed.out
    assert evenspin("bench", "calibrate", "coging", "--port", port).status == 2
