"""What goes together in one drive: words for combined methods, refusals that name both parameters, measured pairs."""

from __future__ import annotations

from pathlib import Path

import pytest
from evenspin.errors import EvenspinError, InputError
from evenspin.model import builtin_scenario
from evenspin.model.methods import drive_of_word, method_word, method_words
from evenspin.native import tables
from evenspin.reproduce.combinations import Answer, Pair, coarse_table, pairs, run, verdicts
from evenspin.sim import prepare


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
