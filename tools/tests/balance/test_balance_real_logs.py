"""What is said about recordings of a real servo motor. Bounds were set before anything was printed."""

from __future__ import annotations

import json
from pathlib import Path

import balance_recordings as recordings
import numpy as np
import pytest
from evenspin.balance import BalanceResult, run_balance
from evenspin.model.machine import load_machine

Real = tuple[BalanceResult, Path]


def test_the_free_run_goes_from_inertia_and_viscous_friction_to_coulomb_friction(free_run: Real) -> None:
    assert free_run[0].verdict["verdict"] == ["coulomb_friction"]


def test_coulomb_friction_takes_the_residue_of_the_validation_half_to_at_most_0_55(free_run: Real) -> None:
    verdict = free_run[0].verdict

    ratio = verdict["gap_after"] / verdict["gap_before"]

    # Two-sided: half of the residue is noise and ripple, so that a much better figure would be a leak between halves.
    assert 0.25 < ratio <= 0.55


def test_the_gap_can_be_recomputed_from_balance_csv(free_run: Real) -> None:
    result, folder = free_run
    with (folder / "balance.csv").open() as file:
        names = file.readline().strip().split(",")
        table = np.loadtxt(file, delimiter=",")
    column = {name: table[:, i] for i, name in enumerate(names)}
    valid = column["friction_half"] == 2.0

    before, after = (np.sqrt(np.mean(column[f"friction_{name}_a"][valid] ** 2)) for name in ("before", "after"))

    assert before == pytest.approx(result.verdict["gap_before"], rel=1e-6)
    assert after == pytest.approx(result.verdict["gap_after"], rel=1e-6)


def test_stretches_that_validate_lie_between_those_that_fit_and_share_no_row(free_run: Real) -> None:
    found = free_run[0].analysis.friction

    assert found is not None
    assert not np.any(found.fit_rows & found.validation_rows)
    fits, validates = np.flatnonzero(found.fit_rows), np.flatnonzero(found.validation_rows)
    assert np.median(fits) == pytest.approx(np.median(validates), rel=0.1)  # halves would differ by a factor


def test_friction_that_bends_the_wrong_way_is_not_called_stribeck(free_run: Real) -> None:
    verdict = free_run[0].verdict
    stribeck = next(e for e in verdict["evidence"] if e["effect"] == "stribeck_friction")

    assert not stribeck["named"]
    assert "less than linearly" in stribeck["why"]
    assert any("less than linearly" in text and "unexplained" in text for text in verdict["unexplained"])


