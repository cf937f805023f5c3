"""Margins and gains of a repetitive controller against the paper and against formulas written here a second time."""

import numpy as np
import pytest
from evenspin import blocks
from evenspin.design.loop import SpeedLoop
from evenspin.design.rc import Repetitive, design, frequencies, gain_bound, gain_db
from evenspin.design.source import loop_of, repetitive_of
from evenspin.errors import InputError
from evenspin.model import builtin_scenario
from scipy import signal

TS = 1e-3
PERIOD_307 = 60.0 / (4 * 307 * TS)


@pytest.fixture(scope="module")
def loop() -> SpeedLoop:
    setup = builtin_scenario("guo2024/first").setup
    return loop_of(setup.plant, setup.drive)


def late(loop: SpeedLoop, samples: float) -> SpeedLoop:
    from dataclasses import replace

    return replace(loop, delay_s=samples * TS)


def test_the_loop_is_that_of_the_paper(loop):
    assert loop.torque_per_a_nm == pytest.approx(0.0384)
    assert loop.current_bandwidth_rad_s == pytest.approx(3000.0)
    assert repetitive_of(builtin_scenario("guo2024/first").setup.drive) == Repetitive(0.6, 5, 0.45, 0.10, 2, None)


# gains of CRC and FORC at 307 rpm, figures 4 and 10 of the paper; k_rc 0.525 is what gives its numbers
@pytest.mark.parametrize(("k_rc", "at_its_own", "at_the_ripple"), [(0.525, 36.7, 12.5), (0.6, 37.9, 13.8)])
def test_the_gains_of_crc_are_those_of_the_paper(k_rc, at_its_own, at_the_ripple):
    f_hz = np.array([1000.0 / 48.0, 1000.0 / PERIOD_307])

    gains = gain_db(Repetitive(gain=k_rc), PERIOD_307, f_hz, TS, whole=True)

    assert gains == pytest.approx([at_its_own, at_the_ripple], abs=0.06)  # the paper rounds to 0.1


def test_forc_has_its_peak_at_the_ripple():
    f_hz = np.arange(20.0, 21.0, 0.001)

    gains = gain_db(Repetitive(), PERIOD_307, f_hz, TS)

    assert f_hz[np.argmax(gains)] == pytest.approx(1000.0 / PERIOD_307, abs=0.02)


@pytest.mark.parametrize("whole", [True, False])
def test_the_gain_is_that_of_the_block_itself(whole):
    """What the block answers to a double impulse (no mean: Q keeps that for ever) against the formula."""
    rc = Repetitive(gain=0.525)
    block = blocks.RepetitiveController(0.525, 5, (0.45, 0.10), 0 if whole else 2)
    answer = np.array([block.step(float(k == 0) - (k == 1), PERIOD_307) for k in range(60_000)])
    f_hz = np.array([20.83, 20.47, 40.9, 100.0])

    z = np.exp(2j * np.pi * f_hz * TS)
    measured = 1.0 + z[:, None] ** -np.arange(len(answer)) @ answer / (1.0 - 1.0 / z)

    assert 20 * np.log10(np.abs(measured)) == pytest.approx(gain_db(rc, PERIOD_307, f_hz, TS, whole=whole), abs=0.02)


@pytest.mark.parametrize(("delay", "max_m", "phase_deg", "bound"), [(0, 1.20, 34.0, 1.38), (1, 1.22, 40.0, 1.25)])
def test_margins_are_those_of_the_reference(loop, delay, max_m, phase_deg, bound):
    """Numbers of an independent computation."""
    found = design(late(loop, delay), Repetitive())

    assert found.max_m == pytest.approx(max_m, abs=0.005)
    assert found.margins.phase_deg == pytest.approx(phase_deg, abs=0.5)
    assert found.margins.bound_sufficient == pytest.approx(bound, abs=0.01)


def test_the_contraction_is_that_of_the_reference(loop):
    assert design(loop, Repetitive()).margins.contraction == pytest.approx(0.82, abs=0.005)
    # Q 0.05 / 0.9 / 0.05 of that computation: 0.994 without, 0.96 with one sample of delay, 1.011 with fal
    narrow = Repetitive(q_side=0.05, q_centre=0.9)
    assert design(loop, narrow).margins.contraction == pytest.approx(0.994, abs=0.001)
    assert design(late(loop, 1), narrow).margins.contraction == pytest.approx(0.96, abs=0.01)
    with_fal = Repetitive(q_side=0.05, q_centre=0.9, fal=(0.6, 0.4))
    assert design(loop, with_fal).margins.contraction == pytest.approx(1.011, abs=0.002)


