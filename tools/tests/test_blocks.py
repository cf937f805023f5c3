"""The blocks of the firmware against independent double-precision formulas."""

import math

import numpy as np
import pytest
from evenspin import blocks
from evenspin.blocks import BlockError
from hypothesis import given
from hypothesis import strategies as st

NUMERICS = ("float", "fixed")
LAMBDA_MAX = 0.4 ** (0.6 - 1.0)  # 1.4427, see docs/reference/guo2024.md

small = st.floats(-20.0, 20.0, allow_nan=False)


def test_small_errors_have_the_largest_gain_of_fal():
    assert LAMBDA_MAX == pytest.approx(1.4427, abs=5e-5)
    assert blocks.lambda_(0.0, 0.6, 0.4) == pytest.approx(LAMBDA_MAX, rel=2e-6)


@pytest.mark.parametrize("numeric", NUMERICS)
@given(e=small)
def test_fal_is_the_power_outside_and_a_line_inside(numeric, e):
    expected = e * LAMBDA_MAX if abs(e) <= 0.4 else math.copysign(abs(e) ** 0.6, e)

    assert blocks.fal(e, 0.6, 0.4, numeric=numeric) == pytest.approx(expected, rel=2e-4, abs=2e-6)


@given(e=small)
def test_fal_is_odd(e):
    assert blocks.fal(-e, 0.6, 0.4) == -blocks.fal(e, 0.6, 0.4)


def test_fal_has_no_step_at_its_knee():
    below, above = (blocks.fal(0.4 * (1.0 + step), 0.6, 0.4) for step in (-1e-5, 1e-5))

    assert 0.0 < above - below < 2e-5


@given(e=small.filter(lambda e: abs(e) > 1e-3))
def test_lambda_is_fal_over_its_argument(e):
    assert blocks.lambda_(e, 0.6, 0.4) == pytest.approx(blocks.fal(e, 0.6, 0.4) / e, rel=1e-5)


@pytest.mark.parametrize("order", [1, 2, 3])
@given(frac=st.floats(0.0, 0.999))
def test_lagrange_delays_every_polynomial_of_its_order_exactly(order, frac):
    """sum A_k x(-k) = x(-frac) for x = 1, t, .. t^order defines the coefficients: no formula needed."""
    nodes = np.arange(order + 1.0)
    expected = np.linalg.solve(np.vander(nodes, increasing=True).T, frac ** np.arange(order + 1.0))

    assert blocks.lagrange(order, frac) == pytest.approx(expected, abs=2e-6)


def test_lagrange_of_a_whole_delay_takes_one_sample():
    assert blocks.lagrange(3, 0.0) == [1.0, 0.0, 0.0, 0.0]


# ---- repetitive controller -------------------------------------------------------------------------------------------


def recursion(errors, period, gain, lead, q, order, fal=None, fal_at="input"):
    """y(k) = Q z^-N [y(k) + k_rc z^m f(e(k))], literally, in double precision. Before the first sample all is zero."""
    side, centre = q
    whole = math.floor(period)
    nodes = np.arange(order + 1.0)
    taps = np.linalg.solve(np.vander(nodes, increasing=True).T, (period - whole) ** nodes) if order else [1.0]

    def f(e):
        alpha, delta = fal
        return e / delta ** (1.0 - alpha) if abs(e) <= delta else math.copysign(abs(e) ** alpha, e)

    learned = [f(e) for e in errors] if fal and fal_at == "input" else list(errors)
    y, out = {}, []

    def remembered(k):
        ahead = k + lead
        return y.get(k, 0.0) + (gain * learned[ahead] if 0 <= ahead < len(learned) else 0.0)

    for k, e in enumerate(errors):
        y[k] = sum(
            tap * (side * remembered(at + 1) + centre * remembered(at) + side * remembered(at - 1))
            for tap, at in ((tap, k - whole - i) for i, tap in enumerate(taps))
        )
        factor = 1.0
        if fal and fal_at == "output":
            factor = f(e) / e if e else fal[1] ** (fal[0] - 1.0)
        out.append(factor * y[k])
    return np.array(out)


@pytest.fixture(scope="module")
def errors():
    k = np.arange(500)
    noise = np.random.default_rng(7).normal(size=500)
    return 4.0 * np.sin(2 * np.pi * k / 58.82) + 2.0 * np.sin(4 * np.pi * k / 58.82 + 1.0) + noise


@pytest.mark.parametrize("numeric", NUMERICS)
@pytest.mark.parametrize("fal_at", [None, "input", "output"])
@pytest.mark.parametrize(
    ("period", "lead", "order"), [(58.82, 5, 2), (48.86, 5, 3), (100.0, 5, 2), (12.5, 5, 2), (33.3, 0, 1)]
)
def test_the_controller_is_its_recursion(errors, period, lead, order, fal_at, numeric):
    fal = (0.6, 0.4) if fal_at else None
    expected = recursion(errors, period, 0.6, lead, (0.45, 0.10), order, fal, fal_at)
    controller = blocks.RepetitiveController(0.6, lead, (0.45, 0.10), order, fal, fal_at or "input", numeric=numeric)

    got = np.array([controller.step(e, period) for e in errors])

    assert np.abs(got - expected).max() < 2e-4 * np.abs(expected).max()


