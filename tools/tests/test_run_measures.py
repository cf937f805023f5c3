"""What `evenspin run` says of a run: every order, rms, settling, and in position mode each turn."""

import evenspin as es
import numpy as np
import pytest
from evenspin.analysis import strongest_orders
from evenspin.model import builtin_scenario
from evenspin.reproduce.yeh2024.measure import rms_without_mean, turn_error
from evenspin.run.measures import position_pieces
from evenspin.run.tables import run_tables

TURNS = 20.0


def over_turns(lines, turns=TURNS, rows=20_000):
    """A value over an angle that turns evenly: 3 + sum of a cos(k theta)."""
    theta = np.linspace(0.0, 2.0 * np.pi * turns, rows)
    return 3.0 + sum(a * np.cos(k * theta) for k, a in lines), theta


def test_the_largest_lines_are_found_wherever_they_are_and_in_their_order():
    value, theta = over_turns([(84, 0.5), (7, 0.2), (12, 1.0), (1, 0.1)])

    found = strongest_orders(value, theta, 4)

    assert [round(order) for order, _ in found] == [12, 84, 7, 1]
    # at order 84 a straight line between 12 samples of a period takes 2.3 %
    assert [amplitude for _, amplitude in found] == pytest.approx([1.0, 0.5, 0.2, 0.1], rel=0.03)


def test_a_small_line_beside_a_large_one_has_no_name():
    value, theta = over_turns([(12, 1.0), (84, 0.04)])

    assert len(strongest_orders(value, theta)) == 1


def test_the_mean_and_a_slow_change_are_no_order():
    theta = np.linspace(0.0, 2.0 * np.pi * TURNS, 20_000)

    assert all(order >= 1.0 for order, _ in strongest_orders(3.0 + 0.1 * theta + np.cos(12 * theta), theta))


@pytest.mark.parametrize("turns", [0.0, 0.5])
def test_less_than_a_turn_has_no_orders(turns):
    assert strongest_orders(*over_turns([(12, 1.0)], turns)) == []


def test_a_line_that_turns_backwards_is_the_same_line():
    value, theta = over_turns([(12, 1.0)])

    assert strongest_orders(value, -theta)[0] == pytest.approx((12.0, 1.0), rel=0.02)


@pytest.fixture(scope="module")
def rough():
    events = [{"at_s": 0.0, "speed_rpm": 300.0}, {"at_s": 1.5, "speed_rpm": 150.0}, {"at_s": 2.5, "speed_rpm": 0.0}]
    scenario = es.load({"name": "rough", "model": "guo2024", "duration_s": 3.0, "event": events})
    good = {"current_gain": {"gain_a": 1.0, "gain_b": 1.0}, "current_offset": {"offset_a_a": 0.0, "offset_b_a": 0.0}}
    return scenario.change(good).change({"cogging.amplitude_nm": 0.01, "cogging.order": 84}).simulate()


def test_cogging_of_an_order_that_is_no_multiple_of_the_pole_pairs_is_named_with_its_size(rough):
    piece = rough.summary()["segments"][0]
    steady = rough.between(0.75, 1.5)["true_speed_rad_s"] * 30.0 / np.pi

    assert piece["orders"][0]["per_turn"] == pytest.approx(84.0, abs=0.3)
    assert piece["speed_rms_rpm"] == pytest.approx(steady.std(), rel=1e-6)
    assert piece["speed_pp_rpm"] == pytest.approx(np.ptp(steady), rel=1e-6)


def test_settling_is_the_time_until_the_speed_stays_within_two_percent(rough):
    piece = rough.summary()["segments"][1]
    part = rough.between(1.5, 2.5)
    outside = np.abs(part["true_speed_rad_s"] - 150.0 * np.pi / 30.0) > 0.02 * 150.0 * np.pi / 30.0

    assert piece["settled_s"] == pytest.approx(part.t_s[np.flatnonzero(outside)[-1] + 1] - 1.5, abs=1e-9)


def test_the_dip_of_a_start_from_rest_is_not_the_whole_set_point(rough):
    first = rough.summary()["segments"][0]

    assert first["dip_rpm"] < 100.0


def test_at_speed_zero_there_is_no_percentage_and_no_settling_band(rough):
    summary = rough.summary()
    views = run_tables(summary)

    assert summary["segments"][2]["settled_s"] is None
    assert views[0].rows[2][views[0].header.index("n1 %")] == "-"


@pytest.fixture(scope="module")
def motion():
    return es.load("yeh2024/rpm20").simulate()


def test_a_position_run_has_the_errors_of_each_turn_that_the_paper_has(motion):
    """The reproduction of the paper cuts its turns another way, by the command itself."""
    turns = [piece for piece in motion.summary()["motions"] if piece["moves"]]

    assert len(turns) == 10
    for number in (2, 5, 9):
        expected = 1e3 * rms_without_mean(turn_error(motion.record, number))
        assert turns[number - 1]["error_rms_mrad"] == pytest.approx(expected, rel=0.02)


def test_a_position_run_is_reported_as_one(evenspin, tmp_path):
    said = evenspin("run", "yeh2024/rpm20", "--out", tmp_path / "out")

    assert said.status == 0
    assert "rdc, position" in said.out and "error rms mrad" in said.out and "ref. rpm" not in said.out
    names = {path.stem for path in (tmp_path / "out" / "figures").glob("*.svg")}
    assert names >= {"position", "position_error", "error_over_turn", "speed"}


def test_a_rest_says_when_the_error_was_gone(motion):
    rest = motion.summary()["motions"][-1]

    assert not rest["moves"] and rest["settled_s"] > 0.0
    last = motion.between(rest["start_s"] + rest["settled_s"] + 1e-3, motion.setup.duration_s)
    assert np.abs(last["position_error_rad"]).max() <= 1.01e-3


def test_a_long_motion_shows_its_first_and_its_last_turns():
    setup = builtin_scenario("yeh2024/rpm20").setup
    rows = 40_000
    turns = np.linspace(0.0, 40.0, rows)
    columns = {
        "t_s": np.linspace(0.0, 40.0, rows), "velocity_ref_rad_s": np.full(rows, 2.0 * np.pi),
        "position_ref_rad": 2.0 * np.pi * turns, "position_error_rad": np.zeros(rows),
        "true_speed_rad_s": np.full(rows, 2.0 * np.pi), "true_iq_a": np.ones(rows),
    }  # fmt: skip

    from evenspin.sim import Record

    pieces = position_pieces(
        setup, Record(tuple(columns), ("",) * len(columns), np.column_stack(list(columns.values())))
    )

    assert [round(piece["from_turn"]) for piece in pieces] == [0, 1, 2, 3, 4, 5, 34, 35, 36, 37, 38, 39]
