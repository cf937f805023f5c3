"""The design check of the speed loop against the simulated firmware, and against the block that learns."""

import numpy as np
import pytest
from evenspin import blocks
from evenspin.design import sampled
from evenspin.design.rc import Repetitive
from evenspin.design.sampled import Sampled, sampled_loop
from evenspin.design.source import loop_of
from evenspin.design.stability import Verdict, judge, with_repetitive
from evenspin.errors import InputError
from evenspin.model import builtin_models, load_machine
from evenspin.model.setup import InputCurve, Setup, Tune
from evenspin.native import tables
from evenspin.sim import simulate
from stability_campaign import SIGNALS, Case, designed, oscillates, random_case

SPEED = 307.0 * np.pi / 30.0
IDEAL = {"counts_per_rev": 0.0, "current_range_a": 1000.0, "current_noise_a": 0.0, "current_lsb_a": 0.0}
WIDE = {"encoder_counts": 2.0**20, "iq_limit_a": 500.0, "over_current_a": 1000.0, "rc_limit_unit": 1e6}
QUIET = {"offset_calibration_periods": 0.0, "align_periods": 0.0, "auto_run": 1.0, "stall_s": 0.0}


def drive_of(name, **changes):
    machine = load_machine(builtin_models()[name])
    defaults = {key: field.default for key, field in tables().params.items()}
    return dict(machine.plant), defaults | dict(machine.drive) | changes


def simulated(plant, drive, speed=20.0):
    wide = {**drive, **WIDE, **QUIET}
    return Case({**plant, **IDEAL, "initial_speed_rad_s": speed}, wide, speed, 1e-4, 6.0)


@pytest.mark.parametrize(
    ("kp", "k_rc", "verdict"),
    [
        (0.0368, 0.6, Verdict.STABLE),
        (0.0368, 1.4, Verdict.STABLE),
        (0.3, 0.1, Verdict.STABLE),
        (1.0, 0.1, Verdict.UNSTABLE),
        (2.0, 0.01, Verdict.UNSTABLE),
        (0.0368, 1.9, Verdict.UNSTABLE),
        (1e30, 0.6, Verdict.UNSTABLE),
    ],
)
def test_verdict_and_simulation_agree_on_the_drive_of_the_paper(kp, k_rc, verdict):
    plant, drive = drive_of("guo2024", speed_kp_a_per_unit=kp, rc_gain=k_rc, method=2.0)

    assert judge(plant, drive, 20.0, Repetitive(gain=k_rc)).verdict is verdict
    if kp < 1e3:
        assert oscillates(simulated(plant, drive)) is (verdict is Verdict.UNSTABLE)


def test_a_current_loop_that_is_too_fast_is_found_and_named():
    """12 000 rad/s with 1.5 periods of delay, 1.8 rad at crossover: far beyond a phase margin."""
    plant, drive = drive_of("guo2024")
    plant |= {"pole_pairs": 7.0, "resistance_ohm": 0.1, "ld_h": 5e-5, "lq_h": 5e-5, "psi_wb": 5e-3}
    plant |= {"inertia_kgm2": 5e-5}

    found = judge(plant, drive, SPEED, Repetitive())

    assert found.verdict is Verdict.UNSTABLE and found.reason == "the current loop itself"
    slower = drive | {"current_kp_v_per_a": 0.15, "current_ki_v_per_as": 300.0}
    assert judge(plant, slower, SPEED, Repetitive()).verdict is Verdict.STABLE


@pytest.mark.parametrize("kp", [0.54, 0.56])
def test_close_to_the_boundary_nothing_is_promised(kp):
    plant, drive = drive_of("guo2024", speed_kp_a_per_unit=kp)

    assert judge(plant, drive, SPEED).verdict is not Verdict.STABLE


def left(case, gain, value):
    """rms of the speed about its mean, rad/s, three seconds after the gain was raised to this value from a third."""
    inputs = {
        "speed_ref_rad_s": InputCurve((0.0,), (case.speed_rad_s,)),
        "load_torque_nm": InputCurve((0.0, 1.2), (0.0, case.step_nm)),
    }
    drive, tunes = {**case.drive, gain: value / 3.0}, (Tune(1.0, gain, value),)
    record = simulate(Setup("raised", case.plant, drive, {}, inputs, tunes, 4.2, 1000.0, 1), SIGNALS)
    return np.inf if record["fault"].any() else float(record.between(3.7, 4.2)["true_speed_rad_s"].std())


KINDS = {
    "M/T": ("guo2024", {"speed_source": 1.0}),
    "tracking filter": ("guo2024", {"speed_source": 0.0}),
    "FIR": ("guo2024", {"speed_source": 2.0}),
    "in the current interrupt": ("guo2024", {"speed_source": 1.0, "speed_inline": 1.0}),
    "every PWM period": ("guo2024", {"speed_source": 2.0, "speed_inline": 1.0, "speed_divider": 1.0}),
    "deadbeat": ("tang2020-rig1", {"speed_source": 1.0, "speed_inline": 0.0, "speed_divider": 10.0}),
    "slow current loop": ("servo", {"current_kp_v_per_a": 1.5, "current_ki_v_per_as": 560.0}),
}


