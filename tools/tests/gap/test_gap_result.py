"""A small case of this project's own drive, from the plan to the files: two short records, two hypotheses.

What is hidden is Coulomb friction of 0.06 N m; it comes from the model file below, not from the code under test.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evenspin.effects import Hypothesis, Scale, hypotheses
from evenspin.gap import investigate as core
from evenspin.gap.acceptance import ExpectedCost
from evenspin.gap.check import checked_case
from evenspin.gap.folder import write_result, write_steps
from evenspin.gap.headline import summary_of
from evenspin.gap.intervals import Interval, Intervals, of_effect, with_model_share
from evenspin.gap.outcome import Validation
from evenspin.gap.plan import meta, perform, plan
from evenspin.gap.result import CaseResult, confidence, result_of
from evenspin.gap.story import page_of, tables_of
from evenspin.gap.thresholds_effects import VARIES_SPREAD
from evenspin.gap.verdict import verdict_json
from evenspin.gap.where import heat_map, ranked
from evenspin.log import write_case
from evenspin.log.gap import gap_of_records
from evenspin.log.tolerance import SIGMA
from evenspin.log.unit import Unit
from evenspin.model import load_machine

TORQUE_NM = 0.06
MACHINE = """\
name = "small"
[plant]
pole_pairs = 3
resistance_ohm = 0.9
ld_h = 2.4e-3
lq_h = 2.4e-3
psi_wb = 0.1
inertia_kgm2 = 8e-4
viscous_nms = 2e-3
rated_current_a = 5.0
rated_torque_nm = 2.2
slots = 18
dc_link_v = 150.0
counts_per_rev = 4000
current_noise_a = 0.015
current_lsb_a = 0.009765625
[drive]
current_kp_v_per_a = 6.0
current_ki_v_per_as = 2260.0
speed_kp_a_per_unit = 0.134
speed_ki_a_per_unit_s = 2.02
speed_error_gain = 1.0
iq_limit_a = 8.0
over_current_a = 20.0
over_voltage_v = 200.0
[effects.coulomb_friction]
torque_nm = 0.06
"""
SECONDS = {"staircase_load": 2.2, "validation": 1.0}


@pytest.fixture(scope="session")
def machine_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("machine") / "small.toml"
    path.write_text(MACHINE)
    return path


@pytest.fixture(scope="session")
def small_case(machine_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("case")
    chosen = [
        replace(e, setup=replace(e.setup, duration_s=SECONDS[e.name]))
        for e in plan(load_machine(machine_file))
        if e.name in SECONDS
    ]
    write_case(folder, meta(chosen, "small"), {e.name: perform(e) for e in chosen})
    return folder


def two_hypotheses(scale: Scale) -> dict[str, Hypothesis]:
    return {k: h for k, h in hypotheses(scale).items() if k in ("coulomb_friction", "viscous_friction")}


@pytest.fixture(scope="session")
def investigation(small_case: Path) -> core.Investigation:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(core, "hypotheses", two_hypotheses)
        return core.Investigation(checked_case(small_case)[0], 2)


@pytest.fixture(scope="session")
def result(small_case: Path, investigation: core.Investigation) -> CaseResult:
    case, said = checked_case(small_case)
    return result_of(case, investigation, investigation.run(), said)


@pytest.fixture(scope="session")
def written(result: CaseResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("written")
    write_result(folder, result, "evenspin gap")
    return folder


@pytest.fixture(scope="session")
def unknown(result: CaseResult, investigation: core.Investigation) -> CaseResult:
    """The same, had the best explanation not been good enough."""
    finding = replace(result.finding, unknown=True, named=())
    return result_of(result.case, investigation, finding)


@pytest.fixture(scope="session")
def partly(result: CaseResult, investigation: core.Investigation) -> CaseResult:
    """The same, had nine times the cost of a healthy unit been left beside it."""
    finding = result.finding
    expected = replace(finding.expected_cost, mean=finding.model.cost / 9.0)
    spread = {"coulomb_friction": 0.05}
    return result_of(
        result.case, investigation, replace(finding, unknown=True, size_spread=spread, expected_cost=expected)
    )


def test_the_hidden_effect_is_named_with_its_size(result: CaseResult) -> None:
    said = verdict_json(result)

    assert said["verdict"] == ["coulomb_friction"]
    assert said["parameters"] == {"coulomb_friction": {"torque_nm": pytest.approx(TORQUE_NM, rel=0.05)}}


def test_the_verdict_is_json_with_the_keys_of_the_result_format(result: CaseResult) -> None:
    said = json.loads(json.dumps(verdict_json(result), allow_nan=False))

    assert said["case"] == "small"
    assert 0.9 < said["confidence"]["coulomb_friction"] <= 1.0
    assert all(isinstance(name, str) and 0.0 <= weight <= 1.0 for name, weight in said["alternatives"])
    assert said["gap_before"] > said["gap_after"] > 0.0


def test_the_gap_closes_to_the_noise_floor_of_the_found_machine(result: CaseResult) -> None:
    # one second of five noisy signals: their rms is known to a few percent
    assert result.after.gap == pytest.approx(gap_of_records(result.noise_floor), rel=0.1)
    assert result.closed == pytest.approx(1.0, abs=0.1)


def test_missing_experiments_are_said_to_limit_the_verdict(result: CaseResult) -> None:
    assert any("without standstill_steps" in warning and "current_filter" in warning for warning in result.warnings)
    assert any("without coast_down" in warning for warning in result.warnings)
    assert not any("without staircase_load" in warning for warning in result.warnings)
    assert "viscous_friction" in verdict_json(result)["cannot_separate"]["coulomb_friction"]


def test_the_interval_holds_the_truth_and_is_wider_than_the_plain_fit(result: CaseResult) -> None:
    (interval,) = result.intervals.of("coulomb_friction")

    assert abs(interval.value - TORQUE_NM) < 2.0 * interval.half
    assert 1e-4 < interval.half < 0.1 * TORQUE_NM
    assert result.intervals.inflation >= 1.0


def test_the_model_file_simulates_to_the_same_gap(result: CaseResult, written: Path) -> None:
    machine = load_machine(written / "model.toml")
    nominal = result.case.meta["motor"]

    factors = {key: machine.plant[key] / nominal[key] for key in ("resistance_ohm", "psi_wb", "inertia_kgm2")}
    factors |= {key: machine.plant[key] / nominal[key] for key in ("ld_h", "lq_h", "viscous_nms")}
    assert factors == pytest.approx(dict(result.unit.factors), rel=1e-6)
    again = Validation(result.case).outcome(Unit(machine.effects, factors))

    # nine digits in the file; a count of the encoder may still fall the other way
    assert again.gap == pytest.approx(result.after.gap, rel=0.01)


def test_the_model_file_says_what_was_added_and_what_is_tolerance(written: Path) -> None:
    text = (written / "model.toml").read_text()

    assert "[effects.coulomb_friction] # added: " in text
    assert "of the tolerance's standard deviation" in text
    assert text.startswith("# Missing in the model: coulomb_friction")


def test_each_step_of_the_loop_has_its_own_before_and_after(result: CaseResult, tmp_path: Path) -> None:
    write_steps(tmp_path, result)
    step = json.loads((tmp_path / "step_1" / "verdict.json").read_text())

    assert sorted(path.name for path in tmp_path.iterdir()) == ["step_1"]
    assert step["added"] == ["coulomb_friction"]
    assert step["gap_before"] == pytest.approx(result.before.gap)
    assert step["gap_after"] < step["gap_before"]
    assert (tmp_path / "step_1" / "small.after.csv").is_file()


def test_unknown_names_nothing_and_changes_nothing(unknown: CaseResult, tmp_path: Path) -> None:
    write_result(tmp_path, unknown, "evenspin gap")
    said = json.loads((tmp_path / "verdict.json").read_text())

    assert said["verdict"] == ["unknown"]
    assert said["parameters"] == {}
    assert said["gap_after"] == said["gap_before"]
    assert said["details"]["nearest"]["gap"] < said["gap_before"]
    assert load_machine(tmp_path / "model.toml").effects == {}


def test_a_name_beside_unknown_is_in_the_verdict_the_model_and_the_confidence(
    result: CaseResult, partly: CaseResult, tmp_path: Path
) -> None:
    write_result(tmp_path, partly, "evenspin gap")
    said = json.loads((tmp_path / "verdict.json").read_text())

    assert said["verdict"] == ["coulomb_friction", "unknown"]
    assert said["parameters"]["coulomb_friction"]["torque_nm"] == pytest.approx(TORQUE_NM, rel=0.05)
    assert set(said["confidence"]) == {"coulomb_friction", "unknown"}
    assert 0.9 < said["shares"]["coulomb_friction"] <= 1.0  # nothing else was hidden
    assert said["gap_after"] < said["gap_before"]
    assert "[effects.coulomb_friction] # added: " in (tmp_path / "model.toml").read_text()
    assert said["details"]["size_spread"] == {"coulomb_friction": 0.05}
    assert "coulomb_friction" in page_of(partly, "evenspin gap").summary


def test_what_is_left_widens_the_intervals_by_the_square_root_of_its_cost(
    result: CaseResult, partly: CaseResult
) -> None:
    """The cost is a sum of squares in standard deviations: noise 9 times as high has 3 times the deviation."""
    (whole,), (wide,) = result.intervals.of("coulomb_friction"), partly.intervals.of("coulomb_friction")
    assert wide.value == pytest.approx(whole.value)
    assert wide.half == pytest.approx(3.0 * whole.half, rel=1e-6)


def test_a_size_that_differs_over_the_log_makes_its_name_less_sure(
    result: CaseResult, partly: CaseResult, investigation: core.Investigation
) -> None:
    finding = replace(partly.finding, size_spread={"coulomb_friction": 0.2})
    differs = result_of(result.case, investigation, finding).confidence["coulomb_friction"]
    assert differs < partly.confidence["coulomb_friction"] < 1.0


def test_an_effect_whose_size_changes_over_the_log_explains_nothing_and_that_is_the_reason(
    result: CaseResult, investigation: core.Investigation
) -> None:
    """As a resistance that drifts: its mean explains most of the log, at a cost that healthy units have."""

    def drifting(spread: float) -> CaseResult:
        sizes = {"coulomb_friction": spread}
        finding = replace(result.finding, named=(), unknown=True, size_spread=sizes, changes=("coulomb_friction",))
        return result_of(result.case, investigation, finding)

    little, much = drifting(1.1 * VARIES_SPREAD), drifting(3.0 * VARIES_SPREAD)
    said = verdict_json(much)

    assert said["verdict"] == ["unknown"] and said["gap_after"] == said["gap_before"]
    assert "the size of coulomb_friction is not the same over the log" in said["left"]["because"][0]
    assert 0.5 < little.confidence["unknown"] < much.confidence["unknown"] < 1.0


def test_without_validation_records_the_gap_is_not_known_and_that_is_said(
    result: CaseResult, investigation: core.Investigation, tmp_path: Path
) -> None:
    case = replace(result.case, experiments={"staircase_load": result.case.experiments["staircase_load"]})
    blindly = result_of(case, investigation, result.finding)

    write_result(tmp_path, blindly, "evenspin gap")
    said = json.loads((tmp_path / "verdict.json").read_text())

    assert said["gap_before"] is None
    assert any("no validation record" in warning for warning in said["warnings"])


def test_the_report_shows_warnings_before_the_story(result: CaseResult) -> None:
    page = page_of(result, "evenspin gap")

    assert [table.title for table in page.tables] == ["What to know"]
    assert len(page.tables[0].rows) == len(result.warnings)
    assert [chapter.title for chapter in page.chapters] == [
        "Where is the gap?",
        "What explains it?",
        "How much does it shrink?",
        "What is left?",
    ]
    assert all(len(row) == len(view.header) for view in tables_of(result) for row in view.rows)


def test_the_headline_says_what_is_missing_how_much_that_explains_and_what_is_left(result: CaseResult) -> None:
    missing, explained, left = summary_of(result)[:3]
    floor = gap_of_records(result.noise_floor)
    share = 100.0 * (result.before.gap - result.after.gap) / (result.before.gap - floor)

    assert missing.startswith("Missing in the model: coulomb_friction (torque_nm = ") and "% sure)" in missing
    assert explained.startswith(f"With that {min(share, 100.0):.0f} % of the gap above noise is explained: ")
    assert left == "What is left is noise."


def test_the_headline_says_where_something_is_left_that_nothing_known_explains(
    unknown: CaseResult, partly: CaseResult
) -> None:
    first, gap, left = summary_of(unknown)[:3]
    (most,) = ranked(unknown.subjects, unknown.residual_after, unknown.residual_after)[:1]

    assert first.startswith("Something is missing that no known effect explains: unknown (")
    assert "explained" not in gap
    assert left.startswith(f"What is left is largest in {most.signal} of {most.record}, {most.what}")
    assert summary_of(partly)[2].startswith("Beside that something is left that no known effect explains, largest in ")


def test_what_speaks_for_a_friction_is_where_the_residual_grows_without_it(result: CaseResult) -> None:
    support = result.support["coulomb_friction"]
    shares = [each.share for each in support]

    assert shares == sorted(shares, reverse=True) and 0.3 < sum(shares) <= 1.0
    assert support[0].signal in ("iq_a", "speed_rad_s")  # friction is a torque
    assert all(each.without > each.with_it for each in support)
    assert support[0].without > 5.0 and support[0].with_it < 2.0
    assert verdict_json(result)["support"]["coulomb_friction"][0]["record"] == support[0].record


def test_the_picture_of_the_gap_comes_before_the_tables(result: CaseResult) -> None:
    assert [picture.name for picture in page_of(result, "evenspin gap").pictures] == ["gap"]


def test_the_shares_of_the_excess_add_up_and_the_heat_map_cools_down(result: CaseResult) -> None:
    ranks = ranked(result.subjects, result.residual_before, result.residual_after)
    heat = heat_map(result.subjects, result.residual_before, result.residual_after)

    assert sum(rank.share for rank in ranks) == pytest.approx(1.0)
    assert ranks[0].signal in ("iq_a", "speed_rad_s")  # friction is a torque
    assert np.nanmax(heat.before) > 10.0
    assert np.nanmax(heat.after) < 4.0


def test_the_interval_of_a_polar_pair_is_that_of_the_plane(result: CaseResult) -> None:
    """sine and cosine of like variance s^2: amplitude has s, phase s / amplitude."""
    motor = result.case.meta["motor"]
    cogging = hypotheses(Scale.of(motor, 4000.0))["cogging"]
    s = 1e-3

    found = {i.parameter: i for i in of_effect(cogging, np.array([0.03, 0.04]), np.diag([s**2, s**2]))}

    assert found["amplitude_nm"].value == pytest.approx(0.05)
    assert found["amplitude_nm"].half == pytest.approx(1.96 * s, rel=1e-3)
    assert found["phase_rad"].half == pytest.approx(1.96 * s / 0.05, rel=1e-3)
    assert found["order"].half == 0.0


def test_an_interval_is_never_narrower_than_two_simulators_differ() -> None:
    """2 % of the parameter or of a radian, in the square beside the fit; nothing on top of what is a whole number."""
    exact = [Interval("cogging", "amplitude_nm", 0.05, 0.0), Interval("cogging", "order", 24.0, 0.0)]
    rough = [Interval("inertia", "factor", 1.5, 0.01), Interval("cogging", "phase_rad", 6.0, 0.02)]

    assert [i.half for i in with_model_share(exact)] == pytest.approx([0.001, 0.0])
    assert [with_model_share([i])[0].half for i in rough] == pytest.approx([0.01 * 2**0.5, 0.02 * 2**0.5])


@pytest.mark.parametrize(
    ("effect", "values", "said"),
    [
        ("inertia", [("factor", 1.2, 0.1)], False),
        ("inertia", [("factor", 1.2, 0.3)], True),
        ("current_offset", [("offset_a_a", 0.2, 0.02), ("offset_b_a", 0.001, 0.02)], False),
        ("cogging", [("phase_rad", 6.0, 1.5)], True),
        ("misalignment", [("second_rel", 0.02, 0.1)], False),
        ("coulomb_friction", [("torque_nm", 0.06, 0.07)], True),
    ],
)
def test_a_parameter_that_its_interval_swallows_is_called_not_identifiable(
    effect: str, values: list[tuple[str, float, float]], said: bool
) -> None:
    found = Intervals(tuple(Interval(effect, *value) for value in values), 1.0)

    assert bool(found.warnings()) == said


def test_the_plan_covers_every_experiment_and_its_records_are_a_sound_case(
    machine_file: Path, small_case: Path
) -> None:
    experiments = plan(load_machine(machine_file))
    served = {effect for e in experiments for effect in e.serves}

    assert [e.name for e in experiments][-2:] == ["validation", "validation_steps"]
    assert len(served) == 20  # the whole vocabulary
    assert checked_case(small_case)[1] == ()
    assert math.isclose(sum(e.setup.duration_s for e in experiments), 43.08, abs_tol=0.01)


def test_deviations_beyond_the_tolerance_are_said(result: CaseResult, investigation: core.Investigation) -> None:
    far = np.zeros(len(SIGMA))
    far[0] = 5.0 * SIGMA[0]
    finding = replace(result.finding, model=replace(result.finding.model, delta=far))

    said = result_of(result.case, investigation, finding).warnings

    assert any("resistance: this unit is 5.0 standard deviations" in warning for warning in said)


def test_a_missing_folder_and_a_model_for_a_case_are_one_line(
    evenspin: Callable[..., Any], small_case: Path, tmp_path: Path
) -> None:
    for words in (
        (tmp_path / "gone", "--out", tmp_path / "a"),
        (small_case, "--model", "guo2024", "--out", tmp_path / "b"),
    ):
        said = evenspin("gap", *words)

        assert said.status == 2
        assert said.err.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == []


def test_a_folder_as_first_word_is_solved_and_json_alone_is_on_stdout(
    evenspin: Callable[..., Any], small_case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(core, "hypotheses", two_hypotheses)

    said = evenspin("gap", small_case, "--out", tmp_path / "out", "--json", "--check")

    assert said.status == 0
    assert json.loads(said.out)["verdict"] == ["coulomb_friction"]
    assert "coulomb_friction" in said.err  # for people
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "correction.toml",
        "figures",
        "manifest.json",
        "model.toml",
        "report.html",
        "scenario.toml",
        "small.after.csv",
        "small.before.csv",
        "verdict.json",
    ]


def test_check_makes_unknown_exit_status_1_and_says_so(
    evenspin: Callable[..., Any], unknown: CaseResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("evenspin.gap.result.investigate", lambda *a, **k: unknown)

    plain = evenspin("gap", "loop", unknown.case.path, "--out", tmp_path / "a")
    checked = evenspin("gap", "loop", unknown.case.path, "--out", tmp_path / "b", "--check")

    assert (plain.status, checked.status) == (0, 1)
    assert "unknown" in plain.out
    assert checked.err.startswith("gap: unknown: small")
    assert (tmp_path / "a" / "step_1" / "model.toml").is_file()


def test_a_folder_with_something_else_in_it_is_left_alone(
    evenspin: Callable[..., Any], small_case: Path, tmp_path: Path
) -> None:
    (tmp_path / "mine.txt").write_text("mine")

    said = evenspin("gap", "loop", small_case, "--out", tmp_path)

    assert (said.status, said.err.count("\n")) == (2, 1)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_the_plan_command_writes_a_case(evenspin: Callable[..., Any], machine_file: Path, tmp_path: Path) -> None:
    said = evenspin("gap", "plan", "--model", machine_file, "--json")

    assert said.status == 0
    listed = json.loads(said.out)
    assert [e["name"] for e in listed["experiments"]][0] == "staircase"
    assert listed["changed"] == {"speed_inline": "false -> true", "speed_source": "mt -> pll"}


def test_a_batch_tells_a_broken_case_and_goes_on(
    evenspin: Callable[..., Any], small_case: Path, tmp_path: Path
) -> None:
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "meta.json").write_text("{}")

    said = evenspin("gap", "batch", broken, "--out", tmp_path / "out")

    assert said.status == 1
    assert "no verdict on broken" in said.err
    (line,) = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert line["error"].startswith(f"{broken}/meta.json: experiments = None")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["summary.json"]


def test_a_batch_of_nothing_is_one_line(evenspin: Callable[..., Any], tmp_path: Path) -> None:
    said = evenspin("gap", "batch", tmp_path, "--out", tmp_path / "out")

    assert (said.status, said.err.count("\n")) == (2, 1)


HEALTHY = ExpectedCost(mean=6800.0, sigma=200.0)


def sure(result: CaseResult, weights: dict[str, float], cost: float = 6800.0, **changes: Any) -> dict[str, float]:
    finding = replace(
        result.finding,
        model=replace(result.finding.model, cost=cost),
        expected_cost=HEALTHY,
        named=tuple(weights),
        weights=weights,
        **changes,
    )
    return confidence(finding, ())


def test_a_second_effect_that_adds_next_to_nothing_is_given_little_confidence(result: CaseResult) -> None:
    little = sure(result, {"dead_time": 64_000.0, "current_loop_delay": 500.0})
    enough = sure(result, {"dead_time": 64_000.0, "current_loop_delay": 6_400.0})

    assert little["current_loop_delay"] < 0.6 < 0.95 < enough["current_loop_delay"] < 1.0
    assert little["dead_time"] > 0.95


def test_confidence_falls_as_what_is_left_nears_the_limit_of_noise(result: CaseResult) -> None:
    at, beyond = (6800.0 + share * HEALTHY.limit for share in (0.99, 3.0))

    assert sure(result, {"inertia": 5000.0}, at)["inertia"] < 0.55
    assert sure(result, {"inertia": 5000.0})["inertia"] > 0.95
    assert sure(result, {}, beyond, unknown=True)["unknown"] > 0.95


def test_more_than_noise_is_said_before_it_makes_a_verdict_unknown() -> None:
    """Times the cost of healthy units: known effects of another simulator left 1.37, unknown ones without a line 2."""
    expected = ExpectedCost(7000.0, 300.0)

    assert not expected.is_significant(7000.0 + 6 * 299.0)
    assert expected.is_significant(1.37 * 7000.0)
    assert expected.excess(1.37 * 7000.0) < expected.limit < expected.excess(2.0 * 7000.0)
    assert ExpectedCost(7000.0, 1000.0).limit == 6000.0


def test_another_explanation_that_does_without_the_name_takes_its_weight(result: CaseResult) -> None:
    alone = confidence(result.finding, ())["coulomb_friction"]
    shared = confidence(result.finding, ((("viscous_friction",), 0.3),))["coulomb_friction"]

    assert shared == pytest.approx(0.7 * alone)
