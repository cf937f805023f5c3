"""Coulomb friction as a hypothesis: what it is at standstill is a form that is fitted, but not part of the answer."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from evenspin.effects import Scale, hypotheses
from evenspin.gap.candidate import Model
from evenspin.gap.evidence import Effects
from evenspin.gap.fitting import Fitter
from evenspin.gap.intervals import reported_parameters
from evenspin.gap.screening import probe_points

MOTOR = {"pole_pairs": 4, "rated_current_a": 5.0, "rated_torque_nm": 1.0, "slots": 12}


@pytest.fixture
def friction():
    return hypotheses(Scale.of(MOTOR, 4000.0))["coulomb_friction"]


@pytest.fixture
def simulated(monkeypatch: pytest.MonkeyPatch) -> list[Effects]:
    """What a fitter asks the simulator for; the features are the torque and the smooth speed themselves."""
    asked: list[Effects] = []

    def features(forward: Any, units: list[Effects], probes: int = 2) -> list[np.ndarray]:
        asked.extend(units)
        made = [u["coulomb_friction"] for u in units]
        return [np.array([[p["torque_nm"], p.get("smooth_rad_s", 0.0)]] * probes) for p in made]

    monkeypatch.setattr("evenspin.gap.fitting.model_features", features)
    return asked


def columns(friction, z: np.ndarray) -> np.ndarray:
    unused: Any = None
    fitter = Fitter(unused, {"coulomb_friction": friction}, np.zeros((2, 0)), unused)
    here = np.array([z[0], z[1]])
    return fitter.columns(Model({"coulomb_friction": z}, np.zeros(0), here, here, 0.0, here))


def test_only_the_torque_is_reported(friction):
    params = friction.to_params(np.array([0.05, 0.3, 0.0]))
    assert params == {"torque_nm": 0.05, "smooth_rad_s": 0.3}
    assert reported_parameters("coulomb_friction", params) == {"torque_nm": 0.05}


def test_without_friction_its_form_is_off_so_that_the_simulator_leaves_the_effect_out(friction):
    assert friction.to_params(np.array([0.0, 0.3, 1e-3])) == {"torque_nm": 0.0}


def test_the_forms_are_a_shaft_that_is_held_one_that_creeps_and_one_that_gives_way(friction):
    forms = []
    for variant in friction.variants:
        z = np.array([0.05, 0.0, 0.0])
        z[list(variant)] = list(variant.values())
        forms.append(set(friction.to_params(z)) - {"torque_nm"})
    assert forms == [set(), {"smooth_rad_s"}, {"presliding_rad"}]


def test_a_form_that_is_off_costs_no_simulation_and_one_that_is_on_moves(friction, simulated):
    held = columns(friction, np.array([0.05, 0.0, 0.0]))
    assert len(simulated) == 1
    assert held == pytest.approx(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))

    simulated.clear()
    creeping = columns(friction, np.array([0.05, 0.2, 0.0]))
    assert len(simulated) == 2
    assert creeping == pytest.approx(np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))


def test_a_screening_asks_for_the_torque_alone(friction):
    (point,) = probe_points(friction, np.array(friction.starts[0]))
    assert point[0] > 0.0 and not point[1:].any()


def test_the_size_of_a_friction_does_not_depend_on_its_form(friction):
    sizes = {friction.magnitude(np.array([0.05, s, x])) for s in (0.0, 1.0) for x in (0.0, 0.01)}
    assert len(sizes) == 1
