"""What is tried beside what looks best."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from evenspin.effects import Scale, hypotheses
from evenspin.gap import screening
from evenspin.gap.acceptance import Acceptance, ExpectedCost
from evenspin.gap.candidate import Model
from evenspin.gap.reference import pages
from evenspin.gap.thresholds import SECTIONS

MOTOR = {"rated_current_a": 5.0, "rated_torque_nm": 1.0, "pole_pairs": 4, "slots": 12}
NOTHING = np.zeros(0)


EXPECTED = ExpectedCost(7000.0, 300.0)


def _found(library, *names: str) -> Model:
    z = {name: np.array(library[name].starts[-1]) for name in names}
    return Model(z, NOTHING, NOTHING, NOTHING, 0.0, NOTHING)


@pytest.fixture
def rules() -> Acceptance:
    return Acceptance(hypotheses(Scale.of(MOTOR, 4000.0)))


def test_play_on_a_shaft_that_twists_is_also_tried_without_the_play(rules) -> None:
    found = _found(rules.library, "backlash", "inertia")

    (candidate,) = rules.simpler(found)

    play, twist = (rules.library[n].to_params(m[n]) for n, m in (("backlash", found.z), ("two_mass", candidate.z)))
    assert set(candidate.z) == {"inertia", "two_mass"}
    assert candidate.z["inertia"] is found.z["inertia"]
    assert twist == {key: pytest.approx(play[key]) for key in twist}
    assert set(play) - set(twist) == {"gap_rad"}


def test_no_second_shaft_is_simulated_beside_one_that_the_model_has(
    rules: Acceptance, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The simulator refuses two shafts at once, and with it the whole case."""
    asked: list[set[str]] = []

    def features(forward: object, units: list[dict[str, object]], probes: int) -> list[np.ndarray]:
        asked.extend(set(unit) for unit in units)
        return [np.zeros((1, 0)) for _ in units]

    monkeypatch.setattr(screening, "model_features", features)
    fitter = SimpleNamespace(library=rules.library, forward=None, effects=lambda z: z)

    found = screening.signatures(fitter, _found(rules.library, "two_mass"))

    assert not any({"two_mass", "backlash"} <= unit for unit in asked)
    assert {s.name for s in found} == set(rules.library) - {"two_mass", "backlash"}
    assert {s.name for s in screening.signatures(fitter, _found(rules.library))} == set(rules.library)


def test_what_holds_nothing_simpler_is_tried_alone(rules) -> None:
    assert rules.simpler(_found(rules.library, "two_mass", "cogging")) == []


def _of_cost(cost: float) -> Model:
    return Model({}, NOTHING, NOTHING, NOTHING, cost, NOTHING)


@pytest.mark.parametrize(
    ("before", "after", "asked"),
    [
        (40_000.0, 15_000.0, False),  # three quarters of the excess
        (40_000.0, 30_000.0, True),  # a third
        (7_500.0, 6_900.0, True),  # nothing left to explain, however much of it
    ],
)
def test_only_what_takes_most_of_an_excess_away_needs_no_validation_record(
    rules, before: float, after: float, asked: bool
) -> None:
    """Where a loop rings, no simulation follows a validation record, the right one no better than others."""
    assert rules.is_decisive(_of_cost(before), _of_cost(after), EXPECTED) == (not asked)


def test_every_threshold_of_the_rules_stands_in_the_table_with_its_reasons() -> None:
    from evenspin.gap import thresholds_effects, thresholds_evidence, thresholds_records

    modules = (thresholds_effects, thresholds_evidence, thresholds_records)
    constants = {
        name: value
        for module in modules
        for name, value in vars(module).items()
        if name.isupper() and isinstance(value, int | float)
    }
    table = [t for section in SECTIONS for t in section.rows]

    assert {t.name: t.value for t in table} == constants
    assert len(table) == len(constants)  # no name twice
    assert all(t.unit and t.separates and t.set_on and t.too_low and t.too_high for t in table)
    (page,) = pages().values()
    assert all(f"| `{t.name}` | {t.value:g} " in page for t in table)


def test_a_small_gain_needs_a_second_look_and_a_tolerance_does_not(rules) -> None:
    assert rules.needs_recheck("cogging", 100.0)
    assert not rules.needs_recheck("cogging", 2000.0)  # by chance, gains of 100 come up on healthy units
    assert not rules.needs_recheck("inertia", 100.0)
    assert rules.holds("inertia", 9.0) and not rules.holds("cogging", 9.0)  # three sigmas of a prior cost 9


def _beside_saturation(rules: Acceptance, factor_edges: float, cost: float) -> Model:
    """Saturation, and a viscous friction so many times the edge of its tolerance off."""
    friction = rules.library["viscous_friction"]
    edge = np.array([1.0])
    edge /= friction.magnitude(edge)
    z = {"inductance_saturation": np.zeros(3), "viscous_friction": factor_edges * edge}
    return Model(z, NOTHING, NOTHING, NOTHING, cost, NOTHING)


@pytest.mark.parametrize(
    ("edges", "gain", "remainder"),
    [
        (1.4, 10.0, True),  # little cost, and a unit near the edge of its tolerance: what saturation leaves
        (1.6, 10.0, False),  # little cost, but no unit is so far off
        (1.4, 5000.0, False),  # half of what saturation takes off is no remainder
    ],
)
def test_a_small_gain_beside_a_large_effect_is_its_remainder_unless_no_unit_is_so_far_off(
    rules: Acceptance, edges: float, gain: float, remainder: bool
) -> None:
    alone = Model({"inductance_saturation": np.zeros(3)}, NOTHING, NOTHING, NOTHING, 1000.0, NOTHING)
    both = _beside_saturation(rules, edges, 1000.0 - gain)
    assert rules.is_remainder(alone, both, explained=10_000.0) == remainder


def test_an_effect_without_a_tolerance_is_a_remainder_however_large(rules: Acceptance) -> None:
    alone = Model({"inductance_saturation": np.zeros(3)}, NOTHING, NOTHING, NOTHING, 1000.0, NOTHING)
    z = dict(alone.z) | {"coulomb_friction": np.array([100.0])}
    assert rules.is_remainder(alone, Model(z, NOTHING, NOTHING, NOTHING, 990.0, NOTHING), explained=10_000.0)
