"""Which effects are simulated beside an explanation: signatures of the bare machine rule the others out."""

from __future__ import annotations

import numpy as np
from evenspin.effects import Scale, hypotheses
from evenspin.gap.acceptance import Acceptance
from evenspin.gap.candidate import Candidate
from evenspin.gap.thresholds_effects import GAIN_BEYOND_TOLERANCE, GAIN_MIN

MOTOR = {"rated_current_a": 5.0, "rated_torque_nm": 1.0, "pole_pairs": 4, "slots": 12}
RULES = Acceptance(hypotheses(Scale.of(MOTOR, 4000.0)))


def promising(**gains: float) -> list[Candidate]:
    return [Candidate({name: np.zeros(1)}, gain, frozenset({name})) for name, gain in gains.items()]


def test_once_little_is_left_an_effect_is_simulated_from_a_fifth_of_the_gain_that_counts() -> None:
    """0.3 times 0.7 of it. What is a tolerance counts from less."""
    some = promising(cogging=0.2 * GAIN_MIN, dead_time=0.22 * GAIN_MIN, inertia=0.22 * GAIN_BEYOND_TOLERANCE)
    assert RULES.worth_simulating(some, unexplained=False) == {"dead_time", "inertia"}


def test_while_much_is_left_an_effect_is_simulated_from_two_per_cent_of_the_best() -> None:
    some = promising(cogging=1e5, dead_time=2.1e3, inertia=1.9e3)
    assert RULES.worth_simulating(some, unexplained=True) == {"cogging", "dead_time"}


def test_without_candidates_nothing_is_simulated() -> None:
    assert RULES.worth_simulating([], unexplained=True) == frozenset()
