"""What goes together in one drive: words for combined methods, and refusals that name both parameters."""

from __future__ import annotations

import pytest
from evenspin.errors import EvenspinError, InputError
from evenspin.model import builtin_scenario
from evenspin.model.methods import drive_of_word, method_word, method_words
from evenspin.native import tables
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
        ("yeh2024/rpm20", {"method": "ro", "position_method": "silc"}, "position_method = silc", "method = ro"),
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
