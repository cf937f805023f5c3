"""Blind cases whose verdict hangs on one rule of the search each.

The search has the effects to choose from that the rule is about, and those that look most like them. That the others
stay out of a verdict is shown by the cases that are solved whole, at the end and in gap/test_gap_examples.py;
`make gap-cases` has all effects here, too. One of the cases is in `make test`, the others are in `make test-searches`;
each rule by itself is in gap/test_gap_minima.py, test_gap_candidates.py, test_gap_slotting.py and test_gap_result.py.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evenspin.blind.cases import Plan, make_case
from evenspin.blind.truth import Truth
from evenspin.blind.vocabulary import EFFECTS
from evenspin.effects import Hypothesis, hypotheses
from evenspin.gap import investigate as core
from evenspin.gap.evidence import Effects
from evenspin.gap.finding import Finding
from evenspin.gap.investigate import Investigation
from evenspin.log.case import read_case

# Friction and what else needs torque in proportion to speed, current or acceleration; voltages of the windings.
SMOOTH = (
    "viscous_friction", "coulomb_friction", "inertia", "torque_constant", "inductance_saturation", "winding_resistance",
)  # fmt: skip
# Torque that repeats with the angle, and the sensors that make it seem so; friction, in which a rotor rests as well.
PERIODIC = ("cogging", "flux_harmonics", "current_offset", "current_gain", "coulomb_friction", "viscous_friction")


def _investigated(
    folder: Path, among: tuple[str, ...], seed: tuple[int, int], kind: str, size: int, *names: str
) -> tuple[Truth, Finding, Effects]:
    def library(*words: Any) -> dict[str, Hypothesis]:
        return {k: h for k, h in hypotheses(*words).items() if k in among or "EVENSPIN_CAMPAIGN" in os.environ}

    case = folder / "case"
    truth = make_case(Plan("case", seed, kind, size, names), case)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(core, "hypotheses", library)
        investigation = Investigation(read_case(case), 2)
    try:
        finding: Finding = investigation.run()
    finally:
        investigation.forward.close()
    return truth, finding, investigation.search.fitter.effects(finding.model.z)


@pytest.mark.search
@pytest.mark.parametrize("seed", [(7, 29)])
def test_cogging_in_whose_wells_the_rotor_rests_is_found_at_its_phase(tmp_path: Path, seed) -> None:
    """144 periods per turn, seven counts of the encoder each: a linear fit ends 110 degrees off."""
    truth, finding, effects = _investigated(tmp_path, PERIODIC, seed, "single", 2, "cogging")
    hidden = truth.effects[0]["parameters"]
    assert hidden["order"] == 144.0
    assert finding.named == ("cogging",)
    assert not finding.unknown
    assert effects["cogging"]["order"] == 144.0
    assert effects["cogging"]["amplitude_nm"] == pytest.approx(hidden["amplitude_nm"], rel=0.10)  # the format's goal
    turn = math.remainder(effects["cogging"]["phase_rad"] - hidden["phase_rad"], math.tau)
    assert abs(turn) < 144 * math.tau / 1024  # one count of the encoder, within which the first angle is not known


@pytest.mark.search
def test_what_only_seems_significant_before_its_own_noise_is_known_is_not_named(tmp_path: Path) -> None:
    """A healthy unit: saturation takes 13 off the cost under the noise level around itself, less than a name must."""
    _, finding, _ = _investigated(tmp_path, SMOOTH, (7, 17), "none", 0)
    assert finding.named == ()
    assert not finding.unknown


@pytest.mark.search
def test_a_tolerance_far_beyond_its_bounds_is_named_beside_a_large_effect(tmp_path: Path) -> None:
    """Viscous friction of 0.78, six sigmas off, beside a saturation whose voltage across the axes is of the slope."""
    hidden = ("inductance_saturation", "viscous_friction")
    truth, finding, effects = _investigated(tmp_path, SMOOTH, (7, 30), "pair", 1, *hidden)
    assert set(finding.named) == set(hidden)
    factor = {e["name"]: e["parameters"] for e in truth.effects}["viscous_friction"]["factor"]
    assert effects["viscous_friction"]["factor"] == pytest.approx(factor, rel=0.10)


def test_a_tolerance_a_little_beyond_its_bounds_is_named(tmp_path: Path) -> None:
    """Viscous friction of 0.854: the fit takes four fifths of that for the unit's own until the rule says otherwise."""
    truth, finding, effects = _investigated(tmp_path, SMOOTH, (11, 34), "single", 0, "viscous_friction")
    assert finding.named == ("viscous_friction",)
    factor = truth.effects[0]["parameters"]["factor"] * truth.unit["motor.viscous_nms"]
    assert effects["viscous_friction"]["factor"] == pytest.approx(factor, rel=0.02)  # the median's goal


@pytest.mark.search
def test_cogging_of_the_slots_alone_is_found_at_its_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """9 slots and 4 pole pairs: order 72 as a rule, order 9 where one magnet is unlike the others."""

    def of_the_slots(rng: np.random.Generator, meta: Mapping[str, Any], size: int) -> dict[str, float]:
        amplitude_nm = 0.02 * meta["motor"]["rated_torque_nm"]
        return {"amplitude_nm": amplitude_nm, "phase_rad": 1.0, "order": float(meta["motor"]["slots"])}

    monkeypatch.setitem(EFFECTS, "cogging", of_the_slots)
    truth, finding, effects = _investigated(tmp_path, PERIODIC, (8102, 10), "single", 1, "cogging")
    hidden = truth.effects[0]["parameters"]
    assert hidden["order"] == 9.0
    assert finding.named == ("cogging",)
    assert effects["cogging"]["order"] == 9.0
    assert effects["cogging"]["amplitude_nm"] == pytest.approx(hidden["amplitude_nm"], rel=0.02)  # the median's goal
    assert effects["cogging"]["phase_rad"] == pytest.approx(1.0, abs=0.05)


@pytest.mark.search
def test_a_hidden_effect_is_named_a_foreign_one_is_unknown_and_nothing_is_nothing(evenspin, tmp_path: Path) -> None:
    """A fast part of `make blind`: a foreign line on the dc link, flux harmonics of 2.5 %, and nothing."""
    cases, truth, verdicts = tmp_path / "cases", tmp_path / "truth.json", tmp_path / "verdicts"
    kinds = ("--count", 3, "--kind", "single=1,none=1,outside=1")
    assert evenspin("gap", "blind", "make", "--out", cases, "--truth", truth, *kinds, "--seed", 21).status == 0

    assert evenspin("gap", "batch", cases, "--out", verdicts).status == 0

    hidden = json.loads(truth.read_text())
    assert {content["kind"] for content in hidden.values()} == {"single", "none", "outside"}
    for case, content in hidden.items():
        verdict = json.loads((verdicts / case / "verdict.json").read_text())
        wanted = ["unknown"] if content["outside"] else [effect["name"] for effect in content["effects"]]
        assert verdict["verdict"] == wanted, case
        if content["effects"]:
            assert verdict["gap_after"] < verdict["gap_before"]