@pytest.mark.parametrize("kind", KINDS)
def test_the_simulation_turns_unstable_at_the_gain_of_the_design(kind):
    """Two percent below the boundary it settles, two percent above it does not: each delay counts several percent."""
    name, changes = KINDS[kind]
    plant, drive = drive_of(name, method=0.0, **changes)
    gain = "speed_kp_a_per_unit"
    low, high = 0.1 * drive[gain], 1e3 * drive[gain]
    while high > 1.0001 * low:
        middle = np.sqrt(low * high)
        inside = sampled_loop({**plant, **IDEAL}, {**drive, **WIDE, gain: middle}, 20.0).radius < 1.0
        low, high = (middle, high) if inside else (low, middle)

    settled, unstable = (left(simulated(plant, drive), gain, part * low) for part in (0.98, 1.02))

    assert settled < 0.02 * unstable


def test_what_is_stable_at_one_speed_only_is_not_called_stable():
    plant, drive = drive_of("guo2024")
    found = judge(plant, drive, 61.0, Repetitive(gain=1.62))

    assert found.verdict is Verdict.MARGINAL
    assert found.k_rc_bound == pytest.approx(1.61, abs=0.01)


@pytest.mark.parametrize("name", sorted(builtin_models()))
def test_slow_ripple_meets_the_loop_of_the_paper(name):
    """Below 2 Hz the delays of some 1 ms turn M by less than 0.01 of its 1."""
    plant, drive = drive_of(name)
    f_hz = np.array([0.5, 1.0, 2.0])

    assert sampled_loop(plant, drive, 10.0).closed(f_hz) == pytest.approx(loop_of(plant, drive).closed(f_hz), abs=0.02)


def test_a_delay_turns_the_open_loop_by_its_time():
    plant, drive = drive_of("guo2024")
    f_hz = np.array([10.0, 40.0, 90.0])

    def open_loop(periods):
        closed = sampled_loop(plant, drive, SPEED, periods).closed(f_hz)
        return closed / (1.0 - closed)

    turned = np.angle(open_loop(20) / open_loop(0))

    assert np.unwrap(turned) == pytest.approx(-2.0 * np.pi * f_hz * 2e-3, rel=1e-6)


@pytest.mark.parametrize("lead", [0, 1, 4])
@pytest.mark.parametrize("side2", [0.0, -0.1])
@pytest.mark.parametrize(("order", "whole"), [(1, False), (2, False), (3, False), (2, True)])
def test_the_memory_of_the_matrix_is_that_of_the_block(lead, order, whole, side2):
    """A small loop with the very block in it, step by step, against powers of the matrix."""
    a, b, c = np.array([[0.7, 0.2], [-0.1, 0.5]]), np.array([0.3, 0.4]), np.array([1.0, 0.5])
    rc = Repetitive(gain=0.5, lead=lead, q_side=0.2, q_centre=0.5, q_side2=side2, order=order)
    period = 23.4
    matrix = with_repetitive(Sampled(a, b, c, 1e-3, 2.0, 10.0), rc, period, whole=whole)
    block = blocks.RepetitiveController(0.5, lead, (0.2, 0.5), 0 if whole else order, q_side2=side2)
    state, x = np.zeros(len(matrix)), np.array([1.0, -2.0])
    state[:2] = x

    for _ in range(200):
        x = a @ x + b * block.step(error=-2.0 * float(c @ x), period_samples=period)
        state = matrix @ state
        assert state[:2] == pytest.approx(x, abs=2e-5)  # the block calculates in single precision


@pytest.mark.parametrize("rpm", [150.0, 300.0, 1200.0])
def test_five_taps_of_q_are_stable_at_speeds_at_which_a_q_of_1_is_not(rpm):
    """Both as guo2024/beyond_fast has them; what they leave in the q current is in FAST_RATIOS of its checks."""
    plant, drive = drive_of("guo2024")
    five = Repetitive(1.0, 3, 0.0133, 0.98, 3, (0.6, 0.4), q_side2=-0.0033)
    one = Repetitive(1.0, 3, 0.0, 1.0, 3, (0.6, 0.4))

    assert judge(plant, drive, rpm * np.pi / 30.0, five).verdict is Verdict.STABLE
    assert judge(plant, drive, rpm * np.pi / 30.0, one).verdict is not Verdict.STABLE


@pytest.mark.parametrize("seed", range(1, 17))
def test_the_simulated_firmware_does_what_the_design_check_says(seed):
    """The short form of `make stability`: 200 of these."""
    case = random_case(seed)
    verdict = designed(case).verdict

    assert verdict is Verdict.MARGINAL or oscillates(case) is (verdict is Verdict.UNSTABLE)


def test_a_notch_filter_is_refused():
    plant, drive = drive_of("guo2024", speed_notch_hz=80.0)
    with pytest.raises(InputError, match=r"speed_notch_hz = 80.0: must be 0: repetitive control does not go with"):
        sampled_loop(plant, drive, 20.0)


def test_a_current_controller_without_equations_is_refused(monkeypatch):
    plant, drive = drive_of("guo2024", current_controller=1.0)
    monkeypatch.setattr(sampled, "CONTROLLERS", ("pi",))

    with pytest.raises(InputError, match=r"current_controller = 'deadbeat': must be pi: there is no model"):
        sampled_loop(plant, drive, 20.0)
