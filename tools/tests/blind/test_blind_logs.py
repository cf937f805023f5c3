"""Logs of other drives: what is planned and made, and how verdicts on them are judged."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from evenspin.blind import bench_drives
from evenspin.blind.bench_effects import EFFECTS, OUTSIDE, true_values
from evenspin.blind.log_page import page
from evenspin.blind.log_score import LogScore, Run, missed, score_log, summary_of
from evenspin.blind.logs import LogTruth, make_log, plan_logs, read_log_truth
from evenspin.blind.referee import with_effects
from evenspin.cli.gap_blind import app
from evenspin.errors import CheckFailedError, InputError
from evenspin.native import tables
from typer.testing import CliRunner


def truth(
    effects: dict[str, dict[str, float]],
    outside: dict[str, dict[str, float]] | None = None,
    voltage: str = "dq",
    load: bool = False,
) -> LogTruth:
    kind = "outside" if outside else ("none", "single", "pair")[len(effects)]
    drive = {"other.angle_delay_s": 0.0, "other.most_torque_per_ampere": 0.0, "other.speed_by_difference": 1.0}
    return LogTruth(
        "a/b.csv", kind, "small", effects, outside or {}, "vesc", 500.0, 60.0, 30000, voltage, load, 0.5, drive
    )


def said(names: list[str], hidden: LogTruth, **more: object) -> LogScore:
    return score_log("log_1_0001", hidden, Run(3.0, 0, ""), {"verdict": names} | more)


COGGING = {"cogging": {"amplitude_nm": 0.1, "phase_rad": 1.0, "order": 24.0}}
RESISTANCE = {"winding_resistance": {"factor": 1.5}}
KT = {"torque_constant": {"factor": 0.9}}


def test_the_same_seed_is_the_same_plan_with_all_kinds() -> None:
    plans = plan_logs(60, 3)

    assert plans == plan_logs(60, 3) != plan_logs(60, 4)
    kinds = [plan.kind for plan in plans]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == {"single": 30, "pair": 9, "none": 9, "outside": 12}
    assert {plan.names[0] for plan in plans if plan.kind == "single"} == set(EFFECTS)
    assert 0.4 < np.mean([plan.voltages for plan in plans]) < 0.85


def test_effects_are_those_of_the_table_but_for_what_belongs_to_a_controller() -> None:
    missing = set(tables().effects) - set(EFFECTS)

    assert set(EFFECTS) < set(tables().effects)
    assert missing == {"current_loop_delay", "current_filter", "torque_ripple", "empirical", "empirical_voltage"}
    assert not set(OUTSIDE) & set(tables().effects)


@pytest.mark.parametrize("effect", EFFECTS)
def test_what_is_hidden_is_beyond_what_a_unit_on_a_bench_may_be(effect: str) -> None:
    """The smallest draw of every effect that is a tolerance, too, against the bound of that tolerance."""
    rng = np.random.default_rng(5)
    drive = bench_drives.draw_drive(rng)
    motor, bench = drive.meta["motor"], bench_drives.BENCH
    rated_a, rated_nm = motor["rated_current_a"], motor["rated_torque_nm"]
    drawn = [EFFECTS[effect](rng, drive, 0) for _ in range(50)]

    def least(key: str) -> float:
        return min(abs(values[key]) for values in drawn)

    def least_factor() -> float:
        return min(max(v["factor"], 1.0 / v["factor"]) - 1.0 for v in drawn)

    smallest = {
        "winding_resistance": lambda: least_factor() / bench["resistance"],
        "torque_constant": lambda: least_factor() / bench["flux"],
        "inertia": lambda: least_factor() / bench["inertia"],
        "viscous_friction": lambda: least_factor() / bench["viscous"],
        "encoder_offset": lambda: least("angle_el_rad") / bench["electrical_zero_rad"],
        "dead_time": lambda: least("dead_time_s") * drive.meta["pwm_hz"] / bench["dead_time_of_link"],
        "coulomb_friction": lambda: least("torque_nm") / rated_nm / bench["coulomb_of_rated"],
        "load_torque": lambda: least("torque_nm") / rated_nm / bench["load_of_rated"],
        "cogging": lambda: least("amplitude_nm") / rated_nm / bench["cogging_of_rated"],
        "encoder_eccentricity": lambda: least("amplitude_rad") / bench["eccentricity_rad"],
        "current_offset": lambda: min(math.hypot(*v.values()) for v in drawn) / rated_a / bench["offset_of_rated"],
        "current_gain": lambda: min(abs(v["gain_a"] / v["gain_b"] - 1.0) for v in drawn) / (2.0 * bench["gain"]),
    }
    assert smallest.get(effect, lambda: 2.0)() > 1.5


def test_the_truth_is_what_the_unit_is_beside_its_model_file() -> None:
    rng = np.random.default_rng(6)
    drive = bench_drives.draw_drive(rng)
    nominal = bench_drives.nominal_of(drive)
    unit = bench_drives.draw_bench_unit(rng, drive, nominal)
    hidden = with_effects(unit, {"inertia": {"factor": 1.5}})

    found = true_values("inertia", {"factor": 1.5}, hidden, nominal)

    assert found["factor"] == pytest.approx(1.5 * unit["motor.inertia_kgm2"] / nominal["motor.inertia_kgm2"])
    assert found["factor"] != pytest.approx(1.5, rel=1e-4)


def test_a_log_is_made_with_its_model_and_without_a_word_of_what_is_hidden(tmp_path: Path) -> None:
    plan = next(p for p in plan_logs(60, 2) if p.style == "vesc" and p.kind == "single")

    made = make_log(plan, tmp_path / plan.log)

    assert (tmp_path / made.file).read_text().startswith("ms_today;input_voltage;")
    assert sorted(path.name for path in (tmp_path / plan.log).iterdir()) == ["model.toml", "recording.csv"]
    model = tomllib.loads((tmp_path / plan.log / "model.toml").read_text())
    assert set(model) == {"name", "plant"}  # no effects
    assert model["plant"]["inertia_kgm2"] != pytest.approx(made.unit["motor.inertia_kgm2"], rel=1e-4)
    assert made.rows == pytest.approx(made.rate_hz * made.seconds, abs=1)


def test_only_the_very_set_is_right() -> None:
    assert said(["cogging"], truth(COGGING)).exact
    assert not said(["cogging", "inertia"], truth(COGGING)).exact
    assert said(["cogging", "inertia"], truth(COGGING)).wrong == ("inertia",)
    assert not said([], truth(COGGING)).exact
    assert said(["none"], truth({})).exact
    assert not said(["unknown"], truth({})).exact


def test_a_name_that_leaves_it_open_is_neither_right_nor_wrong() -> None:
    score = said(["inertia or torque_constant"], truth(KT))

    assert (score.exact, score.undecided, score.wrong) == (False, True, ())
    assert said(["inertia or viscous_friction"], truth(KT)).wrong == ("inertia or viscous_friction",)


def test_a_foreign_effect_is_unknown_and_nothing_else() -> None:
    hidden = truth({}, {"fan_load": {"torque_nm_s2": 1e-3}})

    assert said(["unknown"], hidden).exact
    assert said(["viscous_friction", "unknown"], hidden).wrong == ("viscous_friction",)
    assert not said(["viscous_friction", "unknown"], hidden).exact
    assert not said([], hidden).exact


@pytest.mark.parametrize("hidden", [RESISTANCE, KT])
def test_what_a_log_without_voltages_cannot_show_has_to_stay_without_another_name(hidden: dict) -> None:
    dark = truth(hidden, voltage="")

    assert said([], dark).exact
    assert said(["unknown"], dark).exact
    assert said(["inertia"], dark).wrong == ("inertia",)
    assert not said(["inertia"], dark).exact
    assert not said([], truth(hidden)).exact


def test_a_measured_load_shows_the_torque_constant_without_voltages() -> None:
    assert not said([], truth(KT, voltage="", load=True)).exact


def test_ampere_equivalents_are_held_against_torque() -> None:
    """0.5 N m/A: 0.22 A are 0.11 N m, 10 % too much; the interval 0.19 .. 0.21 A holds 0.1 N m."""
    found = {"cogging": {"amplitude_a_equiv": 0.22, "order": 24, "phase_rad": 1.0}}
    intervals = {"cogging": {"amplitude_a_equiv": {"value": 0.2, "low": 0.19, "high": 0.21}}}

    score = said(["cogging"], truth(COGGING), parameters=found, intervals=intervals)

    assert score.errors["cogging.amplitude_nm"] == pytest.approx(0.1)
    assert score.misses[0][1] == pytest.approx(0.0, abs=1e-9)


def test_the_summary_counts_each_log_where_it_belongs() -> None:
    scores = [
        said(["cogging"], truth(COGGING), confidence={"cogging": 0.95}),
        said(["inertia"], truth(COGGING), confidence={"inertia": 0.95}),
        said(["inertia"], truth(RESISTANCE, voltage="")),
        said([], truth({})),
        said(["unknown"], truth({}, {"fan_load": {}})),
        score_log("log_1_0009", truth(COGGING, voltage=""), Run(70.0, 2, "cannot read"), None),
    ]

    summary = summary_of(scores)

    assert summary["exact_single"] == 0.5
    assert summary["exact_single_torque_only"] == 0.0
    assert summary["named_without_voltages"] == 1.0
    assert summary["clean"] == summary["unknown_on_outside"] == 1.0
    assert summary["wrong_name"] == pytest.approx(2 / 6)
    assert summary["read"] == pytest.approx(5 / 6)
    assert summary["sure_and_right"] == 0.5
    assert "slowest_s" in missed(summary)
    assert "| 1 x cannot read |" in page(scores, "1") or "* 1 x cannot read" in page(scores, "1")


def test_the_command_scores_what_it_made(tmp_path: Path) -> None:
    def call(*words: object) -> str:
        result = CliRunner().invoke(app, [str(word) for word in words])
        if result.exception is not None:
            raise result.exception
        return result.output

    logs, kept, page_file = tmp_path / "logs", tmp_path / "logs_truth.json", tmp_path / "page.md"
    call("make-logs", "--out", logs, "--count", 1, "--seeds", "1", "--jobs", 1)
    name, made = next(iter(read_log_truth(kept).items()))
    (tmp_path / "verdicts" / name).mkdir(parents=True)
    right = {"verdict": [*made.effects] + ["unknown"] * bool(made.outside)}
    (tmp_path / "verdicts" / name / "verdict.json").write_text(json.dumps(right))

    out = json.loads(
        call("score-logs", "--truth", kept, "--results", tmp_path / "verdicts", "--markdown", page_file, "--json")
    )

    assert [log["exact"] for log in out["logs"]] == [True]
    assert page_file.read_text().startswith("<!-- Made by `make blind-logs`.")
    (tmp_path / "verdicts" / name / "verdict.json").write_text(json.dumps({"verdict": ["two_mass", "backlash"]}))
    with pytest.raises(CheckFailedError, match="wrong_name"):
        call("score-logs", "--truth", kept, "--results", tmp_path / "verdicts", "--check")
    with pytest.raises(InputError, match="new or empty"):
        call("make-logs", "--out", logs, "--count", 1)
    with pytest.raises(InputError, match="different whole numbers"):
        call("make-logs", "--out", tmp_path / "more", "--seeds", "1,1")
