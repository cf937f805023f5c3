"""The blocks of the position drive against formulas written here a second time, in double precision."""

import math

import numpy as np
import pytest
from evenspin import blocks
from evenspin.blocks import BlockError
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

NUMERICS = ("float", "fixed")
COULOMB, STATIC, V_S, SHAPE = 0.387, 0.457, 0.551, 1.957  # printed in the paper
P_ROW, INERTIA, RHO, SIGMA = (1.4977e-5, 2.03552e-2, 3.03823e-3), 0.780e-2, 0.15, 0.02


def friction(v: float) -> float:
    rise = (STATIC - COULOMB) * math.exp(-((abs(v) / V_S) ** SHAPE))
    return math.copysign(COULOMB + rise, v) if v else 0.0


@pytest.mark.parametrize("numeric", NUMERICS)
@given(v=st.floats(-30.0, 30.0).filter(lambda v: abs(v) > 1e-6 or v == 0.0))
def test_stribeck_friction_is_the_formula(numeric, v):
    found = blocks.stribeck(v, COULOMB, STATIC, V_S, SHAPE, numeric=numeric)

    assert found == pytest.approx(friction(v), abs=2e-5)


def test_stribeck_friction_falls_from_static_to_coulomb():
    found = [blocks.stribeck(v, COULOMB, STATIC, V_S, SHAPE) for v in (1e-6, V_S, 20.0)]

    assert found == pytest.approx([STATIC, COULOMB + (STATIC - COULOMB) / math.e, COULOMB], abs=1e-6)
    assert blocks.stribeck(0.0, COULOMB, STATIC, V_S, SHAPE) == 0.0


@pytest.mark.parametrize(("change", "said"), [
    ({"static": 0.3}, "static = 0.3: must be at least coulomb"),
    ({"coulomb": -0.1}, "coulomb = -0.1: must be at least 0"),
    ({"v_s": 0.0}, "v_s = 0.0: must be above 0"),
    ({"shape": 11.0}, "shape = 11.0: must be within 0.1 .. 10"),
    ({"static": math.nan}, "static = nan: must be"),
])  # fmt: skip
def test_a_friction_that_cannot_be_is_refused(change, said):
    good = {"coulomb": COULOMB, "static": STATIC, "v_s": V_S, "shape": SHAPE}
    with pytest.raises(BlockError) as refused:
        blocks.stribeck(1.0, **(good | change))

    assert str(refused.value).startswith(said)


@pytest.mark.parametrize("numeric", NUMERICS)
@given(e=st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-1.0, 1.0)))
def test_the_robust_term_is_a_line_between_two_bounds(numeric, e):
    s = float(np.dot(P_ROW, e)) / INERTIA
    expected = -RHO * max(-1.0, min(1.0, s / SIGMA))

    assert blocks.rdc_robust_term(e, P_ROW, INERTIA, RHO, SIGMA, numeric=numeric) == pytest.approx(expected, abs=5e-6)


def test_the_integral_counts_in_the_robust_term():
    assert blocks.rdc_robust_term((0.5, 0.0, 0.0), (0.01, 0.0, 0.0), 1.0, 0.2, 0.02) == pytest.approx(-0.05, rel=1e-5)


@pytest.mark.parametrize(("change", "said"), [
    ({"inertia": -1e-3}, "inertia = -0.001: must be above 0"),
    ({"inertia": 0.0}, "inertia = 0.0: must be above 0"),
    ({"sigma": 0.0}, "sigma = 0.0: must be above 0"),
    ({"sigma": -0.02}, "sigma = -0.02: must be above 0"),
    ({"rho": -0.1}, "rho = -0.1: must be at least 0"),
    ({"p_row": (1.0, 2.0)}, "p_row = 2: must be three numbers"),
    ({"p_row": (math.inf, 0.0, 0.0)}, "p_row = inf: must be"),
])  # fmt: skip
def test_a_robust_term_that_cannot_be_is_refused(change, said):
    good = {"e": (0.0, 0.0, 0.0), "p_row": P_ROW, "inertia": INERTIA, "rho": RHO, "sigma": SIGMA}
    with pytest.raises(BlockError) as refused:
        blocks.rdc_robust_term(**(good | change))

    assert str(refused.value).startswith(said)


@pytest.mark.parametrize(("numeric", "within"), [("float", 1e-6), ("fixed", 2e-6)])
@pytest.mark.parametrize("speed", [0.5, 1.0472, -2.0944, 20.0])
def test_the_spatial_low_pass_is_the_bilinear_transform(numeric, within, speed):
    w = 60.0 * abs(speed)
    b, a = signal.bilinear([w * w], [1.0, math.sqrt(2.0) * w, w * w], fs=1e3)

    found = blocks.spatial_lowpass(60.0, speed, 1e-3, numeric=numeric)

    assert found["b"] == pytest.approx(list(b), abs=within)
    assert found["a"] == pytest.approx(list(a), abs=within)


