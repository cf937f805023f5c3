"""What is tried beside what looks best."""

from __future__ import annotations

import numpy as np
import pytest
from evenspin.gap.candidate import Model
from evenspin.gap.hypotheses import hypotheses
from evenspin.gap.investigate import Floor, Investigation

MOTOR = {"rated_current_a": 5.0, "rated_torque_nm": 1.0, "pole_pairs": 4, "slots": 12}
NOTHING = np.zeros(0)


FLOOR = Floor(7000.0, 300.0)


def _found(library, *names: str) -> Model:
    z = {name: np.array(library[name].starts[-1]) for name in names}
    return Model(z, NOTHING, NOTHING, NOTHING, 0.0, NOTHING)


@pytest.fixture
def investigation() -> Investigation:
    bare = Investigation.__new__(Investigation)  # without a log
    bare.library = hypotheses(MOTOR, 4000.0)
    return bare


def test_play_on_a_shaft_that_twists_is_also_tried_without_the_play(investigation) -> None:
    found = _found(investigation.library, "backlash", "inertia")

    (lead,) = investigation._simpler(found)

    play, twist = (investigation.library[n].to_params(m[n]) for n, m in (("backlash", found.z), ("two_mass", lead.z)))
    assert set(lead.z) == {"inertia", "two_mass"}
    assert lead.z["inertia"] is found.z["inertia"]
    assert twist == {key: pytest.approx(play[key]) for key in twist}
    assert set(play) - set(twist) == {"gap_rad"}


def test_what_holds_nothing_simpler_is_tried_alone(investigation) -> None:
    assert investigation._simpler(_found(investigation.library, "two_mass", "cogging")) == []


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
    investigation, monkeypatch, before: float, after: float, asked: bool
) -> None:
    """Where a loop rings, no simulation follows a validation record, the right one no better than others."""
    monkeypatch.setattr(investigation, "_validates", lambda without, with_it: False)

    assert investigation._is_trusted(_of_cost(before), _of_cost(after), FLOOR) == (not asked)
