"""The dead time as a hypothesis: how its loss goes through zero current is fitted, but is not part of the answer."""

from __future__ import annotations

import numpy as np
import pytest
from evenspin.effects import Scale, hypotheses
from evenspin.gap.intervals import reported_parameters

MOTOR = {"pole_pairs": 4, "rated_current_a": 5.0, "rated_torque_nm": 1.0, "slots": 12}


@pytest.fixture
def dead_time():
    return hypotheses(Scale.of(MOTOR, 4000.0))["dead_time"]


def test_every_inverter_may_lose_in_its_own_way_near_zero_current(dead_time):
    params = dead_time.to_params(np.array([2e-6, 0.1, 1.0]))
    assert params == {"dead_time_s": 2e-6, "soft_a": 0.1, "by_edges": 1.0}
    assert reported_parameters("dead_time", params) == {"dead_time_s": 2e-6}


def test_without_a_dead_time_its_shape_is_off_so_that_the_simulator_leaves_the_effect_out(dead_time):
    assert dead_time.to_params(np.array([0.0, 0.1, 0.5])) == {"dead_time_s": 0.0}


def test_a_soft_transition_cannot_grow_into_a_resistance(dead_time):
    wide = dead_time.clip(np.array([2e-6, 100.0, 2.0]))
    # beyond three times its width the loss no longer grows with the current: far below the rated one
    assert 3.0 * dead_time.to_params(wide)["soft_a"] < 0.2 * MOTOR["rated_current_a"]
    assert dead_time.to_params(wide)["by_edges"] == 1.0


def test_the_size_of_a_dead_time_does_not_depend_on_its_shape(dead_time):
    sizes = {dead_time.magnitude(np.array([2e-6, soft, edges])) for soft in (0.0, 0.2) for edges in (0.0, 1.0)}
    assert len(sizes) == 1
