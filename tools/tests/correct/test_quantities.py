"""What an effect spoils, measured on signals whose answer is known by construction."""

from __future__ import annotations

import math

import numpy as np
import pytest
from evenspin.correct.quantities import RPM, Drive, Quantity, steady_stretches
from evenspin.log.columns import LOG_COLUMNS, LOG_UNITS
from evenspin.sim.record import Record

RATE_HZ = 2000.0
DRIVE = Drive(pole_pairs=4.0, resistance_ohm=0.5, ld_h=1e-3, lq_h=1e-3, iq_limit_a=10.0, designed={})


def _record(speeds_rad_s, each_s=2.0, **columns):
    rows = int(each_s * RATE_HZ)
    wanted = np.repeat(np.asarray(speeds_rad_s, dtype=float), rows)
    t_s = np.arange(len(wanted)) / RATE_HZ
    theta = np.cumsum(wanted) / RATE_HZ
    values = dict.fromkeys(LOG_COLUMNS, 0.0) | {"load_torque_nm": math.nan}
    values |= {"t_s": t_s, "speed_ref_rad_s": wanted, "speed_rad_s": wanted, "theta_m_rad": theta}
    values |= {name: f(t_s, theta, wanted) for name, f in columns.items()}
    table = [np.broadcast_to(values[name], t_s.shape) for name in LOG_COLUMNS]
    return Record(LOG_COLUMNS, LOG_UNITS, np.column_stack(table))


def test_a_ripple_is_the_rms_over_speeds_of_the_amplitude_at_its_orders_and_of_no_other():
    def speed(t_s, theta, wanted):
        small = 0.3 * np.cos(3 * theta + 1.0) + 0.4 * np.sin(5 * theta) + 7.0 * np.sin(2 * theta)
        return wanted + small * np.where(np.abs(wanted) > 30.0, 0.5, 1.0)  # half as large at the second speed

    record = _record([20.0, 40.0], speed_rad_s=speed)
    measured = Quantity("speed_ripple", ("x",), (3.0, 5.0)).measured({"x": record}, DRIVE)

    # 0.5 rad/s both lines together, and half of that: rms of the two. The second order, fourteen times as large, stays
    # out of it as far as 2 turns and more keep whole orders apart: 5 %
    assert measured * RPM == pytest.approx(math.sqrt((0.5**2 + 0.25**2) / 2.0), rel=0.05)


def test_a_ripple_that_the_rate_of_the_log_cannot_show_is_not_measured():
    assert math.isnan(Quantity("speed_ripple", ("x",), (300.0,)).measured({"x": _record([40.0])}, DRIVE))
    assert math.isnan(Quantity("speed_ripple", ("x",), (3.0,)).measured({"y": _record([40.0])}, DRIVE))


def test_a_swing_is_the_rms_over_steps_of_the_largest_sine_near_its_frequency_off_the_designed_speed():
    def swinging(t_s, theta, wanted):
        after = t_s - 2.0 * np.floor(t_s / 2.0)  # a step every 2 s
        size = np.where(wanted > 30.0, 0.3, 0.4)  # 5 % off the frequency that is asked for
        return wanted + size * np.sin(2.0 * np.pi * 57.0 * after) * (after < 0.5) + 5.0 * np.exp(-after / 0.2)

    def designed(t_s, theta, wanted):
        return wanted + 5.0 * np.exp(-(t_s - 2.0 * np.floor(t_s / 2.0)) / 0.2)

    record, design = (_record([20.0, 40.0], speed_rad_s=speed) for speed in (swinging, designed))
    drive = Drive(4.0, 0.5, 1e-3, 1e-3, 10.0, {"x": design})
    measured = Quantity("swing", ("x",), hz=(60.0,)).measured({"x": record}, drive)

    assert measured * RPM == pytest.approx(math.sqrt((0.4**2 + 0.3**2) / 2.0), rel=0.01)
    assert Quantity("swing", ("x",), hz=(100.0,)).measured({"x": record}, drive) < 0.05 * measured
    # what the rate of the log, or the time after a step, does not show
    assert math.isnan(Quantity("swing", ("x",), hz=(900.0,)).measured({"x": record}, drive))
    assert math.isnan(Quantity("swing", ("x",), hz=(5.0,)).measured({"x": record}, drive))
    limited = _record(
        [20.0, 40.0], speed_rad_s=swinging, iq_ref_a=lambda t_s, theta, wanted: np.where(t_s < 2.0, 9.9, 0.0)
    )
    assert Quantity("swing", ("x",), hz=(60.0,)).measured({"x": limited}, drive) * RPM == pytest.approx(0.3, rel=0.01)


def test_the_angle_of_the_back_emf_is_found_with_any_current_and_a_voltage_that_comes_late_does_not_count():
    off, late_s = 0.07, 50e-6
    i_d, i_q, psi = 0.4, 1.5, 0.02

    def volts(axis):
        def of(t_s, theta, wanted):
            w = 4.0 * wanted
            turned = off + w * late_s
            d = 0.5 * i_d - w * 1e-3 * i_q + w * psi * np.sin(turned)
            q = 0.5 * i_q + w * 1e-3 * i_d + w * psi * np.cos(turned)
            return d if axis == "d" else q

        return of

    currents = {"id_a": lambda *_: i_d, "iq_a": lambda *_: i_q}
    record = _record([30.0, 60.0, -30.0, -60.0], vd_v=volts("d"), vq_v=volts("q"), **currents)
    measured = Quantity("commutation", ("x",)).measured({"x": record}, DRIVE)

    assert measured == pytest.approx(math.degrees(off), rel=0.01)  # cosines of the lateness remain
    one_way = _record([30.0, 60.0], vd_v=volts("d"), vq_v=volts("q"), **currents)
    assert math.isnan(Quantity("commutation", ("x",)).measured({"x": one_way}, DRIVE))


def test_steady_stretches_leave_out_rest_and_what_follows_a_step_of_reference_or_load():
    record = _record([0.0, 20.0, 40.0], load_torque_nm=lambda t_s, *_: np.where(t_s > 5.0, 0.5, 0.0))
    found = [(record["t_s"][part][0], record["t_s"][part][-1]) for part in steady_stretches(record)]

    assert [begin for begin, _ in found] == pytest.approx([2.35, 4.35, 5.35], abs=0.01)
    assert all(end > begin + 0.6 for begin, end in found)


def test_a_step_response_is_held_against_the_designed_one_and_one_at_the_current_limit_does_not_count():
    def slower(t_s, theta, wanted):
        return wanted - 0.2

    design = _record([20.0, 40.0])
    drive = Drive(4.0, 0.5, 1e-3, 1e-3, 10.0, {"x": design})
    step = Quantity("speed_step", ("x",))

    assert step.measured({"x": _record([20.0, 40.0], speed_rad_s=slower)}, drive) * RPM == pytest.approx(0.2)
    limited = {"iq_ref_a": lambda *_: 10.0}
    assert math.isnan(step.measured({"x": _record([20.0, 40.0], speed_rad_s=slower, **limited)}, drive))