def test_five_taps_of_q_are_their_fourier_sum_and_may_not_exceed_1_anywhere(evenspin):
    rc = Repetitive(q_side=0.2, q_centre=0.7, q_side2=-0.05)
    f_hz = frequencies(TS)
    taps, n = np.array([-0.05, 0.2, 0.7, 0.2, -0.05]), np.arange(-2, 3)

    assert rc.q(f_hz, TS) == pytest.approx((taps @ np.exp(2j * np.pi * np.outer(n, f_hz * TS))).real, abs=1e-12)
    assert rc.q_peak == pytest.approx(1.0, abs=1e-12)
    # 0.75 at zero frequency, 0.35 at Nyquist; between, where cos w = 1 / 6, more than both
    bent = Repetitive(q_side=0.1, q_centre=0.85, q_side2=-0.15)
    assert bent.q_peak == pytest.approx(0.85 + 0.3 + 0.1**2 / (4 * 0.15), abs=1e-12)
    said = evenspin("design", "rc", "--q-side", "0.1", "--q-centre", "0.85", "--q-side2", "-0.15")
    assert said.status == 2 and "|Q| <= 1 at every frequency, here up to 1.167" in said.err


def test_the_lead_of_the_paper_is_recommended(loop):
    assert design(loop, Repetitive()).recommended_lead == 5


def test_fal_costs_its_largest_gain(loop):
    plain, fal = design(loop, Repetitive()), design(loop, Repetitive(fal=(0.6, 0.4)))

    assert fal.lambda_max == pytest.approx(1.4427, abs=1e-4)
    assert fal.margins.bound == plain.margins.bound
    assert design(loop, Repetitive(gain=1.2)).stable
    assert not design(loop, Repetitive(gain=1.2, fal=(0.6, 0.4))).stable


def test_the_bound_is_where_the_condition_is_met_exactly(loop):
    f_hz = frequencies(TS)
    rc = Repetitive()
    ahead = loop.closed(f_hz) * np.exp(2j * np.pi * f_hz * TS * 5)
    q = rc.q(f_hz, TS)
    bound = design(loop, rc).margins.bound

    below, above = (np.abs(q * (1.0 - k * ahead)).max() for k in (0.999 * bound, 1.001 * bound))

    assert below < 1.0 < above
    assert gain_bound(np.array([1.0 + 0j]), np.array([1.0])) == pytest.approx([2.0])


@pytest.mark.parametrize("delay", [0.0, 0.15, 1.0, 1.4, 2.0])
def test_the_plant_is_the_step_response_of_a_simulation(loop, delay):
    """A held input, delayed, through the continuous plant, sampled; then the z-transform of its impulse response."""
    w, b, j = loop.current_bandwidth_rad_s, 0.05, loop.inertia_kgm2  # more friction, so that the answer ends
    damped = SpeedLoop(0.0368, 0.92, 4.0, TS, loop.torque_per_a_nm, j, b, w, delay * TS)
    system = signal.TransferFunction([4.0 * loop.torque_per_a_nm * w], np.polymul([1.0, w], [j, b]))
    t_s = np.arange(0, 0.2, TS)
    _, step = signal.step(system, T=np.linspace(0, 0.2, 200_001))
    at = lambda t: np.interp(t - delay * TS, np.linspace(0, 0.2, 200_001), step, left=0.0)  # noqa: E731
    pulse = at(t_s) - at(t_s - TS)
    f_hz = np.array([3.0, 20.0, 80.0, 300.0])

    expected = np.exp(-2j * np.pi * np.outer(f_hz, t_s)) @ pulse

    assert damped.plant(f_hz) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("change", [{"inertia_kgm2": 0.0}, {"kp_a_per_unit": float("nan")}, {"delay_s": -1.0}])
def test_a_loop_that_cannot_be_is_refused(loop, change):
    from dataclasses import replace

    with pytest.raises(InputError, match=next(iter(change))):
        replace(loop, **change)


def test_a_period_shorter_than_the_lead_is_refused():
    with pytest.raises(InputError, match="at least lead"):
        gain_db(Repetitive(), 6.0, np.array([20.0]), TS)
