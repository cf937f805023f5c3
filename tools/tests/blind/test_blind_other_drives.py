"""The referee's controllers of other makes, against what text books say of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from evenspin.blind.referee import Inputs, simulate

PWM_HZ = 16000.0
PAIRS, PSI_WB, R_OHM, LD_H, LQ_H = 4.0, 0.02, 0.5, 1e-3, 2e-3
DRIVE = {
    "motor.pole_pairs": PAIRS,
    "motor.resistance_ohm": R_OHM,
    "motor.ld_h": LD_H,
    "motor.lq_h": LQ_H,
    "motor.psi_wb": PSI_WB,
    "motor.inertia_kgm2": 1e-4,
    "motor.rated_current_a": 10.0,
    "bridge.dc_link_v": 100.0,
    "bridge.pwm_hz": PWM_HZ,
    "sensor.counts_per_rev": 131072.0,
    "drive.current_kp_v_per_a": 3.0,
    "drive.current_ki_v_per_as": 1500.0,
    "drive.speed_periods": 16.0,
    "drive.speed_kp_a_per_rad_s": 0.05,
    "drive.speed_ki_a_per_rad": 0.3,
    "drive.iq_limit_a": 15.0,
    "other.in_use": 1.0,
    "other.psi_wb": PSI_WB,
    "other.ld_h": LD_H,
    "other.lq_h": LQ_H,
    "other.feed_forward": 1.0,
    "run.step_s": 31.25e-6,
}


def run(seconds: float, speed: float = 0.0, load_nm: float = 0.0, decimate: int = 16, **more: float):
    count = round(seconds * PWM_HZ)
    none = np.zeros(count)
    speeds = np.minimum(np.arange(count) / PWM_HZ / 0.2, 1.0) * speed
    own = {name.replace("__", "."): value for name, value in more.items()}
    return simulate(DRIVE | own, Inputs(speeds, none, none, np.full(count, load_nm), none), decimate)


def mean(log: dict[str, np.ndarray], name: str) -> float:
    return float(np.mean(log[name][len(log[name]) // 2 :]))


@pytest.mark.parametrize("by_difference", [0.0, 1.0])
@pytest.mark.parametrize("ip", [0.0, 1.0])
def test_every_speed_loop_holds_its_speed_under_load(by_difference: float, ip: float) -> None:
    log = run(
        2.0, 40.0, 0.3, other__speed_by_difference=by_difference, other__speed_filter_s=1e-3, other__speed_loop_ip=ip
    )

    assert mean(log, "true_speed_rad_s") == pytest.approx(40.0, rel=1e-3)
    assert mean(log, "true_torque_nm") == pytest.approx(0.3, rel=1e-3)


def test_only_a_proportional_part_on_the_error_makes_the_speed_overshoot() -> None:
    peak = [np.max(run(1.5, 40.0, other__speed_loop_ip=ip)["true_speed_rad_s"]) for ip in (0.0, 1.0)]

    assert peak[0] > 40.3 > peak[1]


def test_most_torque_per_ampere_is_the_smallest_current_for_a_torque() -> None:
    """Found by a search over the torque equation 1.5 p (psi iq + (Ld - Lq) id iq)."""
    torque_nm = 0.6
    ids = np.linspace(-10.0, 0.0, 20001)
    sizes = np.hypot(ids, torque_nm / (1.5 * PAIRS * (PSI_WB + (LD_H - LQ_H) * ids)))

    log = run(2.0, 20.0, torque_nm, other__most_torque_per_ampere=1.0)

    assert mean(log, "id_a") == pytest.approx(ids[np.argmin(sizes)], abs=0.02)
    assert math.hypot(mean(log, "id_a"), mean(log, "iq_a")) == pytest.approx(np.min(sizes), rel=2e-3)
    assert mean(run(2.0, 20.0, torque_nm), "id_a") == pytest.approx(0.0, abs=0.02)


def test_a_late_angle_turns_the_voltage_of_the_magnets_out_of_the_q_axis() -> None:
    """No load: only w psi is at the terminals; the drive's axes lag by w_e times the delay."""
    delay_s, speed = 200e-6, 100.0

    log = run(1.5, speed, other__angle_delay_s=delay_s, other__angle_from_pll=1.0, drive__angle_advance_periods=1.5)

    late_rad = PAIRS * speed * delay_s
    assert math.atan2(-mean(log, "vd_v"), mean(log, "vq_v")) == pytest.approx(late_rad, abs=2e-3)
    straight = run(1.5, speed, drive__angle_advance_periods=1.5)
    assert math.atan2(-mean(straight, "vd_v"), mean(straight, "vq_v")) == pytest.approx(0.0, abs=2e-3)


def test_the_logged_angle_is_the_one_that_the_drive_works_with() -> None:
    log = run(1.5, 100.0, other__angle_delay_s=200e-6, other__angle_from_pll=1.0)
    late_rad = np.angle(np.exp(1j * (log["true_theta_m_rad"] - log["drive_theta_m_rad"])))

    assert np.mean(late_rad[len(late_rad) // 2 :]) == pytest.approx(100.0 * 200e-6, rel=0.02)


def test_a_voltage_without_computation_time_acts_one_period_sooner() -> None:
    def first_current(periods: float) -> int:
        count = 20
        iq = np.full(count, 5.0)
        none = np.zeros(count)
        log = simulate(DRIVE | {"other.computation_periods": periods}, Inputs(none, none, iq, none, np.ones(count)), 1)
        return int(np.argmax(np.abs(log["iq_a"]) > 0.1))

    assert first_current(0.0) == 1
    assert first_current(1.0) == 2


def test_feed_forward_keeps_id_away_from_a_speed_ramp() -> None:
    def largest_id(share: float) -> float:
        return float(np.max(np.abs(run(0.4, 150.0, other__feed_forward=share, decimate=1)["id_a"][200:])))

    assert largest_id(1.0) < 0.3 * largest_id(0.0)


def test_rows_may_be_means_of_what_happened_since_the_last_row() -> None:
    fine = run(0.5, 40.0, decimate=1)
    means = run(0.5, 40.0, decimate=16, run__mean=1.0)

    for name in ("iq_a", "vq_v", "speed_rad_s"):
        expected = fine[name][1:].reshape(-1)[: 16 * ((len(fine[name]) - 1) // 16)].reshape(-1, 16).mean(axis=1)
        assert means[name][1:] == pytest.approx(expected[: len(means[name]) - 1], abs=1e-12)
    assert np.array_equal(means["drive_theta_m_rad"], fine["drive_theta_m_rad"][::16])
