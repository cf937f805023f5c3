"""What is named although something is left: the size of an effect has to agree over the log."""

from __future__ import annotations

import math

import numpy as np
import pytest
from evenspin.gap.partial import size_in_part, spread_of_sizes, validated_shares
from evenspin.gap.thresholds_effects import PARTIAL_SPREAD
from numpy.typing import NDArray

Array = NDArray[np.float64]
SPEEDS = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0)
FEATURES = 40


def parts_of(effect: Array, residual: Array) -> list[tuple[float, float]]:
    """One part a speed: a column of the effect, its size free."""
    columns = np.split(effect, len(SPEEDS))
    left = np.split(residual, len(SPEEDS))
    return [size_in_part(c[:, None], r, np.array([1e-9]), 0) for c, r in zip(columns, left, strict=True)]


@pytest.fixture
def noise() -> Array:
    return np.random.default_rng(3).normal(0.0, 1.0, len(SPEEDS) * FEATURES)


def at_speeds(law: list[float]) -> Array:
    """100 standard deviations at the largest value of the law, in every feature of that speed."""
    return np.repeat(np.array(law) * 100.0 / max(law), FEATURES)


def test_an_effect_of_the_right_size_has_one_size_over_the_log(noise: Array) -> None:
    effect = at_speeds(list(SPEEDS))
    assert spread_of_sizes(parts_of(effect, noise)) < 0.01


def test_an_effect_that_stands_for_a_fan_needs_another_size_at_each_speed(noise: Array) -> None:
    """By hand: w |w| fitted by w wants w / w0 of its size at each speed, w0 = sum w^4 / sum w^3 = 51.59 rad/s here, so
    that the root of the mean of (w / w0 - 1)^2 is 0.4616."""
    viscous = at_speeds(list(SPEEDS))
    fan = np.repeat([w * w for w in SPEEDS], FEATURES)
    fan *= float(viscous @ fan) / float(fan @ fan)
    spread = spread_of_sizes(parts_of(viscous, fan - viscous + noise))
    assert spread == pytest.approx(0.4616, rel=0.03)  # noise, and the weights of the parts
    assert spread > PARTIAL_SPREAD


def test_something_foreign_in_other_parts_does_not_speak_against_an_effect(noise: Array) -> None:
    effect = at_speeds([1.0, 1.0, 1.0, 1.0, 1.0, 0.0])
    foreign = np.zeros_like(effect)
    foreign[-FEATURES:] = 500.0
    assert spread_of_sizes(parts_of(effect, noise + foreign)) < 0.01


def test_something_foreign_that_varies_within_each_part_counts_as_noise(noise: Array) -> None:
    effect = at_speeds([1.0] * len(SPEEDS))
    foreign = 50.0 * np.sin(np.arange(len(effect)) * 2.0 * math.pi / 8.0)
    assert spread_of_sizes(parts_of(effect, noise + foreign)) < 0.2 * PARTIAL_SPREAD


def test_an_effect_that_no_part_knows_is_not_trusted(noise: Array) -> None:
    assert spread_of_sizes(parts_of(0.001 * at_speeds([1.0] * len(SPEEDS)), noise)) == math.inf
    assert spread_of_sizes([(0.0, 0.01), (0.0, 0.01)]) == math.inf


def test_a_share_is_what_an_effect_closes_of_the_squared_gap_that_no_fit_has_seen() -> None:
    gaps = {(): 2.0, ("cogging", "inertia"): 0.5, ("cogging",): 0.8, ("inertia",): 1.9}
    shares = validated_shares(("cogging", "inertia"), gaps.__getitem__)
    assert shares == {"cogging": pytest.approx((1.9**2 - 0.25) / 4.0), "inertia": pytest.approx((0.64 - 0.25) / 4.0)}
    unknown = validated_shares(("cogging",), lambda names: math.nan)
    assert math.isnan(unknown["cogging"])
