"""Overshoot, dip, settling; and the pieces of a run."""

import numpy as np
import pytest
from evenspin.analysis import dip, measure_segment, overshoot, segments, settling_time_s
from evenspin.model import builtin_scenario
from evenspin.sim import Record

RPM = np.pi / 30.0


@pytest.mark.parametrize(
    ("value", "reference", "over", "short"),
    [
        ([0.0, 90.0, 120.0, 100.0], 100.0, 20.0, 100.0),
        ([0.0, -90.0, -120.0, -100.0], -100.0, 20.0, 100.0),
        ([40.0, 60.0], 100.0, 0.0, 60.0),
        ([100.0, 110.0], 100.0, 10.0, 0.0),
    ],
)
def test_overshoot_and_dip_are_away_from_zero_and_towards_it(value, reference, over, short):
    assert overshoot(np.array(value), reference) == pytest.approx(over)
    assert dip(np.array(value), reference) == pytest.approx(short)


def test_settling_ends_with_the_last_sample_outside_of_the_band():
    t_s = np.arange(10) / 10.0
    value = np.array([0, 2, 0.9, 1.3, 1.04, 1.06, 1.0, 1.0, 1.0, 1.0])

    assert settling_time_s(t_s, value, 1.0, 0.05) == pytest.approx(0.6)
    assert np.isnan(settling_time_s(t_s, value + 1.0, 1.0, 0.05))
    assert settling_time_s(t_s, value, 1.0, 5.0) == 0.0


def test_a_run_is_cut_at_its_events():
    pieces = segments(builtin_scenario("guo2024/first").setup)

    assert [piece.start_s for piece in pieces] == [0, 4, 8, 12, 16, 20, 24, 28]
    assert [piece.speed_ref_rad_s / RPM for piece in pieces] == pytest.approx([150, 150, 203, 203, 255, 255, 295, 295])
    assert [piece.changed for piece in pieces[:3]] == [
        ("speed_ref_rad_s", "load_brake_nm"),
        ("load_brake_nm",),
        ("speed_ref_rad_s",),
    ]
    assert pieces[0].steady_s == pytest.approx(4.0 - 1.9)


def test_a_segment_is_measured_in_its_steady_window_only():
    pieces = segments(builtin_scenario("guo2024/first").setup)
    t_s = np.arange(0, 32, 0.0005)
    theta = 150 * RPM * t_s
    ripple = np.where(t_s < 2.1, 0.5, 0.1)  # the first part must not count
    speed = 150 * RPM * (1.0 + ripple * np.cos(4 * theta))
    phases = [3.0 * np.cos(4 * theta - k * 2 * np.pi / 3) for k in range(3)]
    names = ("t_s", "true_speed_rad_s", "true_theta_m_rad", "true_iq_a", "true_ia_a", "true_ib_a", "true_ic_a")
    iq_a = 3.0 + 0.06 * np.sin(8 * theta)
    record = Record(names, ("",) * 7, np.column_stack((t_s, speed, theta, iq_a, *phases)))

    found = measure_segment(record, pieces[0], pole_pairs=4)

    assert found["n1_pct"] == pytest.approx(10.0, rel=1e-6)
    assert found["n2_pct"] == pytest.approx(0.0, abs=1e-6)
    assert found["q2_pct"] == pytest.approx(2.0, rel=1e-6)
    assert found["distortion_pct"] == pytest.approx(0.0, abs=0.05)
    assert found["overshoot_rpm"] == pytest.approx(75.0, rel=1e-3)  # 50 % of 150, in the first part
