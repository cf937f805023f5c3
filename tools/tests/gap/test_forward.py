"""A machine that was simulated is not simulated again: what it logs depends on nothing else."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

import numpy as np
import pytest
from evenspin.gap.forward import KEPT, Forward
from evenspin.log.unit import Unit


@pytest.fixture
def forward(monkeypatch: pytest.MonkeyPatch) -> Any:
    made: Any = object.__new__(Forward)
    made.asked, made._kept = [], OrderedDict()

    def simulate(self: Any, unit: Unit) -> list[Any]:
        made.asked.append(unit)
        return [np.full((1, 1), float(len(made.asked)))]

    monkeypatch.setattr(Forward, "simulate", simulate)
    monkeypatch.setattr(Forward, "reduced", lambda self, records: records[0][0].copy())
    return made


def test_the_same_machine_with_the_same_noise_is_simulated_once(forward: Any) -> None:
    one = Unit({"cogging": {"amplitude_nm": 0.1, "phase_rad": 1.0}, "inertia": {"factor": 1.2}}, {}, 3, 0.25)
    same = Unit({"inertia": {"factor": 1.2}, "cogging": {"phase_rad": 1.0, "amplitude_nm": 0.1}}, {}, 3, 0.25)
    assert forward.features(one) == forward.features(same) == [1.0]
    assert len(forward.asked) == 1


@pytest.mark.parametrize(
    "other",
    [
        Unit({"inertia": {"factor": 1.2000001}}, {"psi_wb": 1.01}, 3, 0.25),
        Unit({"inertia": {"factor": 1.2}}, {"psi_wb": 1.02}, 3, 0.25),
        Unit({"inertia": {"factor": 1.2}}, {"psi_wb": 1.01}, None, 0.25),
        Unit({"inertia": {"factor": 1.2}}, {"psi_wb": 1.01}, 3, 0.75),
        Unit({}, {"psi_wb": 1.01}, 3, 0.25),
    ],
)
def test_whatever_differs_is_simulated_by_itself(forward: Any, other: Unit) -> None:
    forward.features(Unit({"inertia": {"factor": 1.2}}, {"psi_wb": 1.01}, 3, 0.25))
    assert forward.features(other) == [2.0]


def test_what_was_kept_cannot_be_changed_by_its_reader(forward: Any) -> None:
    with pytest.raises(ValueError, match="read-only"):
        forward.features(Unit())[0] = 7.0


def test_only_the_last_machines_are_kept(forward: Any) -> None:
    for seed in range(KEPT + 1):
        forward.features(Unit(noise_seed=seed))
    forward.features(Unit(noise_seed=KEPT))
    assert len(forward.asked) == KEPT + 1
    forward.features(Unit(noise_seed=0))
    assert len(forward.asked) == KEPT + 2