@pytest.mark.parametrize(("truncate", "whole"), [(True, 58), (False, 59)])
def test_crc_cuts_or_rounds_its_period(errors, truncate, whole):
    expected = recursion(errors, whole, 0.6, 5, (0.45, 0.10), 0)
    controller = blocks.RepetitiveController(0.6, 5, order=0, truncate=truncate)

    got = np.array([controller.step(e, 58.82) for e in errors])

    assert np.abs(got - expected).max() < 2e-4 * np.abs(expected).max()


def test_a_reset_controller_is_a_new_one(errors):
    controller = blocks.RepetitiveController(0.6, 5)
    first = [controller.step(e, 58.82) for e in errors]

    controller.reset()

    assert [controller.step(e, 58.82) for e in errors] == first


@pytest.mark.parametrize("numeric", NUMERICS)
@given(poison=st.sampled_from([math.nan, math.inf, -math.inf]), at=st.integers(0, 40))
def test_no_input_makes_the_output_infinite(numeric, poison, at):
    controller = blocks.RepetitiveController(0.6, 5, fal=(0.6, 0.4), limit=50.0, numeric=numeric)

    got = [controller.step(poison if k == at else 3.0, 20.3) for k in range(100)]

    assert all(abs(u) <= 50.0 * LAMBDA_MAX for u in got)
    assert controller.rejected == 1


def test_the_correction_stays_within_its_limit():
    controller = blocks.RepetitiveController(1.0, 5, limit=5.0)

    assert max(controller.step(100.0, 30.0) for _ in range(500)) == pytest.approx(5.0)


def test_learning_rests_after_a_large_error():
    quiet = blocks.RepetitiveController(0.6, 5, freeze_above=10.0, freeze_samples=30)
    loud = blocks.RepetitiveController(0.6, 5, freeze_above=10.0, freeze_samples=30)

    first = [quiet.step(5.0, 20.0) for _ in range(60)][-1]
    second = [loud.step(20.0, 20.0) for _ in range(60)][-1]

    assert first > 1.0
    assert second == 0.0


def learned_then_faster(memory: str) -> tuple[np.ndarray, np.ndarray]:
    """In 40 turns of 40 samples an error tied to the angle is learned; then a turn takes 25 and there is no error."""
    controller = blocks.RepetitiveController(0.6, 5, memory=memory, capacity=256)
    theta = 0.0
    for _ in range(40 * 40):
        controller.step(math.cos(theta), 40.0, theta)
        theta += 2 * math.pi / 40
    out = []
    angles = theta + 2 * math.pi / 25 * np.arange(18)  # less than a turn: nothing learned at the new speed comes back
    for angle in angles:
        out.append(controller.step(0.0, 25.0, angle))
    return np.array(out), angles


def rest_of_a_wave(values: np.ndarray, phase: np.ndarray) -> float:
    """What is left of the values beside a cosine of this phase, relative to it."""
    wave = np.column_stack((np.cos(phase), np.sin(phase)))
    fitted = np.linalg.lstsq(wave, values, rcond=None)[0]
    return np.abs(values - wave @ fitted).max() / np.hypot(*fitted)


def test_a_cleared_memory_forgets_when_the_period_changes():
    out, _ = learned_then_faster("clear")

    assert np.abs(out).max() == 0.0


def test_a_kept_memory_plays_the_old_samples_at_their_own_rate():
    out, angles = learned_then_faster("keep")

    assert np.abs(out).max() > 5.0
    assert rest_of_a_wave(out, 2 * np.pi / 40 * np.arange(len(out))) < 0.05
    assert rest_of_a_wave(out, angles) > 0.2


def test_an_angle_memory_is_right_at_the_new_speed():
    out, angles = learned_then_faster("angle")

    assert np.abs(out).max() > 5.0
    assert rest_of_a_wave(out, angles) < 0.1
    assert rest_of_a_wave(out, 2 * np.pi / 40 * np.arange(len(out))) > 0.2


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"gain": -1.0}, "gain"),
        ({"gain": math.nan}, "gain"),
        ({"lead": 99}, "lead"),
        ({"order": 4}, "order"),
        ({"q": (0.9, 0.1)}, "q_centre"),
        ({"fal": (0.0, 0.4)}, "alpha"),
        ({"fal": (0.6, -1.0)}, "delta"),
        ({"capacity": 3}, "capacity"),
        ({"limit": 0.0}, "limit"),
        ({"memory": "forever"}, "memory"),
        ({"fal": (0.6, 0.4), "fal_at": "middle"}, "fal_at"),
        ({"lead": 2.5}, "lead"),
        ({"capacity": math.nan}, "capacity"),
    ],
)
def test_a_wrong_parameter_is_refused_by_name(change, field):
    with pytest.raises(ValueError, match=field) as refusal:
        blocks.RepetitiveController(**({"gain": 0.6, "lead": 5} | change))

    assert isinstance(refusal.value, BlockError)
    assert refusal.value.field == field
    assert refusal.value.limit


