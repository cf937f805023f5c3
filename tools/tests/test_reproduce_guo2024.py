"""The published result, through the firmware: acceptance as in docs/reference/guo2024.md."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from evenspin.reproduce.guo2024 import METHODS
from evenspin.reproduce.guo2024.checks import Check, check_rows
from evenspin.reproduce.guo2024.design_figures import settled_s, settling_setup
from evenspin.reproduce.guo2024.figures import GALLERY
from evenspin.reproduce.guo2024.tables import tables_of
from evenspin.sim import simulate

KEYS = (
    "method speed_rpm n1_pct n2_pct q1_pct q2_pct distortion_pct overshoot_start_rpm overshoot_load_rpm "
    "overshoot_step_rpm load_dip_rpm"
).split()
SPEEDS = (150, 203, 255, 295, 300, 367, 430, 488, 900, 1200)


@pytest.fixture(scope="module")
def rows(float_result):
    return {(row["method"], row["speed_rpm"]): row for row in float_result.as_json()["rows"]}


def test_there_is_a_row_for_every_method_and_speed(rows):
    assert set(rows) == {(method, speed) for method in METHODS for speed in SPEEDS}
    for (_, speed), row in rows.items():
        assert set(KEYS) <= set(row)
        assert (row["overshoot_step_rpm"] is None) == (speed in (150, 300, 900))
        assert row["speed_mean_rpm"] == pytest.approx(speed, rel=3e-3)


def test_the_start_of_a_set_is_in_each_of_its_rows(rows):
    for method in METHODS:
        assert len({rows[method, speed]["overshoot_start_rpm"] for speed in (150, 203, 255, 295)}) == 1


@pytest.mark.parametrize(("method", "speed", "key", "low", "high"), [
    ("pi", 255, "n1_pct", 4.2, 4.9),
    ("pi", 255, "n2_pct", 2.9, 5.2),
    ("pi", 150, "n1_pct", 10.0, 12.0),
    ("crc", 255, "n1_pct", 0.5, 0.95),
    ("forc", 255, "n1_pct", 0.02, 0.06),
    ("forc", 255, "n2_pct", 0.1, 0.45),
    ("fal-forc", 255, "n1_pct", 0.015, 0.045),
    ("fal-forc", 255, "n2_pct", 0.08, 0.32),
    ("crc", 150, "n1_pct", 0.005, 0.07),
    ("crc", 150, "n2_pct", 0.005, 0.07),
    ("forc", 150, "n1_pct", 0.005, 0.07),
    ("forc", 150, "n2_pct", 0.005, 0.07),
    ("fal-forc", 150, "n1_pct", 0.005, 0.07),
    ("fal-forc", 150, "n2_pct", 0.005, 0.07),
    ("pi", 255, "distortion_pct", 13.0, 14.5),
    ("fal-forc", 255, "distortion_pct", 9.0, 11.0),
])  # fmt: skip
def test_residues_are_in_their_bands(rows, method, speed, key, low, high):
    assert low <= rows[method, speed][key] <= high


def test_fal_halves_the_overshoot_of_the_start_and_lowers_that_of_the_load(rows):
    forc, fal = rows["forc", 150], rows["fal-forc", 150]

    assert 0.2 <= fal["overshoot_start_rpm"] / forc["overshoot_start_rpm"] <= 0.5
    assert 0.5 <= fal["overshoot_load_rpm"] / forc["overshoot_load_rpm"] <= 0.8
    assert fal["load_dip_rpm"] == pytest.approx(forc["load_dip_rpm"], rel=0.05)


def test_gains_and_limits_are_those_of_the_paper(float_result):
    gains, limits = float_result.gains_db, float_result.limits

    assert list(gains["crc"]["k_rc_0.525"].values()) == pytest.approx([36.7, 12.5], abs=0.1)
    assert list(gains["crc"]["k_rc_0.6"].values()) == pytest.approx([37.9, 13.8], abs=0.1)
    assert limits["lambda_max"] == pytest.approx(1.4427, abs=1e-4)
    settles = {(trial["method"], trial["k_rc"]): trial["settles"] for trial in limits["stability"]}
    assert settles == {("forc", 1.35): True, ("forc", 1.8): False, ("fal-forc", 0.968): True, ("fal-forc", 1.36): False}
    cycle = next(trial for trial in limits["stability"] if trial["k_rc"] == 1.36)
    assert 3.0 <= cycle["peak_to_peak_rpm"] <= 30.0


def test_every_comparison_with_the_independent_simulation_holds(float_result):
    missed = [check.what for check in float_result.checks if not check.passed]

    assert missed == []
    assert float_result.passed
    assert len(float_result.checks) > 100


def test_fixed_point_leaves_the_same_ripple(fixed_result, rows):
    assert fixed_result.passed
    for row in fixed_result.rows:
        expected = rows[row["method"], row["speed_rpm"]]
        for key in ("n1_pct", "n2_pct"):
            assert row[key] == pytest.approx(expected[key], abs=0.05)  # percentage points
    assert fixed_result.rows[0]["n1_pct"] != rows["pi", 150]["n1_pct"]


def test_the_result_is_json_that_anybody_reads(float_result):
    text = json.dumps(float_result.as_json(), allow_nan=False)

    assert set(json.loads(text)) >= {"rows", "gains_db", "limits"}


@pytest.mark.parametrize(("method", "speed", "key", "value"), [
    ("pi", 255.0, "n1_pct", 4.1),
    ("forc", 255.0, "n1_pct", 0.061),
    ("forc", 255.0, "n1_pct", 0.001),
    ("fal-forc", 150.0, "overshoot_start_rpm", 30.0),
    ("fal-forc", 150.0, "load_dip_rpm", 90.0),
    ("crc", 150.0, "n2_pct", math.nan),
    ("fal-forc-beyond", 255.0, "n2_after_load_pct", 0.12),
    ("fal-forc-beyond", 295.0, "overshoot_step_rpm", 2.1),
    ("fal-forc-beyond", 150.0, "load_dip_rpm", 31.0),
    ("fal-forc-beyond", 900.0, "q2_after_load_pct", 3.0),
])  # fmt: skip
def test_a_missed_band_fails_the_result(float_result, method, speed, key, value):
    wanted = (method, speed)
    rows = [{**row, key: value} if (row["method"], row["speed_rpm"]) == wanted else row for row in float_result.rows]

    result = replace(float_result, checks=check_rows(rows))

    assert not result.passed
    assert any("FAILED" in cell for view in tables_of(result) for row in view.rows for cell in row)


def test_a_comparison_that_is_not_required_does_not_fail_the_result(float_result):
    checks = [*float_result.checks, Check("something", "", 2.0, 0.0, 1.0, required=False)]

    assert replace(float_result, checks=checks).passed


def test_the_tables_name_every_number_of_the_paper(float_result):
    compared = tables_of(float_result)[1]

    cells = {(row[0], row[1], row[2]): row[3:6] for row in compared.rows}
    assert cells["255", "pi", "speed, 1st order [%]"][1:] == ("4.89", "4.34")
    assert cells["255", "fal-forc", "speed, 2nd order [%]"][1:] == ("0.0900", "0.310")
    assert cells["300", "fal-forc", "overshoot at the start [rpm]"][2] == "65.0"


def test_the_gain_of_figure_4_goes_through_the_printed_points():
    data = GALLERY.find("4")[0].draw([]).data
    for f_hz, printed_db in ((20.83, 36.7), (20.47, 12.5)):
        near = np.interp(f_hz, data["f_hz"], data["crc_48.86_db"])
        assert near == pytest.approx(printed_db, abs=0.8)  # a peak between points 0.05 Hz apart


@pytest.mark.parametrize(
    ("drive", "seconds"),
    [
        # an independent script on the same firmware: the band of 3 rpm peak to peak, in steps of 0.05 s
        ({"rc_lead": 2.0}, 1.65),
        ({"rc_lead": 5.0}, 0.70),
        ({"rc_lead": 6.0}, 0.65),
        ({"rc_lead": 8.0}, 0.90),
        ({"rc_gain": 0.2}, 1.60),
        ({"rc_gain": 1.0}, 0.55),
    ],
)
def test_settling_of_figures_21_and_22(drive, seconds):
    record = simulate(settling_setup(**drive), ("t_s", "true_speed_rad_s"))
    found = settled_s(record["t_s"], record["true_speed_rad_s"] * 30.0 / math.pi)

    assert found == pytest.approx(seconds, abs=0.15)


def test_without_a_lead_figure_21_does_not_settle():
    record = simulate(settling_setup(rc_lead=0.0), ("t_s", "true_speed_rad_s"))

    assert settled_s(record["t_s"], record["true_speed_rad_s"] * 30.0 / math.pi) == math.inf
