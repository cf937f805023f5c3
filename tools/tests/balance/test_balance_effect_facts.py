"""The torque balance and the table of effects: what is written there is not written again."""

from __future__ import annotations

import pytest
from evenspin.balance.effect_facts import separation, smallest_torque_nm, table_parameter, torque_effects
from evenspin.balance.verdict import Verdict, out_of_range
from evenspin.native import tables


def test_torque_effects_are_those_that_the_plant_adds_up_on_the_shaft() -> None:
    """sim_host/effects: the files that set .torque_nm or .friction_nm; viscous friction is part of the machine."""
    expected = {
        "coulomb_friction", "stribeck_friction", "load_torque", "cogging", "misalignment", "torque_ripple",
    }  # fmt: skip

    assert set(torque_effects()) == expected


@pytest.mark.parametrize(
    ("effect", "key", "expected"),
    [
        ("coulomb_friction", "torque_a_equiv", "torque_nm"),
        ("cogging", "amplitude_a_equiv", "amplitude_nm"),
        ("cogging", "order", "order"),
        ("cogging", "amplitude_half_a_equiv", None),
        ("misalignment", "second_rel", "second_rel"),
        ("inertia", "factor", "factor"),
        ("inertia", "torque_a_equiv", None),
    ],
)
def test_a_key_of_the_verdict_is_a_parameter_of_the_table(effect: str, key: str, expected: str | None) -> None:
    assert table_parameter(effect, key) == expected


def test_friction_does_not_drive_and_a_load_may() -> None:
    assert smallest_torque_nm("coulomb_friction") == 0.0
    assert smallest_torque_nm("load_torque") < 0.0
    assert "impossible" in (out_of_range("coulomb_friction", {"torque_a_equiv": -0.1}) or "")
    assert out_of_range("load_torque", {"torque_a_equiv": -0.1}) is None


def test_an_alternative_says_what_the_table_says_would_separate_it() -> None:
    verdict = Verdict()

    verdict.alternative("inertia", "torque_constant", 0.5, "same ratio")

    assert verdict.alternatives == [
        ("torque_constant", 0.5, f"same ratio; inertia: {tables().effects['inertia'].told_apart}")
    ]
    assert separation("cogging", "current_offset").startswith("current_offset: ")  # the table has it on that side
    with pytest.raises(ValueError, match="does not confuse"):
        separation("cogging", "winding_resistance")
