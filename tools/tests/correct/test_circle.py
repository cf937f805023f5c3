"""From a hidden effect to a drive without it, in one command; and the page of the campaign over blind machines.

The command with all effects and experiments takes half a minute; here the search is among two effects, in a short log.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from evenspin.correct import circle as circle_module
from evenspin.effects import hypotheses
from evenspin.gap import investigate as core

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from urllib.parse import urlencode

import circle_campaign
from circle_page import page_of
from evenspin.bench.ports import virtual_drive
from evenspin.blind.motors import draw_motor

SHORT = ("staircase",)


@pytest.fixture
def short(monkeypatch):
    """Experiments and effects that are enough for cogging, and its neighbour."""
    everything = circle_module.plan
    monkeypatch.setattr(circle_module, "plan", lambda machine: tuple(e for e in everything(machine) if e.name in SHORT))
    monkeypatch.setattr(
        core,
        "hypotheses",
        lambda scale: {k: h for k, h in hypotheses(scale).items() if k in ("cogging", "viscous_friction")},
    )


def test_the_circle_finds_what_is_hidden_corrects_it_and_measures_what_is_left(short, tmp_path: Path, evenspin):
    port = "sim:servo?cogging.amplitude_nm=0.05&cogging.order=18&cogging.phase_rad=2.0"
    said = evenspin("gap", "circle", "--port", port, "--out", tmp_path / "out", "--json")

    assert said.status == 0, said.err
    content = json.loads(said.out)
    assert content["verdict"]["verdict"] == ["cogging"]
    (row,) = content["applied"]["corrections"]
    # what is hidden is known here: the line in the drive is the torque in the machine, within the interval of its size
    values = content["applied"]["parameters"]
    assert values["rdc_line1_nm"] == pytest.approx(0.05, rel=0.05)
    assert values["rdc_line1_rad"] == pytest.approx(2.0, abs=0.06)
    assert row["kept"] and row["after"] < 0.2 * row["before"]
    assert row["predicted_change_over_measured"] == pytest.approx(1.0, abs=0.25)
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"case", "gap", "applied", "report.html"}
    assert (tmp_path / "out" / "gap" / "correction.toml").is_file()


def test_a_healthy_machine_is_left_as_it_is(short, tmp_path: Path, evenspin):
    said = evenspin("gap", "circle", "--port", "sim:servo", "--out", tmp_path / "out")

    assert said.status == 1
    assert "No correction is proposed: nothing is named." in said.out


def test_a_port_that_is_no_simulation_is_refused_with_the_three_commands(tmp_path: Path, evenspin):
    said = evenspin("gap", "circle", "--port", "socket://127.0.0.1:9", "--out", tmp_path / "out")

    assert said.status == 2 and not (tmp_path / "out").exists()
    assert all(command in said.err for command in ("bench run", "evenspin gap", "bench apply"))


def test_machines_of_the_campaign_are_within_the_tolerances_and_have_what_is_hidden(tmp_path: Path):
    rng = np.random.default_rng(5)
    meta = draw_motor(rng)
    (tmp_path / "m.toml").write_text(circle_campaign.model_toml(meta, 1.0))
    query = circle_campaign.hidden_in(rng, meta, {"current_offset": {"offset_a_a": 1.0, "offset_b_a": -1.0}})
    drive = virtual_drive(f"sim:{tmp_path / 'm.toml'}?{urlencode(query)}")

    assert drive.machine.plant["psi_wb"] == meta["motor"]["psi_wb"]  # what the tool gets
    assert 0.0 < abs(drive.plant["psi_wb"] / meta["motor"]["psi_wb"] - 1.0) <= 0.004
    assert drive.plant["ld_h"] / meta["motor"]["ld_h"] == pytest.approx(drive.plant["lq_h"] / meta["motor"]["lq_h"])
    assert drive.effects["current_offset"]["offset_a_a"] == pytest.approx(1.0, abs=0.0101)
    assert drive.effects["current_gain"]["gain_b"] == pytest.approx(1.0, abs=0.0021)
    assert drive.machine.effects == {}


def test_the_page_counts_what_was_measured_and_lists_what_has_no_correction():
    def row(before, after, ratio, kept=True):
        return {
            "name": "cogging", "before": before, "predicted": 0.1, "predicted_low": 0.0, "predicted_high": 0.2,
            "after": after, "unit": "r/min", "reduction": 1 - after / before, "reduction_of_effect": 1 - after / before,
            "predicted_change_over_measured": ratio, "kept": kept,
        }  # fmt: skip

    cases = [
        {"case": "one", "size": "small", "hidden": {"cogging": {}}, "verdict": ["cogging"], "left": [],
         "applied": {"corrections": [row(2.0, 0.2, 1.1)]}},
        {"case": "two", "size": "large", "hidden": {"cogging": {}}, "verdict": ["cogging"], "left": [],
         "applied": {"corrections": [row(2.0, 2.2, None, False)]}},
        {"case": "three", "size": "small", "hidden": {"backlash": {}}, "verdict": ["backlash"],
         "left": [{"effect": "backlash", "reason": "a gap"}], "applied": None},
        {"case": "four", "hidden": {"inertia": {}}, "error": "it trips"},
    ]  # fmt: skip
    page = page_of(cases, 7, 60)

    assert "`make circle CIRCLE_COUNT=60 CIRCLE_SEED=7` 4 were run" in page
    assert "| what the effect spoils is smaller | 95 % | 50 % (1 of 2) |" in page
    assert "| it is more than 5 % larger | none | 50 % (1 of 2) |" in page
    assert "| predicted change within 25 % of the measured one | 90 % | 50 % (1 of 2) |" in page
    assert "| three | backlash (small) | backlash | backlash | a gap |" in page
    assert "| four | inertia (-) | - | - | the experiments could not be done: it trips |" in page
    assert "Of the hidden effects 3 have a correction in the drive and 1 have none." in page