@pytest.mark.parametrize(
    "call",
    [
        lambda: blocks.fal(1.0, 0.0, 0.4),
        lambda: blocks.fal(1.0, 0.6, 0.0),
        lambda: blocks.lagrange(4, 0.5),
        lambda: blocks.lagrange(2, -0.5),
        lambda: blocks.Pi(-1.0, 0.0, -1.0, 1.0),
        lambda: blocks.Pi(1.0, 0.0, 1.0, -1.0),
        lambda: blocks.Pll(-1.0, 1.0, 1e-4),
        lambda: blocks.MtSpeed(0, 1e6, 1e-3),
    ],
)
def test_every_block_refuses_nonsense(call):
    with pytest.raises(BlockError):
        call()


def test_an_unknown_numeric_is_refused():
    with pytest.raises(Exception, match="float or fixed"):
        blocks.fal(1.0, 0.6, 0.4, numeric="double")


# ---- frames, modulation, loops ---------------------------------------------------------------------------------------


@given(amplitude=st.floats(0.0, 20.0), angle=st.floats(-10.0, 10.0), turn=st.floats(-10.0, 10.0))
def test_three_phases_come_to_dq_and_back(amplitude, angle, turn):
    phases = [amplitude * math.cos(angle - k * 2 * math.pi / 3) for k in range(3)]

    vector = blocks.clarke(*phases)
    d, q = blocks.park(*vector, turn)

    assert vector == pytest.approx((amplitude * math.cos(angle), amplitude * math.sin(angle)), abs=2e-5)
    assert (d, q) == pytest.approx((amplitude * math.cos(angle - turn), amplitude * math.sin(angle - turn)), abs=5e-5)
    assert blocks.inverse_clarke(*blocks.inverse_park(d, q, turn)) == pytest.approx(phases, abs=1e-4)


@given(d=small, q=small, limit=st.floats(0.1, 30.0))
def test_a_vector_is_shortened_in_its_own_direction(d, q, limit):
    length = math.hypot(d, q)
    scale = min(1.0, limit / length) if length else 1.0

    assert blocks.vector_limit(d, q, limit) == pytest.approx((d * scale, q * scale), abs=1e-4)


@given(length=st.floats(0.0, 13.8), angle=st.floats(0.0, 6.28))
def test_duties_make_the_voltage_that_was_asked_for(length, angle):
    """Line-to-line voltages do not depend on how the zero vectors are shared."""
    a, b, c = blocks.svm(length * math.cos(angle), length * math.sin(angle), 24.0)

    assert all(0.0 <= duty <= 1.0 for duty in (a, b, c))
    assert 24.0 * (a - b) == pytest.approx(math.sqrt(3) * length * math.cos(angle + math.pi / 6), abs=1e-3)
    assert 24.0 * (b - c) == pytest.approx(math.sqrt(3) * length * math.sin(angle), abs=1e-3)


def test_the_pi_holds_its_integrator_while_limited():
    pi = blocks.Pi(1.0, 0.5, -2.0, 2.0)

    assert pi.output(1.0) == pytest.approx(1.0)
    pi.commit(1.0)
    assert pi.output(1.0) == pytest.approx(1.5)
    pi.commit(1.2)  # the actuator gave less: nothing is learned
    assert pi.output(1.0) == pytest.approx(1.5)


def test_the_tracking_filter_follows_a_ramp_as_its_difference_equation():
    kp, ki, ts, speed = 754.0, 142122.0, 1e-4, 30.0
    pll = blocks.Pll(kp, ki, ts)
    pll.reset(0.0)
    w = theta = 0.0
    got, expected = [], []
    for k in range(400):
        angle = speed * ts * k
        e = math.remainder(angle - theta, 2 * math.pi)
        w += ki * e * ts
        theta += (w + kp * e) * ts
        expected.append(w)
        got.append(pll.step(angle))

    assert got == pytest.approx(expected, abs=0.02)
    assert got[-1] == pytest.approx(speed, rel=1e-3)


def test_counts_over_time_give_the_speed_without_a_count_of_ripple():
    """150 rpm, 4000 counts: a plain difference over 1 ms would be wrong by up to 15 rpm."""
    clock_hz, pitch, speed = 200e6, 2 * math.pi / 4000, 150 * math.pi / 30
    meter = blocks.MtSpeed(4000, clock_hz, 1e-3)
    got = []
    for k in range(1, 60):
        now_s = k * 1e-3
        count = math.floor(speed * now_s / pitch)
        got.append(meter.step(count, round(count * pitch / speed * clock_hz), round(now_s * clock_hz)))

    assert got[5:] == pytest.approx([speed] * len(got[5:]), rel=1e-3)
