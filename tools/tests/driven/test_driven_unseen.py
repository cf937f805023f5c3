"""What a term lowers on stretches that no fit saw, and that a cause of unknown kind has to."""

import numpy as np
import pytest
from evenspin.weakform.unseen import foreign_is_seen, shaft_is_seen

RNG = np.random.default_rng(8)
NOISE = [RNG.standard_normal(900) for _ in range(4)]  # two torques, two voltages
ROWS = [np.arange(900) % 3 == 2] * 4


def left(*times: float) -> list[list[np.ndarray]]:
    return [[factor * noise for factor, noise in zip(times, NOISE, strict=True)]]


@pytest.mark.parametrize(
    ("with_it", "seen"),
    [
        ((0.2, 1.0, 1.0, 1.0), True),  # a fan: the balance of torque closes
        ((1.0, 1.0, 1.0, 0.67), True),  # a resistance that drifts, in the q axis alone
        ((1.0, 1.0, 0.986, 0.99), False),
        ((1.58, 1.05, 1.03, 1.11), False),  # better only where it was fitted
    ],
)
def test_a_cause_of_unknown_kind_lowers_an_equation_on_unseen_stretches(with_it, seen):
    found, plain = left(*with_it), left(1.0, 1.0, 1.0, 1.0)
    for each, other in zip(found[0], plain[0], strict=True):
        each[~ROWS[0]] = 0.5 * other[~ROWS[0]]  # on the others everything fits
    assert foreign_is_seen([ROWS], found, plain) == seen


def test_a_log_without_voltages_has_no_say_about_them():
    found = [left(1.0, 1.0, 1.0, 0.5)[0], left(1.0, 1.0, 1.0, 1.0)[0][:2]]
    plain = [left(1.0, 1.0, 1.0, 1.0)[0], left(1.0, 1.0, 1.0, 1.0)[0][:2]]
    assert foreign_is_seen([ROWS, ROWS[:2]], found, plain)
    assert not foreign_is_seen([ROWS, ROWS[:2]], plain, plain)


def test_where_every_stretch_was_fitted_nothing_speaks_against_a_cause():
    none = [np.zeros(900, dtype=bool)] * 4
    assert foreign_is_seen([none], left(1.0, 1.0, 1.0, 1.0), left(1.0, 1.0, 1.0, 1.0))


@pytest.mark.parametrize(("twisting", "seen"), [(0.85, True), (0.95, False)])
def test_a_shaft_that_twists_lowers_the_torque_by_a_tenth(twisting, seen):
    parts = left(twisting, 1.0, 1.0, 1.0)
    assert shaft_is_seen([ROWS], parts, left(1.0, 1.0, 1.0, 1.0), left(2.0, 1.0, 1.0, 1.0)) == seen
