"""`evenspin design ripple`: against an independent calculation, against the simulated drive, and its worst speed."""

from __future__ import annotations

import pytest
from evenspin.design.ripple import SPEEDS_RPM, gain, prepare
from evenspin.design.source import loop_of
from evenspin.errors import InputError
from evenspin.model import builtin_scenario

# An independent calculation for the drive of Guo et al. 2024, % of the mean speed; three digits were given.
INDEPENDENT_FIRST_PCT = (10.64, 6.69, 4.52, 3.47)


def test_first_order_is_that_of_an_independent_calculation() -> None:
    found = prepare("guo2024", 1.0, SPEEDS_RPM, {})

    for each, expected in zip(found.at, INDEPENDENT_FIRST_PCT, strict=True):
        assert 100.0 * each.first_rpm / each.speed_rpm == pytest.approx(expected, abs=0.006)  # given digits


def test_first_and_second_order_are_those_of_the_simulated_drive(float_result) -> None:
    rows = {row["speed_rpm"]: row for row in float_result.rows if row["method"] == "pi"}
    # equation 1 knows no delay and no gain of the other sensor: 0.5 to 1.5 % above the simulation
    for speed in (203.0, 255.0, 295.0):  # at 150 rpm the first order is so large that it moves the second
        found = prepare("guo2024", rows[speed]["iq_mean_a"], [speed], {}).at[0]
        assert 100.0 * found.first_rpm / speed == pytest.approx(rows[speed]["n1_pct"], rel=0.02)
        # over the angle the first order, 3 to 7 %, adds to the second
        assert 100.0 * found.second_rpm / speed == pytest.approx(rows[speed]["n2_pct"], rel=0.12)


def test_worst_speed_is_where_neighbours_have_less() -> None:
    found = prepare("guo2024", 1.0, SPEEDS_RPM, {})
    worst = found.worst.speed_rpm
    near = prepare("guo2024", 1.0, [0.9 * worst, 1.1 * worst, 0.45 * worst, 0.55 * worst], {}).at

    assert found.worst.first_rpm > max(each.first_rpm for each in near)
    assert found.worst_half.second_rpm > max(each.second_rpm for each in near)
    # simulated at 107 rpm: 17.9 rpm; the printed equation 6 has 8.1
    assert found.worst.speed_rpm == pytest.approx(107.0, rel=0.01)
    assert found.worst.first_rpm == pytest.approx(17.9, rel=0.06)
    assert found.printed_worst_first_rpm == pytest.approx(8.1, rel=0.02)


def test_a_faster_speed_controller_leaves_less() -> None:
    setup = builtin_scenario("guo2024/first").setup
    stiff = {**setup.drive, "speed_kp_a_per_unit": 2.0 * setup.drive["speed_kp_a_per_unit"]}

    assert gain(loop_of(setup.plant, stiff), 100.0) < gain(loop_of(setup.plant, setup.drive), 100.0)


@pytest.mark.parametrize(
    ("given", "speeds"), [({"offset_a_a": 0.0, "offset_b_a": 0.0, "gain_a": 1.0, "gain_b": 1.0}, [150.0]), ({}, [0.0])]
)
def test_nothing_to_calculate_is_refused(given, speeds) -> None:
    with pytest.raises(InputError):
        prepare("guo2024", 1.0, speeds, given)
