"""correction.toml is read as it was written; what was commanded is found again in a record."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from evenspin.correct.changes import known, moved, scaled
from evenspin.correct.commands import commanded
from evenspin.correct.file import CORRECTION, correction_toml, read_correction
from evenspin.correct.predict import Prediction
from evenspin.correct.proposal import Correction, NotCorrected, Proposal
from evenspin.correct.quantities import Quantity
from evenspin.errors import InputError
from evenspin.gap import plan as planning
from evenspin.log.case import Case
from evenspin.model.machine import builtin_models, load_machine

CHANGES = (
    known("current_correction", "fixed"),
    known("speed_model_ff", 1.0),
    known("rdc_line1_nm", 0.05, 0.001),
    moved("encoder_offset_rad", -0.1, 0.02),
    scaled("speed_kp_a_per_unit", 1.2, 0.03),
)
PROPOSAL = Proposal(
    "a case",
    ("cogging", "backlash", "unknown"),
    (
        Correction(
            "cogging", ("cogging",), CHANGES, Quantity("speed_ripple", ("staircase",), (18.0,)),
            Prediction(math.nan, 0.01, 2.0, 0.1, 0.05, 0.15),
        ),
    ),
    (NotCorrected("backlash", "no controller takes a gap away"),),
)  # fmt: skip


def test_what_is_written_is_read_again(tmp_path: Path):
    (tmp_path / CORRECTION).write_text(correction_toml(PROPOSAL))
    again = read_correction(tmp_path)

    assert (again.case, again.verdict, again.left) == (PROPOSAL.case, PROPOSAL.verdict, PROPOSAL.left)
    (correction,) = again.corrections
    assert correction.spoils == PROPOSAL.corrections[0].spoils
    assert math.isnan(correction.predicted.log)
    assert correction.predicted.corrected == 0.1
    for before, after in zip(CHANGES, correction.changes, strict=True):
        assert (after.parameter, after.how) == (before.parameter, before.how)
        assert (after.value, after.low, after.high) == pytest.approx((before.value, before.low, before.high))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"rdc_line1_nm"', '"rdc_line9_nm"', "did you mean"),
        ("value = 0.05", "value = -0.05", "0 .. 1000"),
        ('"fixed"', '"exact"', "fixed"),
        ("value = true", "value = 0.5", "true or false"),
        ('"speed_ripple"', '"noise"', "speed_ripple"),
        ('change = "add"', 'change = "minus"', "add"),
        ("records", "record", "record"),
    ],
)
def test_a_wrong_entry_is_one_line_with_file_and_what_is_allowed(tmp_path: Path, old, new, said):
    text = correction_toml(PROPOSAL)
    assert old in text
    (tmp_path / CORRECTION).write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=said) as error:
        read_correction(tmp_path)
    assert "\n" not in str(error.value) and CORRECTION in str(error.value)


def test_references_and_loads_of_a_record_are_commanded_again_as_few_points():
    machine = load_machine(builtin_models()["servo"])
    plan = planning.plan(machine, 1)
    wanted = {e.name: e for e in plan if e.name in ("staircase_load", "reversal", "coast_down", "standstill_steps")}
    records = {name: planning.perform(e) for name, e in wanted.items()}
    # the reading of a torque sensor: 1 % of the rated torque of noise
    noisy = records["staircase_load"].values.copy()
    noisy[:, -1] += np.random.default_rng(1).normal(0.0, 0.022, len(noisy))
    records["staircase_load"] = type(records["staircase_load"])(
        records["staircase_load"].names, records["staircase_load"].units, noisy
    )
    case = Case(Path("case"), planning.meta(plan, "case"), records)

    found = {e.name: e for e in commanded(case, list(records))}

    assert set(found) == set(records)
    for name, experiment in found.items():
        record = records[name]
        assert experiment.duration_s == pytest.approx(wanted[name].setup.duration_s, abs=0.002)
        for key, curve in experiment.curves.items():
            assert (
                len(curve.t_s) < 60
            )  # the ramps of reversal bend 12 times, the steps of a locked rotor come 18 at most
            largest = max(map(abs, curve.value))
            again = np.array([experiment.value(key, float(t)) for t in record["t_s"][::20]])
            off = np.abs(again - record[key][::20]) if key != "load_torque_nm" else np.abs(again - 1.1)
            # 2 % of the noise's mean over a stretch; a step may be one row away
            assert np.quantile(off, 0.97) <= 0.01 * largest, (name, key)
    assert found["coast_down"].current_from_s == pytest.approx(1.2, abs=0.01)
    assert found["standstill_steps"].rotor_locked and found["standstill_steps"].mode == "current"
    assert list(found["staircase_load"].curves["load_torque_nm"].t_s) == [0.0]
