"""A refused parameter: the one that was asked for, the one that stands against it, and one reason, not two."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from evenspin.bench import Drive
from evenspin.bench.errors import RefusedError


@pytest.fixture(params=["float", "fixed"])
def drive(request: pytest.FixtureRequest) -> Iterator[Drive]:
    from evenspin.bench.ports import virtual_drive
    from evenspin.bench.transport import LocalTransport

    virtual = virtual_drive("sim:guo2024")
    if request.param == "fixed":
        virtual.numeric = "fixed"
        virtual._power_on()
    with Drive(LocalTransport("sim:guo2024", virtual), "sim:guo2024", 0.0, None) as made:
        yield made


def refused(drive: Drive, **values: float) -> str:
    before = drive.get()
    with pytest.raises(RefusedError) as caught:
        drive.set(values)
    assert drive.get() == before  # all or nothing
    text = str(caught.value)
    assert " or cannot " not in text and "\n" not in text
    return text


# The defaults of guo2024: iq_limit_a 10, over_current_a 20, under_voltage_v 10, over_voltage_v 40; the rules are those
# of docs/parameters.md: the limit below what trips, the lower voltage below the upper one.
@pytest.mark.parametrize(
    ("asked", "value", "other", "stands"),
    [
        ("over_current_a", 5.0, "iq_limit_a", "iq_limit_a = 10 A"),
        ("profile_speed_rad_s", 700.0, "over_speed_rad_s", "over_speed_rad_s = 650 rad/s"),
        ("over_voltage_v", 5.0, "under_voltage_v", "under_voltage_v = 10 V"),
        ("under_voltage_v", 45.0, "over_voltage_v", "over_voltage_v = 40 V"),
    ],
)
def test_both_parameters_are_named_whichever_of_them_the_drive_names(
    drive: Drive, asked: str, value: float, other: str, stands: str
) -> None:
    text = refused(drive, **{asked: value})
    assert text.startswith(f"set: {asked} = {value:g}")
    assert f"does not fit {stands}; choose another value, or change {other} first" in text


def test_only_the_one_that_does_not_fit_is_named_of_several(drive: Drive) -> None:
    text = refused(drive, rc_gain=0.3, over_current_a=5.0)
    assert "over_current_a = 5 A: does not fit iq_limit_a = 10 A" in text
    assert "rc_gain" not in text


def test_two_that_do_not_fit_each_other_are_both_named(drive: Drive) -> None:
    text = refused(drive, iq_limit_a=14.0, over_current_a=12.0)
    assert "iq_limit_a = 14 A: does not fit over_current_a = 12 A" in text


def test_what_only_changes_at_rest_says_so_and_what_to_do(drive: Drive) -> None:
    drive.run_speed(30.0)
    text = refused(drive, pole_pairs=5.0)
    assert text == "set: pole_pairs = 5: cannot change from 4 while the bridge is on; stop first"
    drive.command("stop")
    drive.sleep(0.1)
    assert drive.set({"pole_pairs": 5.0}) == {"pole_pairs": 5.0}


def test_a_relation_is_told_as_such_also_while_the_motor_runs(drive: Drive) -> None:
    drive.run_speed(30.0)
    assert "over_current_a = 5 A: does not fit iq_limit_a = 10 A" in refused(drive, over_current_a=5.0)