def test_parameters_of_the_shaft_agree_with_an_estimate_by_energy(free_run: Real) -> None:
    """Over whole swings inertia does no work: iq w = B w^2 + Tc |w| on average. No derivative enters."""
    log = recordings.read(recordings.REAL / "acc_current.csv.gz")
    swing = 500  # rows of 1 ms: the period of the 2 Hz current
    late = 2  # rows: about how much later the speed estimate is
    w, iq = log["speed_rad_s"][late:], log["iq_a"][:-late]
    rows = slice(0, len(w) // swing * swing)
    power = np.mean(iq[rows] * w[rows])
    identified = free_run[0].verdict["identified"]
    viscous, coulomb = (
        identified[f"{name}"]["value"]
        for name in ("viscous_friction.viscous_as_per_rad", "coulomb_friction.torque_a_equiv")
    )

    found = viscous * np.mean(w[rows] ** 2) + coulomb * np.mean(np.abs(w[rows]))

    # 0.18 ms between the rounded and the true lag turn 1 % of the reactive power into real: 20 % of that of friction
    assert found == pytest.approx(power, rel=0.2)


def test_intervals_allow_for_the_sampling_of_current_and_angle(free_run: Real) -> None:
    viscous = free_run[0].verdict["identified"]["viscous_friction.viscous_as_per_rad"]

    # half a row of 1 ms times J/Kt (2 pi 2 Hz)^2 is what a delay pretends to be
    assert 0.5 * 0.5e-3 * 1.9e-4 * (4 * np.pi) ** 2 < viscous["half"] < 0.3 * viscous["value"]


def test_gaps_in_time_are_said(free_run: Real) -> None:
    assert any("6 gaps in time" in text for text in free_run[0].verdict["repairs"])


@pytest.mark.search
def test_the_model_that_is_written_loads_and_explains_the_log(free_run: Real, tmp_path: Path) -> None:
    path = free_run[1] / "model.toml"
    machine = load_machine(path)

    again = run_balance(recordings.REAL / "acc_current.csv.gz", path, tmp_path)

    assert machine.torque_per_a_nm == pytest.approx(1.0)
    assert again.verdict["verdict"] == ["unknown"]  # what is left at low speed has no name
    assert again.verdict["parameters"] == {}
    assert again.verdict["gap_before"] == pytest.approx(free_run[0].verdict["gap_after"], rel=0.01)


def test_the_half_without_compensation_is_found_and_where_it_ends(speed_test: Real) -> None:
    first, second = speed_test[0].verdict["controller"]["parts"]

    assert (first["compensated"], second["compensated"]) == (False, True)
    assert first["end_s"] == pytest.approx(8.0, abs=0.05)  # the recording was switched at 8.0 s


def test_the_gain_of_the_recorded_controller_is_found(speed_test: Real) -> None:
    # 0.09 A s/rad by the source of the recording; the drive delivers a few per cent less than its reference at 50 Hz
    assert speed_test[0].verdict["controller"]["gain_as_per_rad"] == pytest.approx(0.09, rel=0.07)


def test_cogging_is_named_with_its_order_and_amplitude(speed_test: Real) -> None:
    verdict = speed_test[0].verdict
    cogging = verdict["parameters"]["cogging"]

    assert verdict["verdict"] == ["cogging"]
    assert cogging["order"] == 72
    assert 0.17 < cogging["amplitude_a_equiv"] < 0.22
    assert verdict["gap_after"] < 0.3 * verdict["gap_before"]


def test_cogging_of_both_halves_is_one_effect(speed_test: Real) -> None:
    """In one half the ripple is in the speed, in the other in the current: the torque is the same."""
    strongest = speed_test[0].verdict["orders"][0]

    assert strongest["order"] == 72
    assert strongest["halves_differ"] < 0.25


def test_the_first_three_orders_are_those_of_the_machine(speed_test: Real) -> None:
    orders = [each["order"] for each in speed_test[0].verdict["orders"] if each["in_both_halves"]]

    assert orders[0] == 72
    assert set(orders[:5]) == {72, 18, 24, 12, 36}


def test_the_simulated_speed_ripple_is_within_a_quarter_of_the_measured(speed_test: Real) -> None:
    ripple = speed_test[0].verdict["speed_ripple"]

    assert ripple["ratio"] == pytest.approx(1.0, abs=0.25)
    assert ripple["orders"][0]["simulated_rad_s"] == pytest.approx(ripple["orders"][0]["measured_rad_s"], rel=0.25)
    assert ripple["simulated_without_rad_s_rms"] < 0.05 * ripple["measured_rad_s_rms"]


@pytest.mark.search
def test_without_a_model_the_log_tells_its_own_inertia(free_run: Real, tmp_path: Path) -> None:
    alone = run_balance(recordings.REAL / "speed_test.csv.gz", None, tmp_path).verdict
    swept = free_run[0].verdict["identified"]["inertia.inertia_as2_per_rad"]["value"]

    assert alone["verdict"] == ["cogging"]
    assert alone["speed_ripple"]["ratio"] == pytest.approx(1.0, abs=0.25)
    # another experiment, another frequency (70 Hz instead of 2), the same rotor
    assert alone["identified"]["inertia.inertia_as2_per_rad"]["value"] == pytest.approx(swept, rel=0.1)


@pytest.mark.search
def test_the_angle_alone_gives_the_same_cogging(speed_test: Real, tmp_path: Path) -> None:
    """Another path to speed and acceleration, through no filter of the drive."""
    columns = recordings.read(recordings.REAL / "speed_test.csv.gz")
    del columns["speed_rad_s"]

    alone = run_balance(recordings.write(tmp_path / "log.csv", columns), None, None).verdict

    expected = speed_test[0].verdict["parameters"]["cogging"]
    assert alone["parameters"]["cogging"]["order"] == expected["order"]
    assert alone["parameters"]["cogging"]["amplitude_a_equiv"] == pytest.approx(expected["amplitude_a_equiv"], rel=0.05)


def test_an_angle_that_loses_its_zero_is_reported(tmp_path: Path) -> None:
    """The first half with an angle that is off by 0.03 rad, a third of a period of order 72."""
    columns = recordings.read(recordings.REAL / "speed_test.csv.gz")
    columns["theta_m_rad"][: len(columns["t_s"]) // 2] += 0.03

    verdict = run_balance(recordings.write(tmp_path / "log.csv", columns), None, None).verdict

    assert verdict["verdict"] == ["unknown"]
    assert any("at another phase" in text for text in verdict["unexplained"])


def test_lines_of_a_model_at_another_zero_of_the_angle_do_no_harm(
    free_run: Real, speed_test: Real, tmp_path: Path
) -> None:
    """The encoder counts from where it was switched on: phases of one recording are not those of another."""
    verdict = run_balance(recordings.REAL / "acc_current.csv.gz", speed_test[1] / "model.toml", None).verdict

    assert verdict["gap_before"] < 1.05 * free_run[0].verdict["gap_after"]


@pytest.mark.search
def test_the_model_with_the_orders_explains_the_log_that_gave_them(speed_test: Real, tmp_path: Path) -> None:
    verdict = run_balance(recordings.REAL / "speed_test.csv.gz", speed_test[1] / "model.toml", None).verdict

    assert "cogging" not in verdict["verdict"]
    assert verdict["gap_before"] < 0.3 * speed_test[0].verdict["gap_before"]  # six orders of nine are in the model


def test_the_start_against_a_stop_is_reported_and_not_fitted(speed_test: Real) -> None:
    assert any("to 0.30 s" in text for text in speed_test[0].verdict["unexplained"])


def test_orders_suggest_slots_and_pole_pairs_with_alternatives(speed_test: Real) -> None:
    windings = speed_test[0].verdict["windings"]

    assert (windings[0]["slots"], windings[0]["pole_pairs"]) == (18, 12)
    assert len(windings) > 1


def test_friction_of_one_log_predicts_the_drag_of_another_within_what_both_intervals_say(
    free_run: Real, speed_test: Real, rolling: Real
) -> None:
    """6 and 51 rad/s in one direction, predicted from swings of 157 rad/s. The intervals have to hold between logs."""
    identified = free_run[0].verdict["identified"]
    predicted = identified["coulomb_friction.torque_a_equiv"]["half"]
    for (result, _), speed_rad_s in ((speed_test, 6.28), (rolling, 50.7)):
        half = predicted + speed_rad_s * identified["viscous_friction.viscous_as_per_rad"]["half"]
        beyond = result.verdict["identified"]["drag_beyond_model.torque_a_equiv"]
        assert abs(beyond["value"]) < half + beyond["half"] < 0.01


def test_the_rolling_log_has_the_orders_of_the_same_machine(rolling: Real) -> None:
    verdict = rolling[0].verdict
    orders = [each["order"] for each in verdict["orders"] if each["in_both_halves"]]

    assert "cogging" in verdict["verdict"]
    assert set(orders[:4]) == {12, 18, 36, 24}
    assert any("speed estimate" in text for text in verdict["warnings"])


def test_at_one_speed_without_a_model_no_amplitude_is_claimed(tmp_path: Path) -> None:
    verdict = run_balance(recordings.REAL / "rolling_1.csv.gz", None, tmp_path).verdict

    assert "amplitude_a_equiv" not in verdict["parameters"]["cogging"]
    assert any("give --model" in text for text in verdict["warnings"])


def test_everything_that_was_promised_is_written(speed_test: Real) -> None:
    folder = speed_test[1]
    figures = {path.stem for path in (folder / "figures").glob("*.svg")}

    assert json.loads((folder / "verdict.json").read_text())["verdict"] == ["cogging"]
    assert (folder / "balance.csv").stat().st_size > 0
    assert load_machine(folder / "model.toml").effects["torque_ripple"]["order_1"] == 72
    assert {"orders", "balance_angle", "parts", "ripple", "ripple_orders"} <= figures
    assert "Verdict: cogging" in (folder / "report.html").read_text()
