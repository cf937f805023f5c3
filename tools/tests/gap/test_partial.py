"""What is named although something is left: the size of an effect has to agree over the log."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evenspin.gap.partial import partial, size_in_part, spread_of_sizes, validated_shares
from evenspin.gap.thresholds_effects import PARTIAL_GAIN, PARTIAL_SHARE, PARTIAL_SPREAD
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
    that |w / w0 - 1| is 0.03, 0.16, 0.22, 0.42, 0.612 and 0.81: four of six speeds are less than two thirds of them."""
    viscous = at_speeds(list(SPEEDS))
    fan = np.repeat([w * w for w in SPEEDS], FEATURES)
    fan *= float(viscous @ fan) / float(fan @ fan)
    spread = spread_of_sizes(parts_of(viscous, fan - viscous + noise))
    assert spread == pytest.approx(0.612, rel=0.03)  # noise, and the weights of the parts
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


NAMES = ("cogging", "inertia", "dead_time")
MANY = 10.0 * PARTIAL_GAIN


def names_that_stand(
    spread: Mapping[str, float],
    gain: Mapping[str, float],
    closed: Mapping[str, float],
    together: float = 0.0,
) -> tuple[str, ...]:
    """`closed`: of the squared gap of 4, what each effect closes by itself; `together`: what any two share."""
    model: Any = SimpleNamespace(z=dict.fromkeys(NAMES, np.zeros(1)))

    def gap_of(names: tuple[str, ...]) -> float:
        share = sum(closed[name] for name in names) - together * max(0, len(names) - 1)
        return math.sqrt(4.0 * (1.0 - share))

    return partial(model, gain, spread, gap_of)


def test_names_that_agree_over_the_log_stand_strongest_first() -> None:
    gain = {"cogging": MANY, "inertia": 3.0 * MANY, "dead_time": 2.0 * MANY}
    found = names_that_stand(dict.fromkeys(NAMES, 0.1), gain, dict.fromkeys(NAMES, 0.3))
    assert found == ("inertia", "dead_time", "cogging")


def test_a_name_of_another_size_in_each_part_does_not_stand_and_the_others_do() -> None:
    spread = {"cogging": 1.01 * PARTIAL_SPREAD, "inertia": 0.99 * PARTIAL_SPREAD, "dead_time": math.inf}
    found = names_that_stand(spread, dict.fromkeys(NAMES, MANY), dict.fromkeys(NAMES, 0.3))
    assert found == ("inertia",)


def test_a_name_that_takes_little_off_the_cost_does_not_stand_beside_something_foreign() -> None:
    gain = {"cogging": 0.99 * PARTIAL_GAIN, "inertia": 1.01 * PARTIAL_GAIN}  # and a dead time that has none
    found = names_that_stand(dict.fromkeys(NAMES, 0.1), gain, dict.fromkeys(NAMES, 0.3))
    assert found == ("inertia",)


def test_a_name_that_closes_nothing_on_unseen_records_does_not_stand() -> None:
    closed = {"cogging": 0.5 * PARTIAL_SHARE, "inertia": 0.6, "dead_time": -0.1}
    found = names_that_stand(dict.fromkeys(NAMES, 0.1), dict.fromkeys(NAMES, MANY), closed)
    assert found == ("inertia",)


def test_of_two_names_that_close_the_same_the_weaker_goes_and_the_other_stands() -> None:
    """Each closes .31 or .30 by itself, and both together no more: neither is missed while the other is there."""
    closed = {"cogging": 0.31, "inertia": 0.3, "dead_time": 0.0}
    gain = {"cogging": MANY, "inertia": MANY}
    found = names_that_stand(dict.fromkeys(NAMES, 0.1), gain, closed, together=0.3)
    assert found == ("cogging",)


def test_without_a_validation_record_nothing_is_named_beside_unknown() -> None:
    found = names_that_stand(dict.fromkeys(NAMES, 0.1), dict.fromkeys(NAMES, MANY), dict.fromkeys(NAMES, math.nan))
    assert found == ()


def test_what_noise_explains_of_the_differences_does_not_count() -> None:
    """Sizes off by their own standard deviation: nothing is beyond noise."""
    assert spread_of_sizes([(0.2, 0.2), (-0.2, 0.2), (0.2, 0.2), (-0.2, 0.2)]) == 0.0


def test_a_few_parts_with_something_else_do_not_speak_against_an_effect() -> None:
    """A quarter of the parts resounds with something foreign; where half of them do, nothing agrees."""
    right, foreign = [(0.01, 1e-6), (-0.02, 1e-6), (0.03, 1e-6)], [(10.0, 1e-6)]
    assert spread_of_sizes(right + foreign) == pytest.approx(0.03, rel=1e-6)
    assert spread_of_sizes(right[:1] + foreign) == math.inf  # fewer than three parts know nothing
    assert spread_of_sizes(right[:2] + 2 * foreign) == pytest.approx(10.0, rel=1e-6)


def test_a_part_that_fits_badly_knows_its_size_less_well(noise: Array) -> None:
    """By hand: a constant of 1 in 240 rows under noise of 5 standard deviations has a deviation of 5 / sqrt(240)."""
    ones = np.ones((len(noise), 1))
    _, sigma = size_in_part(ones, 5.0 * noise, np.array([1e-9]), 0)
    assert sigma == pytest.approx(5.0 / math.sqrt(len(noise)), rel=0.2)  # robust weights count the ends a little less
