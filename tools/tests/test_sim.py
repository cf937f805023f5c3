"""A scenario through the firmware: repeatable, whole, and with the physics of the machine."""

import math
from dataclasses import replace

import numpy as np
import pytest
from evenspin.errors import NativeError
from evenspin.model import InputCurve, Tune, builtin_scenario, load_scenario
from evenspin.sim import simulate

RPM = math.pi / 30.0


@pytest.fixture
def setup(scenario):
    return load_scenario(scenario).setup


def noisy(setup, seed):
    return replace(setup, plant={**setup.plant, "current_noise_a": 0.05}, seed=seed)


def test_the_same_seed_gives_the_same_bytes(setup):
    first, second = (simulate(noisy(setup, 3)).values.tobytes() for _ in range(2))

    assert first == second


def test_another_seed_gives_other_noise(setup):
    one, other = (simulate(noisy(setup, seed), ("ia_a",))["ia_a"] for seed in (3, 4))

    assert not np.array_equal(one, other)


def test_rows_are_evenly_spaced_from_zero(setup):
    t_s = simulate(setup, ("t_s",))["t_s"]

    assert t_s == pytest.approx(np.arange(1000) / 2000.0, abs=1e-12)


def test_a_change_of_a_parameter_does_not_disturb_the_rows(setup):
    tuned = replace(setup, tunes=(Tune(0.1234, "rc_gain", 0.6), Tune(0.2, "rc_gain", 0.6)))

    assert simulate(tuned).values == pytest.approx(simulate(setup).values, nan_ok=True)


def test_a_parameter_changes_while_it_runs(setup):
    tuned = replace(setup, tunes=(Tune(0.2, "rc_limit_unit", 0.01),))

    correction = simulate(tuned, ("t_s", "rc_out_unit"))

    assert np.abs(correction.between(0.15, 0.2)["rc_out_unit"]).max() > 0.1
    assert np.abs(correction.between(0.21, 0.5)["rc_out_unit"]).max() <= 0.010001


def test_what_changes_at_rest_only_is_refused_while_it_runs(setup):
    with pytest.raises(NativeError, match=r"method = 0: cannot change while the drive runs; stop it first"):
        simulate(replace(setup, tunes=(Tune(0.2, "method", 0.0),)), ("t_s",))


def test_a_board_in_the_model_has_the_last_word(setup):
    board = replace(setup, plant={**setup.plant, "board_current_a": 15.0, "board_speed_rad_s": 400.0})
    with pytest.raises(NativeError, match=r"over_current_a = 20: the board allows at most 15 A"):
        simulate(board, ("t_s",))
    fits = {**setup.drive, "over_current_a": 15.0}
    with pytest.raises(NativeError, match=r"over_speed_rad_s = 650: the board allows at most 400 rad/s"):
        simulate(replace(board, drive=fits), ("t_s",))
    simulate(replace(board, drive={**fits, "over_speed_rad_s": 400.0}, duration_s=0.01), ("t_s",))


def test_a_speed_reference_that_would_trip_is_refused(setup):
    with pytest.raises(NativeError, match=r"speed_ref_rad_s = .*: must be within over_speed_rad_s, \+-10 rad/s"):
        simulate(replace(setup, drive={**setup.drive, "over_speed_rad_s": 10.0}), ("t_s",))


def test_progress_ends_at_the_end(setup):
    seen = []
    simulate(replace(setup, duration_s=1.7), ("t_s",), progress=seen.append)

    assert seen[-1] == pytest.approx(1.7)
    assert seen == sorted(seen)


