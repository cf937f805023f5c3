"""Corrections for verdicts on logs of any drive: predicted and tried on planned experiments."""

from __future__ import annotations

import math
from pathlib import Path

from bench_model import MODEL
from evenspin.bench.experiments import read_experiments
from evenspin.correct.anylog import write_for_log
from evenspin.correct.file import CORRECTION, EXPERIMENTS, read_correction

VERDICT = {
    "case": "log",
    "verdict": ["cogging", "unknown"],
    "parameters": {"cogging": {"amplitude_nm": 0.05, "phase_rad": 0.5, "order": 18.0}},
    "intervals": {"cogging": {"amplitude_nm": {"value": 0.05, "low": 0.048, "high": 0.052}}},
}


def test_a_named_effect_of_a_log_gets_a_correction_on_the_experiments_of_the_plan(tmp_path: Path):
    proposal, why = write_for_log(tmp_path, VERDICT, "servo")

    assert why == "" and proposal is not None
    (correction,) = read_correction(tmp_path).corrections
    assert correction.predicted.corrected < 0.2 * correction.predicted.without
    assert math.isnan(correction.predicted.log)  # nobody has measured it
    amplitude = next(change for change in correction.changes if change.parameter == "rdc_line1_nm")
    assert (round(amplitude.low, 6), round(amplitude.high, 6)) == (0.048, 0.052)
    assert [e.name for e in read_experiments(tmp_path / EXPERIMENTS).experiments] == ["staircase"]
    assert read_correction(tmp_path).unknown


def test_a_model_that_does_not_state_the_drive_gets_none_and_the_reason(tmp_path: Path):
    (tmp_path / "bare.toml").write_text(MODEL.split("[drive]")[0])
    proposal, why = write_for_log(tmp_path, VERDICT, str(tmp_path / "bare.toml"))

    assert proposal is None and "current_kp_v_per_a" in why
    assert not (tmp_path / CORRECTION).exists()


def test_a_name_that_may_be_two_effects_gets_none_and_the_reason(tmp_path: Path):
    name = "cogging or current_offset"
    verdict = {"case": "log", "verdict": [name], "parameters": {name: {"offset_a_a": 0.1}}, "intervals": {}}
    proposal, why = write_for_log(tmp_path, verdict, "servo")

    assert proposal is None and name in why
    assert not (tmp_path / CORRECTION).exists()


def test_a_model_of_the_torque_alone_gets_none_and_the_reason(tmp_path: Path):
    plant = "pole_pairs = 3\npsi_wb = 0.1\ninertia_kgm2 = 8e-4\nviscous_nms = 4e-4\n"
    (tmp_path / "torque.toml").write_text(f'name = "torque"\n[plant]\n{plant}')
    proposal, why = write_for_log(tmp_path, VERDICT, str(tmp_path / "torque.toml"))

    assert proposal is None and "resistance_ohm" in why


def test_pure_unknown_corrects_nothing(tmp_path: Path):
    verdict = {"case": "log", "verdict": ["unknown"], "parameters": {}, "intervals": {}}

    assert write_for_log(tmp_path, verdict, "servo") == (None, "")
    assert not (tmp_path / CORRECTION).exists()
