"""Dead-time compensation, the model of rdc fed forward, the error of the encoder's angle, an inductance that falls with
the current, harmonics of the flux, and a notch filter: what they leave in the simulated drive."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from evenspin.analysis.distortion import space_vector
from evenspin.errors import EvenspinError
from evenspin.gap.plan import plan
from evenspin.model import builtin_models, builtin_scenario, load_machine
from evenspin.model.setup import InputCurve
from evenspin.native import tables
from evenspin.sim import simulate

RPM = np.pi / 30.0
AMP_NM = 0.0384
SIGNALS = ("t_s", "true_ia_a", "true_ib_a", "true_ic_a", "true_theta_m_rad", "true_speed_rad_s", "true_iq_a", "fault")
DEAD_TIME = {"dead_time": {"dead_time_s": 1.5e-6, "soft_a": 0.0}}  # a hard sign: what the drive's soft one cannot know
COGGING = {"cogging": {"amplitude_nm": 0.01, "order": 24, "phase_rad": 0.7}}
MODEL = {"speed_model_ff": 1, "rdc_line1_cycles": 24, "rdc_line1_nm": 0.01, "rdc_line1_rad": 0.7}


def _run(rpm, load_a, effects, duration_s=6.0, numeric="float", t_s=(0.0,), plant=None, signals=SIGNALS, **drive):
    setup = builtin_scenario("guo2024/first").setup
    params = tables().params
    given = {key: params[key].to_number(value) if isinstance(value, str) else value for key, value in drive.items()}
    inputs = {
        "speed_ref_rad_s": InputCurve(tuple(t_s), tuple(np.atleast_1d(rpm) * RPM)),
        "load_brake_nm": InputCurve((0.0,), (load_a * AMP_NM,)),
    }
    setup = replace(setup, drive={**setup.drive, **given}, inputs=inputs, effects=effects, duration_s=duration_s)
    setup = replace(setup, log_rate_hz=10000.0, plant={**setup.plant, **(plant or {})})
    record = simulate(setup, signals, numeric)
    assert not record["fault"].any()
    return record


def _harmonic(record, order):
    """Size of an order of the stator current, over whole electrical turns after 3 s; negative: against the rotor."""
    late = record["t_s"] > 3.0
    current = space_vector(record["true_ia_a"][late], record["true_ib_a"][late], record["true_ic_a"][late])
    theta = 4.0 * record["true_theta_m_rad"][late]
    whole = theta - theta[0] < 2.0 * np.pi * int((theta[-1] - theta[0]) / (2.0 * np.pi))
    weight = np.gradient(theta)[whole]
    return abs(np.sum(current[whole] * np.exp(-1j * order * theta[whole]) * weight) / np.sum(weight))


def _ripple(record, begin_s, end_s):
    part = (record["t_s"] > begin_s) & (record["t_s"] <= end_s)
    return np.std(record["true_speed_rad_s"][part]) / RPM


@pytest.mark.parametrize(
    ("rpm", "load_a", "numeric"), [(60.0, 2.0, "float"), (255.0, 3.5, "fixed"), (900.0, 2.0, "float")]
)
def test_dead_time_compensation_takes_four_fifths_of_the_fifth_and_seventh_current_harmonic(rpm, load_a, numeric):
    without = _run(rpm, load_a, DEAD_TIME, numeric=numeric)
    with_it = _run(rpm, load_a, DEAD_TIME, numeric=numeric, dead_time_s=1.5e-6)
    for order in (-5, 7):
        assert _harmonic(with_it, order) < 0.2 * _harmonic(without, order)


def test_dead_time_compensation_does_not_chatter_at_standstill_and_a_third_too_much_of_it_does_no_harm():
    noise = {"current_noise_a": 0.03}
    still = [_run(0.0, 0.0, DEAD_TIME, plant=noise, dead_time_s=dead_time_s) for dead_time_s in (0.0, 1.5e-6)]
    late = still[0]["t_s"] > 2.0
    assert np.std(still[1]["true_iq_a"][late]) < 1.1 * np.std(still[0]["true_iq_a"][late])
    without, too_much = (_run(150.0, 2.0, DEAD_TIME, dead_time_s=dead_time_s) for dead_time_s in (0.0, 2.0e-6))
    assert _harmonic(too_much, -5) < 0.6 * _harmonic(without, -5)


@pytest.mark.parametrize("rpm", [20.0, 60.0, 150.0, 300.0])
def test_the_model_fed_forward_leaves_half_of_what_fal_forc_leaves_from_the_first_turn(rpm):
    learned = _run(rpm, 1.0, COGGING, 8.0, method="fal-forc")
    known = _run(rpm, 1.0, COGGING, 8.0, **MODEL)
    first_turn = 0.6 + 60.0 / rpm
    assert _ripple(known, 0.6, first_turn) < 0.5 * _ripple(learned, 4.0, 8.0)
    assert _ripple(known, 4.0, 8.0) < 0.5 * _ripple(learned, 4.0, 8.0)


def test_an_observer_beside_the_model_learns_what_it_leaves_and_not_the_same_again():
    alone = _run(150.0, 1.0, COGGING, 8.0, method="aro")
    both = _run(150.0, 1.0, COGGING, 8.0, method="aro", **MODEL)
    nothing = _run(150.0, 1.0, {}, 8.0, method="aro")  # what the steps of the encoder make through the observer
    assert _ripple(both, 6.0, 8.0) < 0.5 * _ripple(alone, 6.0, 8.0)
    assert _ripple(both, 6.0, 8.0) < 1.5 * _ripple(nothing, 6.0, 8.0)


def test_friction_fed_forward_takes_three_fifths_of_the_error_of_a_reversal():
    friction = {
        "coulomb_friction": {"torque_nm": 0.02},
        "stribeck_friction": {"torque_nm": 0.01, "speed_rad_s": 1.0, "shape": 1.0},
    }
    model = {"rdc_coulomb_nm": 0.02, "rdc_static_nm": 0.03, "rdc_stribeck_rad_s": 1.0, "rdc_shape": 1.0}
    t_s = np.arange(0.0, 8.0)
    rpm = 30.0 * (-1.0) ** t_s
    errors = []
    for drive in ({}, {"speed_model_ff": 1, **model}):
        record = _run(rpm, 0.0, friction, 8.0, t_s=t_s, **drive)
        wanted = 30.0 * (-1.0) ** np.floor(np.minimum(record["t_s"], 7.999))
        late = record["t_s"] > 2.0
        errors.append(np.mean(np.abs(record["true_speed_rad_s"][late] / RPM - wanted[late])))
    assert errors[1] < 0.4 * errors[0]


def test_the_overshoot_of_a_reversal_with_friction_fed_forward_is_that_of_a_drive_without_friction():
    friction = {"coulomb_friction": {"torque_nm": 0.02}}
    model = {"speed_model_ff": 1, "rdc_coulomb_nm": 0.02, "rdc_static_nm": 0.02}
    t_s = np.arange(0.0, 4.0)
    rpm = 30.0 * (-1.0) ** t_s
    over = []
    for effects, drive in (({}, {}), (friction, model), (friction, {**model, "speed_setpoint_weight": 0.0})):
        record = _run(rpm, 0.0, effects, 4.0, t_s=t_s, **drive)
        wanted = 30.0 * (-1.0) ** np.floor(np.minimum(record["t_s"], 3.999))
        late = record["t_s"] > 1.0
        over.append(np.max((record["true_speed_rad_s"] / RPM * np.sign(wanted))[late]) - 30.0)
    assert over[1] < over[0]
    assert over[2] < 0.4 * over[1]


def test_deadbeat_control_refuses_the_dead_time_and_names_both():
    with pytest.raises(EvenspinError, match=r"dead_time_s.*current_controller|current_controller.*dead_time_s"):
        _run(60.0, 1.0, {}, dead_time_s=1.0e-6, current_controller="deadbeat")


# ---- an inductance that falls with the current


def _step(from_a, to_a, i_sat_a, saturation_a, numeric="float", rotor="d", by_amplitude=0.0):
    """Current of an axis at rest from 0.5 ms before a step of its reference, in parts of the step."""
    setup = builtin_scenario("guo2024/first").setup
    inputs = {"control_mode": InputCurve((0.0,), (0.0,))}
    inputs[f"i{rotor}_ref_a"] = InputCurve((0.0, 0.6, 0.8), (0.0, from_a, to_a))
    drive = {"saturation_a": saturation_a, "saturation_cross": by_amplitude if saturation_a else 0.0}
    limits = {"over_current_a": 40.0, "id_limit_a": 20.0, "iq_limit_a": 20.0, "plausibility_share": 0.0}
    effects = {"inductance_saturation": {"i_sat_a": i_sat_a, "by_amplitude": by_amplitude}} if i_sat_a else {}
    setup = replace(setup, drive={**setup.drive, **drive, **limits}, inputs=inputs, effects=effects, duration_s=0.82)
    record = simulate(replace(setup, log_rate_hz=10000.0), ("t_s", f"true_i{rotor}_a", "fault"), numeric)
    assert not record["fault"].any()
    return (record[f"true_i{rotor}_a"][record["t_s"] > 0.7995][:50] - from_a) / (to_a - from_a)


@pytest.mark.parametrize(
    ("from_a", "to_a", "numeric", "by_amplitude"),
    [(4.0, 6.0, "float", 0.0), (6.0, 8.0, "fixed", 0.0), (8.0, 6.0, "float", 1.0)],
)
def test_a_current_step_on_saturated_iron_is_within_a_tenth_of_the_designed_one(from_a, to_a, numeric, by_amplitude):
    designed = _step(from_a, to_a, 0.0, 0.0)
    without = _step(from_a, to_a, 5.0, 0.0, by_amplitude=by_amplitude)
    with_it = _step(from_a, to_a, 5.0, 5.0, numeric, by_amplitude=by_amplitude)
    assert np.max(np.abs(without - designed)) > 0.35
    assert np.max(np.abs(with_it - designed)) < 0.1


@pytest.mark.parametrize(("from_a", "to_a"), [(0.0, 8.0), (8.0, 0.0), (-6.0, 6.0)])
def test_a_current_step_through_all_of_the_saturation_is_nearer_to_the_designed_one(from_a, to_a):
    designed, without, with_it = (_step(from_a, to_a, *each) for each in ((0.0, 0.0), (5.0, 0.0), (5.0, 5.0)))
    # the inductance moves by 2.4 to 3.6 within the two periods that a voltage needs: the gain cannot follow in full
    assert np.sum((with_it - designed) ** 2) < 0.5 * np.sum((without - designed) ** 2)


def test_a_saturation_that_is_not_there_makes_a_step_slower_and_nothing_worse():
    slow = _step(0.0, 6.0, 0.0, 5.0)
    assert np.max(slow) < 1.1 and abs(slow[-1] - 1.0) < 0.02


# ---- error of the encoder's angle: a disc off centre, whose inverse has a second order, too

OFF_CENTRE_RAD, WHERE_RAD = 0.01, 0.9
DISC = {"encoder_eccentricity": {"amplitude_rad": OFF_CENTRE_RAD, "phase_rad": WHERE_RAD}}
ANGLE = {
    "encoder_cos1_rad": OFF_CENTRE_RAD * np.sin(WHERE_RAD),
    "encoder_sin1_rad": OFF_CENTRE_RAD * np.cos(WHERE_RAD),
    "encoder_cos2_rad": -0.5 * OFF_CENTRE_RAD**2 * np.sin(2.0 * WHERE_RAD),
    "encoder_sin2_rad": -0.5 * OFF_CENTRE_RAD**2 * np.cos(2.0 * WHERE_RAD),
}
SPEEDS = (*SIGNALS, "speed_rad_s", "true_torque_nm")


def _order(record, signal, order):
    """Amplitude of a mechanical order over whole turns after 2 s."""
    late = record["t_s"] > 2.0
    theta = record["true_theta_m_rad"][late]
    whole = theta - theta[0] < 2.0 * np.pi * int((theta[-1] - theta[0]) / (2.0 * np.pi))
    weight = np.gradient(theta)[whole]
    return 2.0 * abs(np.sum(record[signal][late][whole] * np.exp(-1j * order * theta[whole]) * weight) / np.sum(weight))


@pytest.mark.parametrize(
    ("rpm", "source", "numeric"),
    [(60.0, "mt", "float"), (255.0, "pll", "fixed"), (600.0, "fir", "float"), (900.0, "mt", "fixed")],
)
def test_the_angle_correction_takes_nine_tenths_of_what_a_disc_off_centre_makes_of_seen_and_true_speed(
    rpm, source, numeric
):
    given = {"speed_source": source, "signals": SPEEDS, "numeric": numeric}
    without, with_it = (_run(rpm, 1.0, DISC, 5.0, **given, **d) for d in ({}, ANGLE))
    # at low speed the loop follows what it sees: all of the ripple is in the true speed
    for signal in ("true_speed_rad_s", *(["speed_rad_s"] if rpm > 100.0 else [])):
        assert _order(without, signal, 1) > 0.2 * RPM
        assert _order(with_it, signal, 1) < 0.1 * _order(without, signal, 1)


def test_the_angle_correction_of_another_phase_does_not_help():
    wrong = {**ANGLE, "encoder_cos1_rad": ANGLE["encoder_sin1_rad"], "encoder_sin1_rad": -ANGLE["encoder_cos1_rad"]}
    without, turned = (_run(255.0, 1.0, DISC, 5.0, signals=SPEEDS, **d) for d in ({}, wrong))
    assert _order(turned, "true_speed_rad_s", 1) > 1.2 * _order(without, "true_speed_rad_s", 1)


# ---- harmonics of the magnet flux

FLUX = {"flux_harmonics": {"torque_ripple_rel": 0.05, "sign": -1.0, "fifth_share": 0.5}}


@pytest.mark.parametrize("numeric", ["float", "fixed"])
@pytest.mark.parametrize("rpm", [60.0, 255.0, 900.0])
def test_flux_harmonics_in_the_drive_take_nine_tenths_of_their_torque_ripple_at_three_loads(rpm, numeric):
    for load_a in (0.5, 2.0, 4.0):
        without, with_it = (
            _run(rpm, load_a, FLUX, 4.2, numeric, signals=SPEEDS, **drive) for drive in ({}, {"flux_cos6": -0.05})
        )
        assert _order(with_it, "true_torque_nm", 24) < 0.1 * _order(without, "true_torque_nm", 24)


def test_flux_harmonics_that_are_half_too_large_still_take_half_of_the_torque_ripple_and_a_wrong_sign_none():
    without, too_much, wrong = (_run(255.0, 2.0, FLUX, 4.2, signals=SPEEDS, flux_cos6=c) for c in (0.0, -0.075, 0.05))
    ripple = [_order(each, "true_torque_nm", 24) for each in (without, too_much, wrong)]
    assert ripple[1] < 0.6 * ripple[0]
    assert ripple[2] > 1.8 * ripple[0]


# ---- notch filter: a drive whose tracking filter is so slow that the speed loop excites the shaft

NOTCH = {"speed_notch_hz": 60.0, "speed_notch_damping": 0.3, "speed_notch_depth": 0.05}


def _shaft(effects, step, numeric="float", **drive):
    """Speed after a step of the reference or of the load at 1.5 s, without noise, until nothing moves any more."""
    setup = plan(load_machine(builtin_models()["servo"]), 1)[0].setup
    inputs = {
        "control_mode": InputCurve((0.0,), (1.0,)),
        "speed_ref_rad_s": InputCurve((0.0, 1.5), (300.0 * RPM, (360.0 if step == "reference" else 300.0) * RPM)),
        "load_brake_nm": InputCurve((0.0, 1.5), (0.2, 0.7 if step == "load" else 0.2)),
    }
    quiet = {"current_noise_a": 0.0, "current_lsb_a": 0.0, "counts_per_rev": 0.0}
    setup = replace(
        setup, drive={**setup.drive, **drive}, plant={**setup.plant, **quiet}, inputs=inputs, effects=effects
    )
    record = simulate(replace(setup, duration_s=4.0, log_rate_hz=2000.0), ("t_s", "true_speed_rad_s", "fault"), numeric)
    assert not record["fault"].any()
    return record["true_speed_rad_s"][record["t_s"] >= 1.5]


def _peak(speed, stiff):
    """Largest line from 30 Hz on of what the shaft adds: of the closed loop's answer to a step."""
    off = speed - stiff
    return np.max(np.abs(np.fft.rfft(off))[np.fft.rfftfreq(len(off), 5e-4) > 30.0])


@pytest.mark.parametrize("numeric", ["float", "fixed"])
@pytest.mark.parametrize("load_ratio", [0.5, 0.65])
def test_a_notch_takes_12_db_off_the_resonance_after_a_step_of_the_reference_and_adds_none_after_a_load_step(
    load_ratio, numeric
):
    shaft = {"two_mass": {"f_res_hz": 60.0, "load_ratio": load_ratio, "damping_ratio": 0.03}}
    for step, most_db in (("reference", -12.0), ("load", 0.0)):
        stiff = _shaft({}, step, numeric)
        without, with_it = (_peak(_shaft(shaft, step, numeric, **drive), stiff) for drive in ({}, NOTCH))
        assert 20.0 * np.log10(with_it / without) < most_db


def test_repetitive_control_refuses_the_notch_and_names_both():
    with pytest.raises(EvenspinError, match=r"speed_notch_hz.*method|method.*speed_notch_hz"):
        _run(60.0, 1.0, {}, speed_notch_hz=60.0, method="forc")
