"""The pieces of the torque balance, each against a truth that it did not make."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import balance_recordings as recordings
import numpy as np
import pytest
from evenspin.balance.analysis import analyse
from evenspin.balance.angle_zero import at_zero, find_zero
from evenspin.balance.controller import find_controller
from evenspin.balance.judge_friction import name_friction
from evenspin.balance.log_reader import read_log
from evenspin.balance.motion import motion_of, speed_lag
from evenspin.balance.nominal_model import Line, read_nominal
from evenspin.balance.regression import fit, inflation
from evenspin.balance.ripple_simulation import CURRENT_LOOP_S, PWM_HZ, Plant, _prepare
from evenspin.balance.smoothing import Smoother
from evenspin.balance.time_grid import grid_of
from evenspin.balance.verdict import Verdict
from evenspin.balance.windings import suggest

T_S = 1e-3 * np.arange(8000)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_derivatives_of_the_smoother_are_those_of_a_sine_smoothed_alike(order: int) -> None:
    smooth = Smoother(5e-3, 1e-3)
    rad_s = 2.0 * np.pi * 20.0
    inner = slice(500, -500)

    found = smooth.rate(np.sin(rad_s * T_S), order)

    attenuation = np.exp(-0.5 * (rad_s * 5e-3) ** 2)  # of a Gaussian
    expected = attenuation * rad_s**order * np.sin(rad_s * T_S + order * np.pi / 2.0)
    assert found[inner] == pytest.approx(expected[inner], abs=1e-3 * attenuation * rad_s**order)


def test_an_angle_of_many_turns_at_constant_speed_has_no_acceleration() -> None:
    smooth = Smoother(1.5e-3, 0.5e-3)  # three samples wide, where a sampled kernel is coarse

    found = smooth.rate(500.0 + 25.0 * T_S, 2)[100:-100]

    assert np.max(np.abs(found)) < 1.0  # rad/s^2: a milliampere with 1e-3 A s^2/rad


def test_intervals_of_a_coloured_residue_hold_what_they_promise() -> None:
    """Slope of a ramp in noise that hardly changes from row to row: 95 % of the intervals contain it, not 20 %."""
    rng = np.random.default_rng(5)
    n, runs, hits = 2400, 200, 0
    x = np.sin(2.0 * np.pi * np.arange(n) / 40.0)
    for _ in range(runs):
        noise = np.convolve(rng.normal(size=n + 19), np.ones(20), mode="valid")
        found = fit(("slope", "level"), (x, np.ones(n)), 0.3 * x + noise)
        hits += abs(found["slope"] - 0.3) < found.half("slope")

    assert 0.88 < hits / runs <= 1.0


def test_p_values_of_nothing_are_spread_evenly() -> None:
    rng = np.random.default_rng(6)
    n = 1200
    columns = (np.sin(0.3 * np.arange(n)), np.cos(0.3 * np.arange(n)))

    p = [fit(("s", "c"), columns, rng.normal(size=n)).p_value(("s", "c")) for _ in range(300)]

    assert np.mean(np.array(p) < 0.1) == pytest.approx(0.1, abs=0.06)
    assert min(p) > 1e-4


def test_inflation_tells_a_column_that_the_others_say() -> None:
    s, c = np.sin(0.3 * np.arange(1000)), np.cos(0.3 * np.arange(1000))

    assert inflation(s, (c,)) == pytest.approx(1.0, abs=0.01)
    assert inflation(s + c + 1e-3 * np.random.default_rng(1).normal(size=1000), (s, c)) > 1e5


def test_a_pure_delay_of_the_speed_is_found_and_undone(tmp_path: Path) -> None:
    speed = 50.0 * np.sin(2.0 * np.pi * 2.0 * T_S)
    theta = -50.0 / (4.0 * np.pi) * np.cos(4.0 * np.pi * T_S)
    late = 50.0 * np.sin(4.0 * np.pi * (T_S - 2.3e-3))
    columns = {"t_s": T_S, "theta_m_rad": theta, "speed_rad_s": late, "iq_a": 1e-3 * np.gradient(speed, T_S)}
    log = read_log(recordings.write(tmp_path / "log.csv", columns))
    grid = grid_of(log)

    lag = speed_lag(log, grid)
    motion = motion_of(grid, 5e-3, lag)

    assert lag.known
    assert lag.delay_s == pytest.approx(2.3e-3, abs=2e-5)
    assert motion.speed_rad_s[motion.good] == pytest.approx(speed[motion.good], abs=0.15)


def test_the_zero_of_an_angle_is_found(tmp_path: Path) -> None:
    columns = recordings.sweep({})
    log = read_log(recordings.write(tmp_path / "log.csv", columns))
    grid = grid_of(log)
    motion = motion_of(grid, 2.5e-3, speed_lag(log, grid))
    lines = (Line(24.0, 0.1, 1.0), Line(18.0, 0.05, -0.5))
    assert motion.theta_rad is not None
    seen = motion.smooth(sum(line(motion.theta_rad) for line in at_zero(lines, 0.4)))

    assert find_zero(motion, lines, seen, motion.good) == pytest.approx(0.4, abs=2.0 * np.pi / (16 * 24))
    assert find_zero(motion, lines, np.sin(7.0 * motion.t_s), motion.good) is None


def controller_log(tmp_path: Path, added: np.ndarray) -> Path:
    rng = np.random.default_rng(3)
    speed = 6.0 + np.convolve(rng.normal(size=len(T_S)), np.hanning(30), mode="same")
    iq_a = 0.05 * (6.5 - np.interp(T_S - 2e-3, T_S, speed)) + added + 1e-3 * rng.normal(size=len(T_S))
    theta = np.cumsum(speed) * 1e-3
    columns = {"t_s": T_S, "theta_m_rad": theta, "speed_rad_s": speed, "iq_a": iq_a}
    return recordings.write(tmp_path / "log.csv", columns | {"speed_ref_rad_s": np.full_like(T_S, 6.5)})


@pytest.mark.parametrize("plain_first", [True, False])
def test_the_part_without_added_current_is_found_on_either_side(tmp_path: Path, plain_first: bool) -> None:
    late = T_S > 5.0
    added = 0.2 * np.sin(9.0 * T_S) * (late if plain_first else ~late)

    found = find_controller(grid_of(read_log(controller_log(tmp_path, added))))

    assert found is not None
    assert [part.plain for part in found.parts] == [plain_first, not plain_first]
    assert found.parts[0].end_s == pytest.approx(5.0, abs=0.02)
    assert found.gain_as_per_rad == pytest.approx(0.05, rel=0.01)
    assert found.lag_s == pytest.approx(2e-3, abs=1e-4)


def test_a_log_without_added_current_is_one_part(tmp_path: Path) -> None:
    found = find_controller(grid_of(read_log(controller_log(tmp_path, np.zeros_like(T_S)))))

    assert found is not None
    assert [part.plain for part in found.parts] == [True]


def test_a_current_that_is_no_gain_of_the_speed_error_has_no_controller(tmp_path: Path) -> None:
    added = 2.0 * np.sin(11.0 * T_S)

    assert find_controller(grid_of(read_log(controller_log(tmp_path, added)))) is None


def test_the_simulated_current_follows_as_late_as_is_allowed_for() -> None:
    simulation = _prepare(Plant(1e3, 0.0, 0.0, 0.0, ()), 0.0, 0.0)
    simulation.record(("true_iq_a",))
    simulation.run(10, 1)

    simulation.set_input("iq_ref_a", (0.0,), (1.0,))
    answer = simulation.run(200, 1)[:, 0]

    assert np.sum(1.0 - answer) / PWM_HZ == pytest.approx(CURRENT_LOOP_S, abs=0.5 / PWM_HZ)


def test_orders_of_a_machine_suggest_its_slots_and_poles() -> None:
    """12 slots, 10 poles: lcm 60, slots 12 and 24, poles 10 and 20, electrical frequency 5."""
    lines = [(60, 0.05), (12, 0.03), (10, 0.02), (24, 0.01), (20, 0.01), (5, 0.01)]

    best = suggest(lines, highest=100)[0]

    assert (best.slots, best.pole_pairs) == (12, 5)
    assert best.covered == pytest.approx(1.0)


def test_known_pole_pairs_are_kept() -> None:
    assert {winding.pole_pairs for winding in suggest([(24, 0.1)], 100, pole_pairs=4)} == {4}


def test_without_lines_nothing_is_suggested() -> None:
    assert suggest([], 100) == []


def test_a_model_in_newton_metres_becomes_amperes() -> None:
    nominal = read_nominal("guo2024")

    assert nominal.kt_nm_per_a == pytest.approx(1.5 * 4 * 6.4e-3)
    assert nominal.inertia_as2 == pytest.approx(7.06e-5 / (1.5 * 4 * 6.4e-3))
    assert nominal.pole_pairs == 4
    assert replace(nominal, coulomb_a=0.1).friction(np.array([-1.0, 2.0])) == pytest.approx([-0.1, 0.1])


def test_an_effect_without_an_interval_of_the_whole_log_is_held_against_and_does_not_end_the_work() -> None:
    log = read_log(recordings.REAL / "acc_current.csv.gz")
    analysis = analyse(log, None, None, None)
    assert analysis.friction is not None
    lost = {name: half for name, half in analysis.friction.half.items() if not name.startswith("coulomb_friction")}
    verdict = Verdict()

    name_friction(replace(analysis, friction=replace(analysis.friction, half=lost)), verdict)

    assert "coulomb_friction" not in verdict.names
    assert any(effect == "coulomb_friction" and "whole log" in why for effect, why in verdict.against)
