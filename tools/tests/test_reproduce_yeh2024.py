"""The position drive of Yeh and Liu, through the firmware: acceptance as in docs/reference/yeh2024.md."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from evenspin.reproduce.yeh2024 import METHODS, reproduce
from evenspin.reproduce.yeh2024.checks import check_rows
from evenspin.reproduce.yeh2024.measure import row_of, turn_rows
from evenspin.reproduce.yeh2024.tables import tables_of
from evenspin.sim import Record

SPEEDS = (10.0, 15.0, 20.0)


@pytest.fixture(scope="module")
def result():
    return reproduce("float")


@pytest.fixture(scope="module")
def rows(result):
    return {(row["method"], row["speed_rpm"]): row for row in result.as_json()["rows"]}


@pytest.fixture(scope="module")
def wrong(result):
    return {row["method"]: row for row in result.as_json()["rows_all_wrong"]}


def test_there_is_a_row_for_every_method_and_speed(rows, wrong):
    assert set(rows) == {(method, speed) for method in METHODS for speed in SPEEDS}
    assert set(wrong) == {"rdc", "rdc-beyond"}


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("method", ["ppi", "silc", "src"])
def test_without_feed_forward_the_position_lags_by_speed_over_gain(rows, method, speed):
    assert rows[method, speed]["avg_turn10"] == pytest.approx(speed * math.pi / 30.0 / 10.0, rel=0.02)


@pytest.mark.parametrize("speed", SPEEDS)
def test_robust_driving_control_does_not_lag(rows, speed):
    assert abs(rows["rdc", speed]["avg_turn10"]) < 1e-5
    assert 0.02e-3 <= rows["rdc", speed]["turn10_rms"] <= 0.05e-3
    assert 0.03e-3 <= rows["rdc", speed]["max_turn10"] <= 0.1e-3
    assert 2e-3 <= rows["rdc", speed]["raw_max_turns_1_3"] <= 1.6e-2


@pytest.mark.parametrize(("speed", "low", "high"), [(10, 38, 46), (15, 65, 72), (20, 75, 82)])
def test_iterative_learning_falls_as_in_the_paper(rows, speed, low, high):
    assert low <= rows["silc", speed]["turn2_reduction_pct"] <= high
    assert 88 <= rows["silc", speed]["turn10_reduction_pct"] <= 95


@pytest.mark.parametrize("speed", SPEEDS)
def test_repetitive_control_has_learned_after_one_turn(rows, speed):
    assert 88 <= rows["src", speed]["turn2_reduction_pct"] <= 99.5
    assert 90 <= rows["src", speed]["turn10_reduction_pct"] <= 99.5


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("method", ["silc", "src"])
def test_the_raw_error_falls_by_an_order_and_more(rows, method, speed):
    rdc, other = rows["rdc", speed], rows[method, speed]

    assert 0.0 < rdc["raw_max_turns_1_3"] / other["raw_max_turns_1_3"] < 0.1
    assert 0.0 < rdc["raw_max_turn10"] / other["raw_max_turn10"] < 0.01


@pytest.mark.parametrize("speed", SPEEDS)
def test_limited_acceleration_takes_the_start_away(rows, speed):
    assert 0.05e-3 <= rows["rdc-beyond", speed]["raw_max_turns_1_3"] <= 1e-3


def test_wrong_models_are_learned_away(wrong):
    assert 0.1e-3 <= wrong["rdc"]["turn10_rms"] <= 0.4e-3
    assert 0.02e-3 <= wrong["rdc-beyond"]["turn10_rms"] <= 0.15e-3


def test_every_required_check_is_made_and_holds(result):
    required = [check for check in result.checks if check.required]

    assert [check.what for check in required if not check.passed] == []
    assert len(required) >= 50
    assert result.passed


@pytest.mark.parametrize(("method", "key", "value"), [
    ("rdc", "turn10_rms", 0.06e-3),
    ("rdc", "turn10_rms", 0.001e-3),
    ("silc", "turn2_reduction_pct", 84.0),
    ("src", "avg_turn10", 0.2),
    ("rdc-beyond", "raw_max_turns_1_3", 1.1e-3),
    ("ppi", "avg_turn10", math.nan),
])  # fmt: skip
def test_a_missed_band_fails_the_result(result, method, key, value):
    rows = [{**row, key: value} if (row["method"], row["speed_rpm"]) == (method, 20.0) else row for row in result.rows]

    changed = replace(result, checks=check_rows(rows))

    assert not changed.passed
    assert any("FAILED" in cell for view in tables_of(changed) for row in view.rows for cell in row)


def test_the_result_is_json_that_anybody_reads(result):
    content = json.loads(json.dumps(result.as_json(), allow_nan=False))

    assert set(content) >= {"rows", "identified"}
    assert set(content["rows"][0]) >= set(
        "method speed_rpm turn1_rms turn2_reduction_pct turn10_reduction_pct avg_turn10 max_turn10 "
        "raw_max_turns_1_3 turn10_rms".split()
    )


def made_up(lag, ripple):
    """A ramp of 1 turn/s over ten turns whose error is known."""
    t_s = np.arange(1, 10_500) * 1e-3
    command = np.minimum(2 * np.pi * t_s, 20 * np.pi)
    turn = np.ceil(command / (2 * np.pi))
    error = lag + ripple / turn * np.sin(8 * command)
    values = np.column_stack((t_s, command, error, np.zeros_like(t_s)))
    return Record(("t_s", "position_ref_rad", "position_error_rad", "fault"), ("s", "rad", "rad", ""), values)


def test_a_row_is_what_its_names_say():
    row = row_of(made_up(0.1, 0.02), "silc", 60.0, "float", "true")

    assert row["turn1_rms"] == pytest.approx(0.02 / math.sqrt(2.0), rel=0.01)
    assert row["turn2_reduction_pct"] == pytest.approx(50.0, abs=0.5)
    assert row["turn10_reduction_pct"] == pytest.approx(90.0, abs=0.2)
    assert row["avg_turn10"] == pytest.approx(0.1, abs=1e-5)
    assert row["max_turn10"] == pytest.approx(0.002, rel=0.01)
    assert row["raw_max_turns_1_3"] == pytest.approx(0.12, rel=0.01)
    assert "models" not in row


def test_the_time_at_the_target_is_no_turn():
    record = made_up(0.1, 0.02)

    assert 0.999 <= len(turn_rows(record, 10)) / 1000.0 <= 1.0


def test_the_command_writes_report_and_json(evenspin, tmp_path):
    out, file = tmp_path / "out", tmp_path / "y.json"

    said = evenspin("reproduce", "yeh2024", "--method", "silc", "--json", file, "--out", out)

    assert said.status == 0, said.err
    assert len(json.loads(file.read_text())["rows"]) == 3
    assert {path.name for path in (out / "figures").glob("*.svg")} >= {"polar_silc.svg", "rms.svg", "raw.svg"}
    assert "turn 10" in (out / "figures" / "polar_silc.svg").read_text()


@pytest.mark.parametrize("words", [("--method", "crc"), ("--set", "first"), ("--sweep",)])
def test_options_of_other_papers_are_refused(evenspin, words):
    said = evenspin("reproduce", "yeh2024", *words)

    assert (said.status, said.out, said.err.count("\n")) == (2, "", 1)
