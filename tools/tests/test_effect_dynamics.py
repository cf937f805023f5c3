"""Effects that change the dynamics, in the whole drive, against SciPy on the same equations, written independently."""

import math
from dataclasses import replace

import numpy as np
import pytest
from evenspin.model import InputCurve, load_scenario
from evenspin.sim import simulate
from scipy.integrate import solve_ivp

TS_S = 1e-4
MACHINE = {
    "resistance_ohm": 0.36,
    "ld_h": 0.2e-3,
    "lq_h": 0.3e-3,
    "rotor_locked": 1.0,
    "counts_per_rev": 0.0,
    "current_lsb_a": 0.0,
}
SIGNALS = ("t_s", "id_a", "iq_a", "true_id_a", "true_iq_a", "vd_v", "vq_v")


@pytest.fixture
def steps(scenario):
    """Current steps on a locked rotor at angle 0, logged every period."""
    setup = load_scenario(scenario).setup
    inputs = {
        "control_mode": InputCurve((0.0,), (0.0,)),
        "id_ref_a": InputCurve((0.0, 0.005, 0.010), (2.0, 9.0, -4.0)),
        "iq_ref_a": InputCurve((0.0, 0.003, 0.008), (0.0, 8.0, -9.0)),
    }
    return replace(
        setup, plant={**setup.plant, **MACHINE}, effects={}, inputs=inputs, duration_s=0.015, log_rate_hz=1e4
    )


def run(setup, **effects):
    return simulate(replace(setup, effects=effects), SIGNALS)


def coil(volts, inductance_h, i_sat_a, extra_periods):
    """Current at the start of every period: voltages act one period and `extra_periods` after they were commanded."""

    def slope(_, i, v):
        return [(v - 0.36 * i[0]) / inductance_h * (1.0 + (i[0] / i_sat_a) ** 2)]

    currents = [0.0]
    for k in range(len(volts) - 1):
        delay = 1.0 + extra_periods
        whole, part = math.floor(delay), delay - math.floor(delay)
        now = currents[-1]
        for length, ago in ((part, whole + 1), (1.0 - part, whole)):
            if length > 0.0:
                v = volts[k - ago] if k >= ago else 0.0
                now = solve_ivp(slope, (0.0, length * TS_S), [now], args=(v,), rtol=1e-10, atol=1e-12).y[0, -1]
        currents.append(now)
    return np.array(currents)


@pytest.mark.parametrize("i_sat_a, extra_periods", [(math.inf, 0.0), (7.0, 0.0), (math.inf, 0.6), (12.0, 1.25)])
def test_current_steps_are_those_of_a_saturating_coil_behind_the_delay(steps, i_sat_a, extra_periods):
    effects = {"current_loop_delay": {"extra_periods": extra_periods}}
    if math.isfinite(i_sat_a):
        effects["inductance_saturation"] = {"i_sat_a": i_sat_a}

    record = run(steps, **effects)

    for axis, inductance_h in (("d", 0.2e-3), ("q", 0.3e-3)):
        expected = coil(record[f"v{axis}_v"], inductance_h, i_sat_a, extra_periods)
        assert np.abs(expected).max() > 7.0
        # 24 V times the rounding of a duty in single precision, and the integration steps
        assert record[f"true_i{axis}_a"] == pytest.approx(expected, abs=2e-3), axis


def test_the_filter_shows_the_drive_less_than_the_current_that_flows(steps):
    tau_s, coil_s = 1e-4, 0.2e-3 / 0.36
    record = run(steps, current_filter={"tau_s": tau_s})

    seen = [0.0]
    for before, after in zip(record["true_id_a"][:-1], record["true_id_a"][1:], strict=True):
        # one voltage from sample to sample: the current runs along an exponential, the filter adds its own
        fall, decay = math.exp(-TS_S / coil_s), math.exp(-TS_S / tau_s)
        end = (after - fall * before) / (1.0 - fall)
        forced = coil_s / (coil_s - tau_s) * (before - end)
        seen.append(end + forced * fall + (seen[-1] - end - forced) * decay)
    assert record["id_a"] == pytest.approx(seen, abs=1e-3)
    assert record["true_id_a"].max() > record["id_a"].max() + 0.1  # the voltage peak that is the filter's signature


def test_each_of_them_changes_the_answer_a_little_for_a_little(steps):
    """A fit moves the parameters: a step of a thousandth of the size has a thousandth of the effect."""
    base = run(steps)["true_id_a"]
    for effect, param, size in (("current_loop_delay", "extra_periods", 0.5), ("current_filter", "tau_s", 1e-4)):
        large, larger = (run(steps, **{effect: {param: value}})["true_id_a"] for value in (size, 1.001 * size))
        change = np.abs(larger - large).max() / np.abs(large - base).max()
        assert 1e-4 < change < 1e-2, effect


def resonance(setup, **effects):
    """Frequency at which the rotor rings after a step of the load, current held at zero."""
    inputs = {
        "control_mode": InputCurve((0.0,), (0.0,)),
        "load_torque_nm": InputCurve((0.0, 0.01), (0.0, 0.05)),
    }
    plant = {**setup.plant, "viscous_nms": 0.0, "counts_per_rev": 0.0, "psi_wb": 1e-6}
    run_ = replace(setup, plant=plant, effects=effects, inputs=inputs, duration_s=0.5, log_rate_hz=1e4)
    record = simulate(run_, ("t_s", "true_speed_rad_s", "true_load_speed_rad_s")).between(0.02, 0.5)
    twist = record["true_speed_rad_s"] - record["true_load_speed_rad_s"]
    spectrum = np.abs(np.fft.rfft(twist * np.hanning(len(twist)), 1 << 17))
    return np.argmax(spectrum) * 1e4 / (1 << 17), record


@pytest.mark.parametrize("f_res_hz, load_ratio", [(80.0, 0.3), (350.0, 0.7)])
def test_two_masses_ring_at_the_free_free_resonance_and_weigh_as_much_as_before(scenario, f_res_hz, load_ratio):
    setup = load_scenario(scenario).setup

    ringing_hz, record = resonance(
        setup, two_mass={"f_res_hz": f_res_hz, "load_ratio": load_ratio, "damping_ratio": 0.005}
    )

    assert ringing_hz == pytest.approx(f_res_hz, rel=2e-3)
    together = (1.0 - load_ratio) * record["true_speed_rad_s"] + load_ratio * record["true_load_speed_rad_s"]
    slope = np.polyfit(record["t_s"], together, 1)[0]
    assert slope == pytest.approx(-0.05 / 7.06e-5, rel=1e-4)