def test_a_locked_rotor_answers_a_voltage_as_a_coil_does(setup):
    """A P controller on R and L, one period of delay: i' = phi i + (1 - phi) / R v of the period before."""
    kp = 0.05
    plant = {**setup.plant, "rotor_locked": 1.0, "counts_per_rev": 0.0}
    drive = {**setup.drive, "current_kp_v_per_a": kp, "current_ki_v_per_as": 0.0}
    inputs = {"control_mode": InputCurve((0.0,), (0.0,)), "id_ref_a": InputCurve((0.0,), (2.0,))}
    run = replace(setup, plant=plant, drive=drive, effects={}, inputs=inputs, duration_s=0.01, log_rate_hz=1e4)

    record = simulate(run, ("t_s", "true_id_a"))

    phi = math.exp(-0.36 * 1e-4 / 0.2e-3)
    expected, applied_v = [0.0], 0.0
    for _ in range(len(record) - 1):
        command_v = kp * (2.0 - expected[-1])
        expected.append(phi * expected[-1] + (1.0 - phi) / 0.36 * applied_v)
        applied_v = command_v
    assert record["true_id_a"] == pytest.approx(expected, rel=1e-4, abs=1e-7)


def test_a_coasting_rotor_slows_down_as_its_inertia_says(setup):
    """No current, only viscous friction: w = w0 exp(-t B / J)."""
    plant = {**setup.plant, "initial_speed_rad_s": 50.0, "viscous_nms": 1e-4, "counts_per_rev": 0.0, "psi_wb": 0.0}
    inputs = {"control_mode": InputCurve((0.0,), (0.0,))}
    run = replace(setup, plant=plant, effects={}, inputs=inputs, duration_s=1.0)

    record = simulate(run, ("t_s", "true_speed_rad_s"))

    expected = 50.0 * np.exp(-record["t_s"] * 1e-4 / 7.06e-5)
    assert record["true_speed_rad_s"] == pytest.approx(expected, rel=2e-3)


def test_power_is_conserved_in_steady_state(setup):
    """Torque = brake + friction; v_q = R i_q + w p psi."""
    run = replace(setup, effects={}, duration_s=2.0)

    steady = simulate(run).between(1.8, 2.0)

    speed, iq_a = steady["true_speed_rad_s"].mean(), steady["true_iq_a"].mean()
    k_t = 1.5 * 4 * 6.4e-3
    assert speed == pytest.approx(300 * RPM, rel=1e-3)
    assert iq_a == pytest.approx(2.0 + speed * 2e-5 / k_t, rel=5e-3)
    assert steady["vq_v"].mean() == pytest.approx(0.36 * iq_a + speed * 4 * 6.4e-3, rel=1e-2)


def test_fixed_point_and_float_turn_alike(setup):
    speeds = [simulate(setup, ("true_speed_rad_s",), numeric)["true_speed_rad_s"] for numeric in ("float", "fixed")]

    assert np.abs(speeds[0] - speeds[1]).max() < 0.5 * RPM
    assert not np.array_equal(*speeds)  # two builds, indeed


@pytest.mark.parametrize("part", ["plant", "drive"])
def test_what_the_library_refuses_is_an_error(setup, part):
    wrong = replace(setup, **{part: {**getattr(setup, part), "warp_factor": 9.0}})

    with pytest.raises(NativeError, match="warp_factor"):
        simulate(wrong)


def test_a_signal_that_does_not_exist_is_an_error(setup):
    with pytest.raises(NativeError, match="nonsense"):
        simulate(setup, ("nonsense",))


def test_what_does_not_fit_together_is_blamed_on_a_line(scenario):
    scenario.write_text(scenario.read_text().replace("[drive]", "[drive]\nrc_q_centre = 0.9"))
    loaded = load_scenario(scenario)

    with pytest.raises(NativeError) as refusal:
        simulate(loaded.setup)

    assert str(loaded.locate(refusal.value)).startswith(f"{scenario}:8: drive.rc_q_centre = 0.9: must be ")


def test_every_set_of_the_paper_runs_without_a_fault():
    setup = builtin_scenario("guo2024/second").setup

    assert simulate(setup, ("fault", "state"))["fault"].max() == 0.0
