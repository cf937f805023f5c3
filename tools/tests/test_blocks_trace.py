"""The blocks are the steps of the interrupt: replayed on a trace of the firmware they give what the firmware gave."""

import math
from dataclasses import replace

import numpy as np
import pytest
from evenspin import blocks
from evenspin.errors import BlockError
from evenspin.model import load_scenario
from evenspin.sim import simulate

SIGNALS = ("state", "id_ref_a", "iq_ref_a", "id_a", "iq_a", "vd_v", "vq_v", "vdc_v", "speed_rad_s")
RUN = 4.0
F = np.float32


@pytest.fixture
def trace(scenario):
    """Every current interrupt of 0.2 s: a start at the current limit, at first also at the voltage limit."""

    def make(**drive):
        setup = load_scenario(scenario).setup
        changed = {**setup.drive, "voltage_limit_v": 1.8, "speed_source": 0.0, **drive}
        record = simulate(replace(setup, drive=changed, duration_s=0.2, log_rate_hz=1e4), SIGNALS)
        return changed, [dict(zip(SIGNALS, row, strict=True)) for row in record.values if row[0] == RUN]

    return make


def limit_v(drive, row):
    return float(min(F(drive["voltage_limit_v"]), F(row["vdc_v"]) * F(0.57735026919)))


def test_the_current_pi_gives_the_voltages_of_the_firmware_bit_for_bit(trace):
    drive, rows = trace()
    ki_ts = float(F(drive["current_ki_v_per_as"]) * (F(1.0) / F(1e4)))
    d, q = (blocks.Pi(drive["current_kp_v_per_a"], ki_ts, -1e6, 1e6) for _ in range(2))
    limited = 0

    for row in rows:
        error_d, error_q = (float(F(row[f"i{axis}_ref_a"]) - F(row[f"i{axis}_a"])) for axis in "dq")
        wanted = d.propose(error_d), q.propose(error_q)
        voltage = blocks.vector_limit(*wanted, limit_v(drive, row))
        if voltage == wanted:
            d.learn(error_d)
            q.learn(error_q)
        else:
            limited += 1
        assert voltage == (row["vd_v"], row["vq_v"])

    assert 10 < limited < len(rows) / 2  # both ways of the step were there


def test_the_deadbeat_controller_gives_the_voltages_of_the_firmware(trace):
    drive, rows = trace(current_controller=1.0)
    names = ("motor_resistance_ohm", "motor_ld_h", "motor_lq_h", "motor_psi_wb")
    deadbeat = blocks.Deadbeat(*(drive[name] for name in names), int(drive["pole_pairs"]), 1e-4)
    last = (0.0, 0.0)
    found, given = [], []

    for row in rows:
        current, reference = (row["id_a"], row["iq_a"]), (row["id_ref_a"], row["iq_ref_a"])
        voltage = deadbeat.step(current, reference, row["speed_rad_s"], last)
        last = blocks.vector_limit(*voltage, limit_v(drive, row))
        found.append(last)
        given.append((row["vd_v"], row["vq_v"]))
        last = given[-1]

    # gains over the sampling time are rounded in single precision here, products of rounded ones there
    assert np.abs(np.array(found) - given).max() < 2e-5
    assert np.abs(given).max() > 1.5


# ---- guards in front of the steps ------------------------------------------------------------------------------------


@pytest.mark.parametrize("numeric", ["float", "fixed"])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_does_not_reach_a_step_without_a_check(numeric, bad):
    pi = blocks.Pi(1.0, 0.5, -2.0, 2.0, numeric=numeric)
    pi.learn(1.0)
    before = pi.propose(0.0)

    assert pi.propose(bad) == before == pytest.approx(0.5)
    pi.learn(bad)
    assert pi.propose(0.0) == before
    assert pi.rejected == 1

    deadbeat = blocks.Deadbeat(0.5, 1e-3, 1e-3, 0.05, 4, numeric=numeric)
    deadbeat.step((0.0, 0.0), (0.0, 1.0), 10.0, (0.0, 0.0))
    voltages = [
        deadbeat.step((bad, 0.0), (0.0, bad), bad, (bad, 0.0)),
        deadbeat.step((0.0, 0.0), (0.0, 1.0), 10.0, (0.0, 0.0)),
    ]
    assert np.isfinite(voltages).all()

    for found in (
        blocks.clarke(bad, 0.0, 0.0, numeric=numeric),
        blocks.park(bad, 0.0, 0.3, numeric=numeric),
        blocks.inverse_park(0.0, bad, 0.3, numeric=numeric),
        blocks.vector_limit(bad, 1.0, 2.0, numeric=numeric),
        blocks.svm(bad, 0.0, 24.0, numeric=numeric),
        blocks.svm(1.0, 0.0, bad, numeric=numeric),
    ):
        assert np.isfinite(found).all() and np.abs(found).max() <= 2.0


@pytest.mark.parametrize("numeric", ["float", "fixed"])
def test_duties_stay_within_0_and_1_where_the_timer_would_clip(numeric):
    assert blocks.svm(100.0, 0.0, 24.0, numeric=numeric) == pytest.approx((1.0, 0.0, 0.0))


# ---- the observer over time ------------------------------------------------------------------------------------------


def shaft(samples, speed=60.0):
    """Angle of a shaft of 9e-4 kg m^2 on which a torque of 0.05 N m acts five times a turn."""
    theta, w, angles = 0.2, speed, []
    for _ in range(samples):
        angles.append(theta)
        for _ in range(4):
            w += 2.5e-5 * 0.05 * math.sin(5.0 * theta) / 9e-4
            theta += 2.5e-5 * w
    return angles


def test_ro_takes_its_period_from_the_target_speed_that_it_is_given():
    angles = shaft(12_000)
    error = {}
    for target in (60.0, 45.0):
        observer = blocks.TorqueObserver("ro", 9e-4, 0.0, gain=0.3)
        estimate = np.array([observer.step(angle, 0.0, target) for angle in angles])
        expected = 0.05 * np.sin(5.0 * np.array(angles[-1198:]))
        error[target] = np.std(estimate[-1200:-2] - expected)

    assert error[60.0] < 0.2 * 0.05 / math.sqrt(2.0)
    assert error[45.0] > 3.0 * error[60.0]


def test_ro_without_a_target_speed_is_refused():
    with pytest.raises(BlockError, match=r"target_speed_rad_s = 'none': must be given for ro"):
        blocks.TorqueObserver("ro", 9e-4).step(0.1)


def test_dob_and_aro_need_no_target_speed():
    for kind in ("dob", "aro"):
        assert math.isfinite(blocks.TorqueObserver(kind, 9e-4).step(0.1))
