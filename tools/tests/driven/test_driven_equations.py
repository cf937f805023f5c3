"""What an effect does in the equations is what the simulated machine does: with its own parameters nothing is left."""

from pathlib import Path

import numpy as np
import pytest
from driven_logs import columns_of
from evenspin.effects.equations import HOOKS, hook
from evenspin.model.machine import find_model, load_machine
from evenspin.native import tables
from evenspin.weakform.analysis import recording_of
from evenspin.weakform.answer import late_current
from evenspin.weakform.equations import Timing
from evenspin.weakform.signals import signals_of

SPEEDS_RAD_S = (5.0, 40.0, -8.0, -60.0)
REST_RAD_S = 0.5
ELECTRICAL = ("id_a", "iq_a", "vd_v", "vq_v")

ACTING = {
    "cogging": {"amplitude_nm": 0.1, "phase_rad": 1.0, "order": 18.0},
    "coulomb_friction": {"torque_nm": 0.1},
    "current_gain": {"gain_a": 1.05, "gain_b": 0.96},
    "current_offset": {"offset_a_a": 0.2, "offset_b_a": -0.1},
    "encoder_eccentricity": {"amplitude_rad": 0.01, "phase_rad": 0.7},
    "encoder_offset": {"angle_el_rad": 0.3},
    "flux_harmonics": {"torque_ripple_rel": 0.05, "sign": -1.0, "fifth_share": 0.8},
    "inductance_saturation": {"i_sat_a": 2.0},
    "inertia": {"factor": 1.4},
    "load_torque": {"torque_nm": -0.1},
    "misalignment": {"amplitude_nm": 0.1, "phase_rad": 0.4, "second_rel": 0.5, "phase2_rad": 2.0},
    "stribeck_friction": {"torque_nm": 0.1, "speed_rad_s": 10.0},
    "torque_constant": {"factor": 0.9},
    "two_mass": {"f_res_hz": 15.0, "load_ratio": 0.5, "damping_ratio": 0.04},
    "viscous_friction": {"factor": 2.5},
    "winding_resistance": {"factor": 1.4},
}


def equations_of(columns):
    machine = load_machine(find_model("servo", Path(), lambda must, hint: AssertionError(must)))
    columns = {**columns, "theta_m_rad": np.unwrap(columns["theta_m_rad"])}
    return recording_of(signals_of("log", columns), dict(machine.plant), REST_RAD_S, 0).equations


def parts_of(equations, acting):
    return equations.residual(acting, Timing(1.5 / equations.plant["pwm_hz"])).parts()


def left_of(columns, acting):
    """rms of each equation, without the outermost 3 % of the windows: load steps are in them."""
    parts = parts_of(equations_of(columns), acting)
    found = []
    for k in (0, 2, 3):
        size = np.sort(np.abs(parts[k]))[: int(0.97 * len(parts[k]))]
        found.append(float(np.sqrt(np.mean(size**2))))
    return np.array(found)


@pytest.mark.parametrize("effect", ACTING)
def test_with_its_own_parameters_an_effect_leaves_what_a_healthy_machine_leaves(effect):
    healthy = left_of(columns_of(speeds=SPEEDS_RAD_S), [])
    columns = columns_of(((effect, tuple(ACTING[effect].items())),), speeds=SPEEDS_RAD_S)
    without, with_it = left_of(columns, []), left_of(columns, [(effect, ACTING[effect])])
    # 40 %: other currents and speeds have other noise of rounding. The offset, 20 times the noise of the torque, leaves
    # 4 % of itself where the speed is not yet steady; so does the twist, by the half row for which no log tells when a
    # load of this log steps. What an effect does is three times what is left; a saturation at
    # twice the current of this log bends the d axis by a third of its noise.
    assert np.all(with_it < (2.0 if effect in ("current_offset", "two_mass") else 1.4) * healthy), (with_it, healthy)
    assert np.any(without > (1.25 if effect == "inductance_saturation" else 3.0) * with_it), (without, with_it)


def delays_s(rows):
    """How late the torque and the q axis each say that the currents and voltages are, which come so many rows later."""
    columns = columns_of(speeds=SPEEDS_RAD_S)
    late = {name: x[: len(x) - rows] if name in ELECTRICAL else x[rows:] for name, x in columns.items()}
    equations = equations_of(late)
    term = late_current("late", equations.signals.period_s, equations.plant, 0)
    torque, _, _, q_axis = zip(parts_of(equations, []), term.columns(equations), strict=True)
    return np.array([-float(of[:, 0] @ left) / float(of[:, 0] @ of[:, 0]) for left, of in (torque, q_axis)])


@pytest.mark.parametrize("rows", [2, 4])
def test_torque_and_voltage_tell_alike_how_much_later_the_currents_and_voltages_of_a_row_are_than_its_angle(rows):
    """As those of a program are that logs means since the last row: half a row."""
    # Noise of the acceleration, which the column is made of, takes a tenth off what the voltage tells.
    assert delays_s(rows) - delays_s(0) == pytest.approx([5e-4 * rows] * 2, rel=0.15)


def test_currents_are_no_later_than_a_row_and_a_pwm_period():
    """Where torque and inertia fit a little better with currents of 5 ms before, at rows of 1 ms, they are wrong."""
    term = late_current("late", 1e-3, {"pwm_hz": 1e4, "pole_pairs": 4.0, "psi_wb": 0.01}, 0)
    assert (term.low[0], term.high[0]) == pytest.approx((-1.1e-3, 1.1e-3))


def test_a_dead_time_leaves_no_mean_loss_where_the_current_is_clear():
    params = {"dead_time_s": 1.5e-6}
    columns = columns_of((("dead_time", tuple(params.items())),), speeds=SPEEDS_RAD_S)
    without, with_it = left_of(columns, []), left_of(columns, [("dead_time", params)])
    # 2.25 V of a phase are 2.86 V of the vector; near zero current the simulator lets a leg float, unlike a mean loss.
    assert without[2] == pytest.approx(4.0 / np.pi * 2.25, rel=0.1)
    assert with_it[2] < 0.5 * without[2]


def test_every_effect_has_an_equation_or_a_reason_why_not():
    without = {name for name, e in tables().effects.items() if not any(hook(name, each) for each in HOOKS)}
    # Delays and filters need the controller, backlash has no equation; sums of terms are for scenarios.
    scenarios = {"torque_ripple", "empirical", "empirical_voltage"}
    assert without == {"current_filter", "current_loop_delay", "backlash"} | scenarios
    assert set(ACTING) | {"dead_time"} | without == set(tables().effects)
