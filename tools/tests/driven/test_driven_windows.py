"""Modulating functions: the derivatives are on the bump, and what comes out is exact where it can be known by hand."""

import numpy as np
import pytest
from evenspin.weakform.windows import Bump, Windows

PERIOD_S = 5e-4


def test_a_parabola_has_its_own_value_slope_and_curvature_in_every_window():
    t = PERIOD_S * np.arange(400)
    signal = 1e4 + 30.0 * t - 700.0 * t**2
    windows = Windows.over(400, Bump.of(12e-3, PERIOD_S))
    at = t[windows.centre]
    # The bump is even: the mean of a parabola is its value at the centre and half its curvature times a second moment.
    u = PERIOD_S * np.arange(-windows.bump.half, windows.bump.half + 1)
    second = float(np.sum(windows.bump.value * u**2))
    # 1e4 with 16 digits over weights of 1e4 and 1e8 in all.
    np.testing.assert_allclose(windows.slope(signal), 30.0 - 1400.0 * at, atol=1e-6)
    np.testing.assert_allclose(windows.curve(signal), -1400.0, rtol=1e-6)
    np.testing.assert_allclose(windows.value(signal), 1e4 + 30.0 * at - 700.0 * (at**2 + second), rtol=1e-12)


@pytest.mark.parametrize("hz", [5.0, 20.0, 60.0])
def test_a_line_is_damped_alike_in_the_value_and_in_its_derivatives(hz):
    w = 2.0 * np.pi * hz
    t = PERIOD_S * np.arange(4000)
    windows = Windows.over(4000, Bump.of(12e-3, PERIOD_S))
    value, slope, curve = windows.value(np.sin(w * t)), windows.slope(-np.cos(w * t)), windows.curve(-np.sin(w * t))
    passed = float(windows.bump.transform(np.array([w]))[0])
    # The table of the transform is linear between 400 frequencies.
    np.testing.assert_allclose(value, passed * np.sin(w * t[windows.centre]), atol=2e-3)
    # 47 rows stand for the integral: a thousandth of the line.
    np.testing.assert_allclose(slope / w, value, atol=1e-3)
    np.testing.assert_allclose(curve / w**2, value, atol=1e-3)


def test_a_window_with_a_row_that_is_not_good_is_left_out():
    good = np.ones(300, dtype=bool)
    good[150] = False
    windows = Windows.over(300, Bump.of(12e-3, PERIOD_S))
    used = windows.where(windows.all_of(good))
    reach = windows.bump.half
    assert not np.any(np.abs(used.centre[used.used] - 150) <= reach)
    assert len(used.value(np.ones(300))) == np.count_nonzero(used.used) < len(windows.centre)
