"""What goes together in one drive: words for combined methods, refusals that name both parameters, measured pairs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from evenspin.errors import EvenspinError, InputError
from evenspin.model import builtin_scenario
from evenspin.model.methods import drive_of_word, method_word, method_words
from evenspin.native import tables
from evenspin.reproduce.combination_options import OPTIONS, REFUSED, Found, Trial, option_tables, refused_table, trials
from evenspin.reproduce.combination_options import run as run_options
from evenspin.reproduce.combinations import Answer, Pair, coarse_table, pairs, run, verdicts
from evenspin.sim import prepare, simulate


def refusal(scenario: str, **drive: str | float) -> str:
    numbers = {name: tables().params[name].to_number(value) for name, value in drive.items()}
    with pytest.raises(EvenspinError) as caught:
        prepare(builtin_scenario(scenario).with_changes(numbers), ("speed_rad_s",))
    return str(caught.value)


@pytest.mark.parametrize(
    ("scenario", "drive", "first", "second"),
    [
        (
            "guo2024/first",
            {"method": "dob", "disturbance_observer": "aro"},
            "disturbance_observer = aro",
            "method = dob",
        ),
        (
            "guo2024/first",
            {"method": "forc", "rc_freeze_above_unit": 9.0},
            "rc_freeze_above_unit = 9",
            "rc_memory = keep",
        ),
        ("yeh2024/rpm20", {"method": "forc"}, "method = forc", "control_mode = position"),
        ("yeh2024/rpm20", {"method": "ro", "position_method": "src"}, "position_method = src", "method = ro"),
        ("yeh2024/rpm20", {"method": "dob", "position_method": "silc"}, "position_method = silc", "method = dob"),
        (
            "yeh2024/rpm20",
            {"disturbance_observer": "aro", "rdc_learn_gain": 0.3},
            "rdc_learn_gain = 0.3",
            "disturbance_observer = aro",
        ),
    ],
)
def test_what_does_not_go_together_is_refused_with_both_names_and_what_to_do(
    scenario: str, drive: dict[str, str | float], first: str, second: str
) -> None:
    text = refusal(scenario, **drive)
    assert text.startswith(f"{first}: does not go with {second}: ")
    assert len(text.splitlines()) == 1
    assert any(hint in text for hint in ("use ", "set one", "position_method = src is"))


def test_every_method_word_and_its_drive_parameters_lead_to_each_other() -> None:
    defaults = {name: field.default for name, field in tables().params.items()}
    for word in method_words():
        expected = word.removeprefix("pi+")  # an observer beside nothing has its own name
        assert method_word({**defaults, **drive_of_word(word)}) == expected


def test_method_word_that_nobody_knows_is_refused_with_the_nearest_one() -> None:
    with pytest.raises(InputError) as caught:
        drive_of_word("fal-forc+dbo")
    assert "fal-forc+dob" in str(caught.value)


def test_repetitive_control_and_an_observer_both_act() -> None:
    setup = builtin_scenario("guo2024/first").with_changes(drive_of_word("fal-forc+dob"))
    simulation = prepare(setup, ("rc_out_unit", "compensation_a"))
    rows = simulation.run(5000, 10)
    assert abs(rows).max(axis=0).min() > 0.1


# ---- what goes with what: `make combinations` runs all pairs, this a few; both against the same rule

SAMPLE = [
    Pair("speed", loop, observer, "pi") for loop in ("pi", "fal-forc, angle") for observer in ("none", "dob", "aro")
] + [Pair("position", loop, observer, "pi") for loop in ("ppi", "rdc") for observer in ("none", "dob", "aro", "ro")]


def test_accepted_pairs_act_and_leave_less_than_the_worse_of_the_two_and_refused_ones_are_named() -> None:
    refused = [Pair("position", "silc", "dob", "pi"), Pair("position", "crc", "none", "pi")]
    judged = list(verdicts(run([*SAMPLE, *refused])))

    assert [text for _, text, good in judged if not good] == []
    assert [answer.refused for answer, _, _ in judged] == [False] * len(SAMPLE) + [True] * len(refused)


def test_the_page_has_a_row_for_every_pair() -> None:
    page = (Path(__file__).parents[2] / "docs" / "combinations.md").read_text(encoding="utf-8")

    for pair in pairs():
        assert f"| {pair.loop} | {pair.observer} | {pair.current} |" in page


def test_a_pair_that_does_nothing_or_harm_or_is_refused_without_a_name_fails() -> None:
    alone, with_dob = Pair("speed", "crc", "none", "pi"), Pair("speed", "crc", "dob", "pi")
    dob = Pair("speed", "pi", "dob", "pi")

    def good(answer: Answer) -> bool:
        return list(verdicts([Answer(alone, 3.0), Answer(dob, 4.0), answer]))[-1][2]

    assert good(Answer(with_dob, 2.0))
    assert good(Answer(with_dob, 3.9))
    assert not good(Answer(with_dob, 3.0))  # as without
    assert not good(Answer(with_dob, 4.5))
    assert not good(Answer(with_dob, float("nan"), "the numbers do not fit"))
    assert len(set(pairs())) == len(pairs()) > 90


def test_on_a_coarse_encoder_nothing_that_is_default_harms() -> None:
    """Samples and cells that fall into step harm with the published memory only, which the table shows beside it."""
    rows = {(row[0], row[1]): row for row in coarse_table().rows}
    assert rows["aro", "200 cells, write one (as printed)"][3].startswith("HARMS")
    assert all(row[3] == "good" for (_, memory), row in rows.items() if "as printed" not in memory)
    assert tables().params["aro_write"].choices[int(tables().params["aro_write"].default)] == "hat"


# ---- options beside the methods, and everything that is refused because of a second parameter


def test_every_rule_of_the_drive_has_an_example_that_it_refuses_with_both_parameters_of_that_rule() -> None:
    rules = {rule.name: rule for rule in tables().combinations}
    assert set(REFUSED) == set(rules)
    view = refused_table()
    assert not any(view.marks)
    for row, rule in zip(view.rows, rules.values(), strict=True):
        assert (row[0].split(" = ")[0], row[1].split(" = ")[0]) == (rule.param, rule.other)
        assert row[2].startswith(rule.why)


def test_a_rule_whose_example_is_taken_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(REFUSED, "third_gain", {"current_correction": "fixed"})  # type: ignore[attr-defined]
    view = refused_table()
    assert [mark for mark in view.marks if mark] == ["bad"]


def test_options_act_in_a_loop_and_bring_it_to_where_there_is_nothing_to_correct() -> None:
    chosen = [
        Trial("current_correction = learned", "speed", "fal-forc", "none"),
        Trial("current_correction = learned", "position", "ppi", "none"),
        Trial("dead_time_s = 1.5e-06", "speed", "pi", "none"),
        Trial("speed_model_ff = 1", "speed", "pi", "none"),
    ]
    found = run_options(chosen)
    assert [each.verdict for each in found] == ["works"] * len(chosen)
    for each in found:
        assert each.off > 2.0 * each.ideal
        assert each.on - each.ideal < 0.15 * (each.off - each.ideal)  # dead time with a hard sign leaves a tenth


@pytest.mark.parametrize(
    ("ideal", "off", "on", "verdict"),
    [
        (0.0, 1.0, 0.2, "works"),
        (0.5, 0.3, 0.5, "works"),  # what is corrected happened to help
        (0.0, 1.0, 1.09, "works"),
        (0.0, 1.0, 1.11, "FAILED: harms"),
        (0.0, 1.0, 1.0, "FAILED: does nothing"),
        (0.0, 1.0, float("nan"), "FAILED: harms"),
    ],
)
def test_an_option_that_does_nothing_or_harm_fails(ideal: float, off: float, on: float, verdict: str) -> None:
    assert Found(trials()[0], ideal, off, on).verdict == verdict


def test_the_page_has_every_option_in_every_loop_and_every_refusal() -> None:
    page = (Path(__file__).parents[2] / "docs" / "combinations.md").read_text(encoding="utf-8")
    for option in OPTIONS:
        part = page.partition(f"## `{option.name}`")[2].partition("## ")[0]
        for trial in trials():
            if trial.option == option.name:
                assert f"| {trial.mode} | {trial.loop} | {trial.observer} |" in part
    for row in refused_table().rows:
        assert f"| {' | '.join(row)} |" in page
    assert all(view.text in page for view in option_tables([]))


def test_the_model_of_speed_mode_has_no_effect_in_position_mode() -> None:
    drive, errors = Pair("position", "ppi", "aro", "pi").drive(), []
    for change in ({}, {"speed_model_ff": 1.0, "rdc_line1_cycles": 24.0, "rdc_line1_nm": 0.14}):
        setup = builtin_scenario("yeh2024/rpm20").with_changes({**drive, **change})
        errors.append(simulate(replace(setup, duration_s=4.0), ("position_error_rad",))["position_error_rad"])
    assert (errors[0] == errors[1]).all()
