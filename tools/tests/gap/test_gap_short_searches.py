"""What `make test-searches` shows on whole cases, on two short records and with few effects to choose from.

What is hidden comes from the model files below, not from the code under test.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evenspin.effects import Hypothesis, Scale, hypotheses
from evenspin.gap import investigate as core
from evenspin.gap.evidence import Effects
from evenspin.gap.finding import Finding
from evenspin.gap.plan import meta, perform, plan
from evenspin.log import write_case
from evenspin.log.case import read_case
from evenspin.model import load_machine
from test_gap_result import MACHINE, SECONDS

FRICTION = ("coulomb_friction", "viscous_friction")
SENSORS = ("current_offset", "current_gain")
HEALTHY = MACHINE.partition("[effects.")[0]
OFFSET_A = (0.12, -0.09)  # ten and eight times the noise of the current


def found_in(machine: str, among: Sequence[str], folder: Path) -> tuple[Finding, Effects, bool]:
    """Records of that machine, searched among these effects; whether the noise at last is another than at first."""

    def library(scale: Scale) -> dict[str, Hypothesis]:
        return {name: h for name, h in hypotheses(scale).items() if name in among}

    (folder / "machine.toml").write_text(machine)
    chosen = [
        replace(e, setup=replace(e.setup, duration_s=SECONDS[e.name]))
        for e in plan(load_machine(folder / "machine.toml"))
        if e.name in SECONDS
    ]
    case = folder / "case"
    case.mkdir()
    write_case(case, meta(chosen, "small"), {e.name: perform(e) for e in chosen})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(core, "hypotheses", library)
        investigation = core.Investigation(read_case(case), 1)
    nominal = investigation.search.fitter.judge.noise
    try:
        finding = investigation.run()
    finally:
        investigation.forward.close()
    fitter = investigation.search.fitter
    return finding, fitter.effects(finding.model.z), not np.array_equal(nominal.sigma, fitter.judge.noise.sigma)


def test_in_a_healthy_machine_nothing_is_named(tmp_path: Path) -> None:
    finding, _, _ = found_in(HEALTHY, FRICTION, tmp_path)

    assert finding.named == ()
    assert not finding.unknown


def test_what_no_effect_of_the_choice_explains_is_unknown(tmp_path: Path) -> None:
    finding, _, _ = found_in(
        HEALTHY + "[effects.cogging]\namplitude_nm = 0.15\norder = 18\nphase_rad = 0.7\n", FRICTION, tmp_path
    )

    assert finding.named == ()
    assert finding.unknown


def test_an_offset_of_the_current_sensors_is_named_with_its_direction(tmp_path: Path) -> None:
    a, b = OFFSET_A
    finding, effects, judged_again = found_in(
        HEALTHY + f"[effects.current_offset]\noffset_a_a = {a}\noffset_b_a = {b}\n", SENSORS, tmp_path
    )

    assert finding.named == ("current_offset",)
    assert judged_again  # under the noise around itself
    # 10 % of a vector of 0.15 A: two records of three seconds, and the unit has offsets of its own
    assert effects["current_offset"]["offset_a_a"] == pytest.approx(a, abs=0.015)
    assert effects["current_offset"]["offset_b_a"] == pytest.approx(b, abs=0.015)


def test_two_effects_are_named_together_with_their_sizes(tmp_path: Path) -> None:
    """Friction in every stretch, inertia where the speed changes."""
    hidden = "[effects.coulomb_friction]\ntorque_nm = 0.06\n[effects.inertia]\nfactor = 1.4\n"
    finding, effects, _ = found_in(HEALTHY + hidden, ("coulomb_friction", "viscous_friction", "inertia"), tmp_path)

    assert set(finding.named) == {"coulomb_friction", "inertia"}
    # 5 %: more than a unit's own tolerance moves a parameter
    assert effects["coulomb_friction"]["torque_nm"] == pytest.approx(0.06, rel=0.05)
    assert effects["inertia"]["factor"] == pytest.approx(1.4, rel=0.05)