def test_the_spatial_low_pass_stands_still_at_standstill():
    assert blocks.spatial_lowpass(60.0, 0.0, 1e-3) == {"b": [0.0, 0.0, 0.0], "a": [1.0, -2.0, 1.0]}


@pytest.mark.parametrize(("change", "said"), [
    ({"cutoff_per_rad": 0.0}, "cutoff_per_rad = 0.0: must be above 0"),
    ({"ts": -1e-3}, "ts = -0.001: must be above 0"),
    ({"speed": 100.0}, "speed = 100.0: must be within -33.3333 .. 33.3333"),
    ({"speed": math.nan}, "speed = nan: must be within -33.3333 .. 33.3333"),
])  # fmt: skip
def test_a_low_pass_that_cannot_be_is_refused(change, said):
    with pytest.raises(BlockError) as refused:
        blocks.spatial_lowpass(**({"cutoff_per_rad": 60.0, "speed": 1.0, "ts": 1e-3} | change))

    assert str(refused.value).startswith(said)


@pytest.mark.parametrize("numeric", NUMERICS)
@pytest.mark.parametrize(("target", "speed", "accel", "smooth"), [(10.0, 2.0, 20.0, 1), (-0.05, 3.0, 40.0, 16)])
def test_a_motion_ends_on_its_target_within_its_limits(numeric, target, speed, accel, smooth):
    profile = blocks.MotionProfile(speed, accel, smooth, numeric=numeric)
    points = []
    while not points or not points[-1].done:
        points.append(profile.step(target))
        assert len(points) < 10_000
    position = np.array([0.0] + [point.position_rad for point in points])
    v, a = np.diff(position) / 1e-3, np.diff(position, 2) / 1e-6

    reach = min(speed, math.sqrt(accel * abs(target)))  # a short way does not reach the speed
    needed = abs(target) / reach + reach / accel
    assert position[-1] == pytest.approx(target, abs=2e-9)
    rounded = accel * smooth * 1e-3 / 4.0 if reach < speed else 0.0  # the mean over a peak is below the peak
    assert 0.97 * (reach - rounded) <= np.abs(v).max() <= speed * (1 + 1e-6)
    assert np.abs(a).max() <= accel * (1 + 1e-3)
    # what is left of the last full step is crept over with one acceleration step: up to reach / accel
    assert needed - 4e-3 <= len(points) * 1e-3 <= needed + reach / accel + smooth * 1e-3
    assert [point.speed_rad_s for point in points] == pytest.approx(list(v), abs=1e-4)
    assert [point.acceleration_rad_s2 for point in points[1:]] == pytest.approx(list(a), abs=1e-2)
    if smooth > 1:  # twice, because this short motion turns from accelerating to braking at once
        assert np.abs(np.diff(position, 3)).max() / 1e-9 <= 2.0 * accel / (smooth * 1e-3) * (1 + 1e-2)


def test_a_profile_starts_where_it_was_put():
    profile = blocks.MotionProfile(1.0, 0.0)
    profile.reset(5.0)

    point = profile.step(5.1)

    assert (point.position_rad, point.speed_rad_s) == pytest.approx((5.001, 1.0), abs=1e-6)
    assert (point.acceleration_rad_s2, point.done) == (0.0, False)


@pytest.mark.parametrize(("change", "said"), [
    ({"speed_rad_s": 0.0}, "speed_rad_s = 0.0: must be above 0"),
    ({"accel_rad_s2": -1.0}, "accel_rad_s2 = -1.0: must be at least 0"),
    ({"smooth_samples": 65}, "smooth_samples = 65: must be a whole number within 1 .. 64"),
    ({"ts_s": 0.0}, "ts_s = 0.0: must be above 0"),
])  # fmt: skip
def test_a_profile_that_cannot_be_is_refused(change, said):
    with pytest.raises(BlockError) as refused:
        blocks.MotionProfile(**({"speed_rad_s": 1.0, "accel_rad_s2": 20.0} | change))

    assert str(refused.value).startswith(said)


@pytest.mark.parametrize("target", [math.nan, math.inf, 1e12])
def test_a_target_nowhere_is_refused(target):
    with pytest.raises(BlockError, match="target_rad"):
        blocks.MotionProfile(1.0, 20.0).step(target)
