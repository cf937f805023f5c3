"""Steps and forms of a fit, on costs that are known functions of the coordinates."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from evenspin.effects import Coordinate, Hypothesis, Scale, hypotheses
from evenspin.gap.candidate import Model
from evenspin.gap.fitting import STRETCH_MOST, STRETCH_SHARE, Fitter

NOTHING = np.zeros(0)
MOTOR = {"rated_current_a": 5.0, "rated_torque_nm": 1.0, "pole_pairs": 4, "slots": 12}
Cost = Callable[[np.ndarray], float]


class Known:
    """A fitter whose cost is given, and the points at which it was asked."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, cost: Cost, hypothesis: Hypothesis) -> None:
        self.asked: list[np.ndarray] = []
        self.name = hypothesis.name

        def model(fitter: Fitter, z: dict[str, np.ndarray]) -> Model:
            self.asked.append(z[self.name])
            return Model(z, NOTHING, NOTHING, NOTHING, cost(z[self.name]), NOTHING)

        monkeypatch.setattr(Fitter, "model", model)
        unused: Any = None
        self.fitter = Fitter(unused, {self.name: hypothesis}, NOTHING, unused)

    def at(self, *z: float) -> Model:
        found = self.fitter.model({self.name: np.array(z)})
        self.asked.clear()
        return found


def line(high: float = 1e9) -> Hypothesis:
    return Hypothesis("one", (Coordinate("x", 0.1, -1e9, high),), lambda z: {}, lambda z: 1.0, ((0.0,),))


def parabola(bottom: float) -> Cost:
    return lambda z: 100.0 + float((z[0] - bottom) ** 2)


@pytest.mark.parametrize(
    ("bottom", "high", "ends"),
    [
        (8.5, 1e9, 8.0),  # three times twice as far
        (100.0, 1e9, STRETCH_MOST),  # no further than allowed
        (3.2, 1e9, 4.0),  # nearer to 3.2 than 2 is
        (2.4, 1e9, 2.0),  # 4 leads up again
        (100.0, 3.0, 3.0),  # the end of the coordinate
    ],
)
def test_a_step_that_leads_far_down_is_doubled_while_that_helps(
    monkeypatch: pytest.MonkeyPatch, bottom: float, high: float, ends: float
) -> None:
    known = Known(monkeypatch, parabola(bottom), line(high))
    found = known.fitter._stretched(known.at(0.0), known.at(1.0))
    assert found.z["one"][0] == ends


def test_a_step_that_takes_little_off_the_cost_is_left_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """100.25 falls to 100: a quarter of the share from which a step is stretched; no simulation is spent on it."""
    known = Known(monkeypatch, lambda z: 100.25 - 0.25 * float(z[0]), line())
    stepped = known.at(1.0)
    assert 0.25 < STRETCH_SHARE * 100.25
    assert known.fitter._stretched(known.at(0.0), stepped) is stepped
    assert known.asked == []


def test_a_model_without_effects_is_its_own_best(monkeypatch: pytest.MonkeyPatch) -> None:
    fitter = Known(monkeypatch, parabola(3.0), line()).fitter
    healthy = Model({}, NOTHING, NOTHING, NOTHING, 100.0, NOTHING)
    assert fitter.descended(healthy, 3) is healthy


def test_the_form_of_a_saturation_that_fits_best_is_taken_and_its_size_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    saturation = hypotheses(Scale.of(MOTOR, 4000.0))["inductance_saturation"]
    by_slope = np.array([0.02, 0.0, 1.0])
    known = Known(monkeypatch, lambda z: float(np.sum((z - by_slope) ** 2)), saturation)
    found = known.fitter.variant(known.at(0.02, 0.5, 0.5))
    assert found.z["inductance_saturation"].tolist() == by_slope.tolist()
    assert len(known.asked) == len(saturation.variants) == 3


def test_a_form_between_two_stays_where_it_fits_better_than_each(monkeypatch: pytest.MonkeyPatch) -> None:
    saturation = hypotheses(Scale.of(MOTOR, 4000.0))["inductance_saturation"]
    between = np.array([0.02, 0.5, 0.5])
    known = Known(monkeypatch, lambda z: float(np.sum((z - between) ** 2)), saturation)
    start = known.at(*between)
    assert known.fitter.variant(start) is start


def test_the_forms_of_a_saturation_are_those_of_the_effect_in_the_simulator() -> None:
    """One with its own current, one with that of both axes, one whose linkage is the slope times the current."""
    saturation = hypotheses(Scale.of(MOTOR, 4000.0))["inductance_saturation"]
    z = np.array([0.02, 0.5, 0.5])
    forms = set()
    for variant in saturation.variants:
        moved = z.copy()
        for i, value in variant.items():
            moved[i] = value
        params = saturation.to_params(moved)
        forms.add((params["by_amplitude"], params["by_slope"]))
    assert forms == {(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)}
