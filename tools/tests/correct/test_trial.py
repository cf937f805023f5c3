"""Corrections tried on a virtual drive with the effect in its machine: kept where they help, taken back where not."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tomlkit
from bench_model import MODEL
from evenspin.bench import Drive
from evenspin.bench.errors import LinkLostError
from evenspin.bench.experiments import experiments_toml, read_experiments
from evenspin.bench.operator import operator_for
from evenspin.correct import trial as trial_module
from evenspin.correct.changes import known
from evenspin.correct.file import CORRECTION, EXPERIMENTS, NOMINAL, correction_toml
from evenspin.correct.found import Found
from evenspin.correct.predict import Prediction
from evenspin.correct.proposal import Correction, Proposal
from evenspin.correct.quantities import Quantity
from evenspin.correct.rules import RULES, Rule
from evenspin.correct.trial import TrialError, run_trial
from evenspin.errors import InputError
from evenspin.gap import plan as planning
from evenspin.log.experiments import Experiment
from evenspin.log.meta_numbers import MetaNumbers
from evenspin.log.nominal import Nominal
from evenspin.model import InputCurve, builtin_models, load_machine

PORT = (
    "sim:servo?cogging.amplitude_nm=0.05&cogging.order=18&cogging.phase_rad=0.7"
    "&current_offset.offset_a_a=0.15&current_offset.offset_b_a=-0.05"
)
STAIRS = Experiment("staircase", "speed", 3.0, 2000.0, {"speed_ref_rad_s": InputCurve((0.0, 1.5), (15.0, -30.0))})
PREDICTED = Prediction(2.0, 0.02, 2.0, 0.1, 0.05, 0.15)


def _lines(phase_rad=0.7, name="cogging"):
    changes = (
        known("speed_model_ff", 1.0), known("rdc_line1_cycles", 18.0), known("rdc_line1_nm", 0.05),
        known("rdc_line1_rad", phase_rad), known("rdc_viscous_nms", 0.0),
    )  # fmt: skip
    return Correction(name, ("cogging",), changes, Quantity("speed_ripple", ("staircase",), (18.0,)), PREDICTED)


def _sensors(a=0.15, b=-0.05):
    changes = (
        known("current_correction", "fixed"), known("current_offset_a_a", a), known("current_offset_b_a", b),
    )  # fmt: skip
    return Correction(
        "current_offset", ("current_offset",), changes, Quantity("speed_ripple", ("staircase",), (3.0,)), PREDICTED
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    place = tmp_path / "gap"
    place.mkdir()
    (place / NOMINAL).write_text(MODEL)
    (place / EXPERIMENTS).write_text(experiments_toml("short", NOMINAL, (STAIRS,)))
    return place


def _proposal(*corrections) -> Proposal:
    return Proposal("short", tuple(c.name for c in corrections), corrections, ())


def _run(drive, folder, *corrections):
    operator = operator_for(drive.link.transport, lambda request: True)
    what = read_experiments(folder / EXPERIMENTS)
    said: list[str] = []
    done = run_trial(
        drive, operator, _proposal(*corrections), what, lambda name, seconds: None, said.append, lambda run: None
    )
    return done, said


def test_two_corrections_that_help_are_kept_and_each_takes_its_own_ripple(folder: Path):
    with Drive.connect(PORT) as drive:
        done, _ = _run(drive, folder, _lines(), _sensors())
        held = drive.get()
    assert done.kept == ("cogging", "current_offset")
    for row in done.rows:
        # the correction is exact; what is left are the steps of the encoder and of the converter
        assert row.after < 0.1 * row.before
    assert list(done.runs) == ["before", "after"]
    assert held["rdc_line1_rad"] == pytest.approx(0.7)
    assert held["current_offset_a_a"] == pytest.approx(0.15)
    assert done.values_before["speed_model_ff"] == 0.0
    assert done.uneven[1] < 0.2 * done.uneven[0]


HIDDEN = {
    "encoder_eccentricity": {"amplitude_rad": 0.007, "phase_rad": 2.2},
    "flux_harmonics": {"torque_ripple_rel": 0.05, "sign": -1.0, "fifth_share": 0.5},
    "two_mass": {"f_res_hz": 60.0, "load_ratio": 0.6, "damping_ratio": 0.03, "load_friction_share": 0.5},
}


@pytest.mark.parametrize(("name", "chosen"), [("encoder_eccentricity", 0), ("flux_harmonics", 0), ("two_mass", 3)])
def test_what_the_table_makes_of_a_known_cause_takes_four_fifths_of_what_the_drive_shows(name, chosen, folder: Path):
    machine = load_machine(builtin_models()["servo"])
    meta = planning.meta(planning.plan(machine, 1), "short")
    found = Found({name: HIDDEN[name]}, {}, np.zeros(9), Nominal.of(MetaNumbers(Path("short"), meta)))
    rule = RULES[name]
    assert isinstance(rule, Rule)
    changes = [*rule.changes(found, [name]), *(rule.chosen(found)[chosen] if rule.chosen is not None else ())]
    spoils = replace(rule.spoils(found, [name]), records=("staircase",))
    given = "&".join(f"{name}.{key}={value}" for key, value in HIDDEN[name].items())
    with Drive.connect(f"sim:servo?{given}") as drive:
        done, _ = _run(drive, folder, Correction(name, (name,), tuple(changes), spoils, PREDICTED))
    assert done.kept == (name,)
    assert done.rows[0].after < 0.2 * done.rows[0].before


def test_a_correction_that_makes_it_worse_is_taken_back_and_the_other_is_measured_without_it(folder: Path):
    wrong = _sensors(-0.1, 0.03)
    with Drive.connect(PORT) as drive:
        done, said = _run(drive, folder, _lines(), wrong)
        held = drive.get()
    assert done.kept == ("cogging",)
    assert list(done.runs) == ["before", "after", "after-2"]
    assert held["current_correction"] == 0.0 and held["current_offset_a_a"] == 0.0
    assert held["speed_model_ff"] == 1.0
    assert any("current_offset: taken back" in each for each in said)


def test_when_none_helps_the_drive_has_what_it_had(folder: Path):
    with Drive.connect(PORT) as drive:
        before = drive.get()
        done, _ = _run(drive, folder, _lines(0.7 + 3.14159))
        assert done.kept == ()
        assert drive.get() == before


def test_what_this_bench_cannot_measure_is_not_tried(folder: Path):
    loaded = replace(_sensors(), spoils=Quantity("speed_ripple", ("staircase_load",), (3.0,)))
    with Drive.connect(PORT) as drive:
        done, _ = _run(drive, folder, _lines(), loaded)
        assert drive.get(["current_correction"]) == {"current_correction": 0.0}
        alone, _ = _run(drive, folder, loaded)
    assert done.kept == ("cogging",) and "not tried" in done.rows[1].why
    assert list(alone.runs) == ["before"] and alone.kept == ()


def test_a_trip_leaves_the_parameters_from_before(folder: Path):
    trips = replace(_lines(), changes=(*_lines().changes, known("motor_psi_wb", 0.3)))
    with Drive.connect(PORT) as drive:
        before = drive.get()
        with pytest.raises(TrialError, match="parameters from before again") as error:
            _run(drive, folder, trips)
        assert "current_implausible" in str(error.value) and error.value.exit_code == 1
        drive.clear_fault()
        assert drive.get() == before


def test_a_lost_link_says_which_parameters_the_drive_may_have_and_how_to_put_back_the_old_ones(
    folder: Path, monkeypatch
):
    perform, runs = trial_module.perform, []

    def breaks(*given):
        runs.append(given)
        if len(runs) == 2:
            raise LinkLostError("the cable is out")
        return perform(*given)

    monkeypatch.setattr(trial_module, "perform", breaks)
    with Drive.connect(PORT) as drive, pytest.raises(TrialError) as error:
        _run(drive, folder, _lines())
    text = str(error.value)
    assert "may still have speed_model_ff=true rdc_line1_cycles=18" in text
    assert "evenspin bench set speed_model_ff=false rdc_line1_cycles=0" in text
    assert "\n" not in text and error.value.exit_code == LinkLostError.exit_code


@pytest.mark.parametrize(
    ("held", "said"),
    [
        ({"speed_model_ff": 1.0}, ("cogging", "speed_model_ff")),
        ({"rdc_line3_nm": 0.01, "rdc_line3_cycles": 6.0}, ("rdc_line3_nm", "speed_model_ff")),
        ({"position_method": 3.0}, ("rdc_viscous_nms", "position_method")),
        ({"current_correction": 2.0}, ("current_offset", "current_correction")),
        ({"current_sensors": 1.0}, ("current_offset", "current_sensors")),
    ],
)
def test_what_the_drive_corrects_already_or_what_would_act_beside_is_refused_naming_both(folder: Path, held, said):
    with Drive.connect(PORT) as drive:
        drive.set(held)
        before = drive.get()
        with pytest.raises(InputError) as error:
            _run(drive, folder, _lines(), _sensors())
        assert all(word in str(error.value) for word in said)
        assert drive.get() == before


def test_what_makes_all_ripple_of_the_speed_larger_is_taken_back_although_its_own_line_is_smaller(folder: Path):
    beside = (known("rdc_line2_cycles", 7.0), known("rdc_line2_nm", 0.1))  # a torque that no effect has
    with Drive.connect(PORT) as drive:
        done, _ = _run(drive, folder, replace(_lines(), changes=(*_lines().changes, *beside)))
        assert drive.get(["speed_model_ff"]) == {"speed_model_ff": 0.0}
    assert done.rows[0].after < 0.2 * done.rows[0].before
    assert done.kept == () and "all ripple" in done.rows[0].why


def test_the_command_reports_three_columns_keeps_recordings_and_saves_only_when_asked(
    folder: Path, tmp_path: Path, evenspin
):
    (folder / CORRECTION).write_text(correction_toml(_proposal(_lines(), _sensors())))
    out = tmp_path / "applied"
    dry = evenspin("bench", "apply", folder, "--port", PORT, "--out", out, "--dry-run")
    assert dry.status == 0 and "rdc_line1_nm = 0 -> 0.05 N m" in dry.out and not out.exists()

    said = evenspin("bench", "apply", folder, "--port", PORT, "--out", out, "--only", "cogging", "--json")
    assert said.status == 0, said.err
    content = json.loads(said.out)
    assert content["kept"] == ["cogging"] and content["saved"] is False
    (row,) = content["corrections"]
    assert row["after"] < row["predicted_high"] < row["before"]
    assert json.loads((out / "result.json").read_text()) == content
    assert {path.name for path in out.iterdir()} >= {"before", "after", "raw", "report.html", "before.toml"}
    assert (out / "raw" / "after" / "staircase.mcap").is_file()
    assert not list(tmp_path.glob("*.raw"))
    assert tomlkit.parse((out / "before.toml").read_text())["drive"]["speed_model_ff"] is False
    pushed = evenspin("bench", "config", "push", out / "before.toml", "--port", PORT)
    assert pushed.status == 0, pushed.err
    assert "not saved" in said.err

    assert evenspin("bench", "apply", folder, "--port", PORT, "--out", out, "--only", "cogging").status == 2  # measured


def test_the_command_fails_with_1_when_nothing_helps_or_nothing_is_proposed(folder: Path, tmp_path: Path, evenspin):
    (folder / CORRECTION).write_text(correction_toml(_proposal(_lines(3.9))))
    said = evenspin("bench", "apply", folder, "--port", PORT, "--out", tmp_path / "one")
    assert said.status == 1 and "no correction helped" in said.err
    (folder / CORRECTION).write_text(correction_toml(Proposal("short", ("unknown",), (), ())))
    said = evenspin("bench", "apply", folder, "--port", PORT, "--out", tmp_path / "two")
    assert said.status == 1 and "proposes no correction" in said.err
