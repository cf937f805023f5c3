"""A frequency or an order that no effect has: taken off the log, so that what is known is found beside it.

What is hidden comes from the model files below, not from the code under test.
"""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from evenspin.effects import Hypothesis, Scale, hypotheses
from evenspin.gap import investigate as core
from evenspin.gap.leftover import Line
from evenspin.gap.periodic import periodic_lines, tone_share
from evenspin.gap.plan import meta, perform, plan
from evenspin.gap.thresholds_effects import LINE_RATIO
from evenspin.gap.thresholds_evidence import PERIODIC_RATIO, PERIODIC_SHARE, PERIODIC_STRETCHES
from evenspin.log import write_case
from evenspin.log.case import read_case
from evenspin.log.unit import Unit
from evenspin.model import load_machine
from scipy.signal import lfilter
from test_gap_result import MACHINE

HEALTHY = MACHINE.partition("[effects.")[0]
FRICTION = ("coulomb_friction", "viscous_friction")
COULOMB_NM = 0.06
BELT = "[effects.empirical]\nline_1_nm = 0.05\nline_1_order = 3.4\nline_1_phase_rad = 0.5\n"
SECOND_SHAFT = "[effects.empirical]\nline_1_nm = 0.12\nline_1_order = 13\nline_1_phase_rad = 0.5\n"


@contextmanager
def investigation_of(machine: str, folder: Path, validated: str | None = None) -> Iterator[core.Investigation]:
    """The staircase under load of that machine and a validation record, with two kinds of friction to choose from.

    `validated`: another machine, of which the validation record is.
    """

    def library(scale: Scale) -> dict[str, Hypothesis]:
        return {name: h for name, h in hypotheses(scale).items() if name in FRICTION}

    chosen = []
    for name, text in (("staircase_load", machine), ("validation", validated or machine)):
        (folder / f"{name}.toml").write_text(text)
        chosen += [e for e in plan(load_machine(folder / f"{name}.toml")) if e.name == name]
    case = folder / "case"
    case.mkdir()
    write_case(case, meta(chosen, "small"), {e.name: perform(e) for e in chosen})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(core, "hypotheses", library)
        investigation = core.Investigation(read_case(case), 2)
        try:
            yield investigation
        finally:
            investigation.forward.close()


@pytest.mark.parametrize(
    ("line", "order", "least_ratio"), [(BELT, 3.4, LINE_RATIO), (SECOND_SHAFT, 13.0, PERIODIC_RATIO)]
)
def test_friction_is_named_beside_a_foreign_order_and_the_order_is_reported(
    tmp_path: Path, line: str, order: float, least_ratio: float
) -> None:
    machine = f"{HEALTHY}[effects.coulomb_friction]\ntorque_nm = {COULOMB_NM}\n{line}"
    with investigation_of(machine, tmp_path) as investigation:
        assert investigation.without_tones(least_ratio)
        finding = investigation.run()
        torque_nm = investigation.search.fitter.effects(finding.model.z)["coulomb_friction"]["torque_nm"]

    assert finding.unknown
    assert finding.named == ("coulomb_friction",)
    assert torque_nm == pytest.approx(COULOMB_NM, rel=0.05)  # the goal for a known effect beside a foreign one
    # the longest stretch holds two turns: a tenth of a cycle over it
    assert [tone.order for tone in finding.periodic] == pytest.approx([order], abs=0.05)


@pytest.mark.parametrize(
    "effect",
    [
        "",
        "[effects.coulomb_friction]\ntorque_nm = 0.06\n",
        "[effects.cogging]\namplitude_nm = 0.1\norder = 18\n",
        "[effects.two_mass]\nload_ratio = 0.5\nf_res_hz = 60.0\ndamping_ratio = 0.02\n",
    ],
)
def test_nothing_is_taken_off_the_log_of_a_healthy_machine_or_of_a_known_effect(tmp_path: Path, effect: str) -> None:
    with investigation_of(HEALTHY + effect, tmp_path) as investigation:
        assert not investigation.without_tones(LINE_RATIO)
        assert not investigation.beside


def test_a_line_that_is_strongest_at_rest_does_not_end_the_search(tmp_path: Path) -> None:
    with investigation_of(HEALTHY, tmp_path) as investigation:
        forward = investigation.forward
        layout = forward.sets[0].layout
        speeds = [s.speed_rad_s for s in layout.steady if s.speed_rad_s != 0.0]
        turning = [Line(layout.record, "iq_a", w, 40.0, math.tau * 40.0 / w, 1.0, 1e3, 1.0) for w in speeds]
        at_rest = Line(layout.record, "iq_a", 0.0, 40.0, math.inf, 1.0, 1e6, 1.0)
        assert len(turning) > PERIODIC_STRETCHES
        assert periodic_lines(forward, [at_rest, *turning], Unit()) == ()  # there is no such line in what it recorded


@pytest.mark.parametrize(("validated", "changes"), [(True, ("coulomb_friction",)), (False, ())])
def test_an_effect_whose_size_differs_counts_where_it_serves_records_that_no_fit_has_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, validated: bool, changes: tuple[str, ...]
) -> None:
    """A small friction in the staircase; in the validation record, too, or not. That its size differs is given."""
    machine = f"{HEALTHY}[effects.coulomb_friction]\ntorque_nm = 0.0055\n"
    monkeypatch.setattr(core, "size_spread", lambda fitter, best, name: 0.5)
    with investigation_of(machine, tmp_path, machine if validated else HEALTHY) as investigation:
        finding = investigation.run()
    assert finding.changes == changes
    assert set(finding.model.z) == set(changes)


def wave_at(x: np.ndarray, cycles: float) -> np.ndarray:
    phase = 2.0 * np.pi * cycles * np.arange(len(x)) / len(x)
    both = np.stack((np.cos(phase), np.sin(phase)), axis=1)
    return both @ np.linalg.lstsq(both, x, rcond=None)[0]


def test_a_tone_goes_with_one_wave_and_a_resonance_in_noise_does_not() -> None:
    """One second at 1 kHz; a shaft of 60 Hz with a damping of 0.05, as the referee draws them."""
    random = np.random.default_rng(1)
    tone = np.sin(2.0 * np.pi * 60.3 * np.arange(1000) / 1000.0) + 0.1 * random.standard_normal(1000)
    assert tone_share(tone, wave_at(tone, 60.3), 60) > 0.97  # noise: 0.01 of the power, a fortieth of it in the band

    radius, angle = np.exp(-0.05 * 2.0 * np.pi * 0.06), 2.0 * np.pi * 0.06
    shares = []
    for _ in range(50):
        x = lfilter([1.0], [1.0, -2.0 * radius * np.cos(angle), radius**2], random.standard_normal(3000))[2000:]
        peak = 45 + int(np.argmax(np.abs(np.fft.rfft(np.hanning(1000) * x))[45:76]))
        shares.append(tone_share(x, wave_at(x, peak), peak))
    assert np.mean(np.array(shares) > PERIODIC_SHARE) < 0.05


def test_a_search_begins_without_the_packages_that_only_some_logs_need() -> None:
    """Half a second of processor time each: for lines that are left, local minima, terms beyond the table."""
    code = (
        "import sys, evenspin.gap.result; print({'scipy.signal', 'scipy.stats', 'scipy.optimize'} & set(sys.modules))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "set()"
