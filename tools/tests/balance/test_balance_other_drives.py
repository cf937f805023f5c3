"""Logs of a drive that is nothing of the package's: what is named, and whether intervals hold what was put in."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy_drive as drive
import pytest
from evenspin.balance import BalanceResult, run_balance
from evenspin.balance.log_reader import read_log
from evenspin.balance.stretches import stretches_of, thue_morse
from evenspin.balance.time_grid import grid_of
from evenspin.errors import InputError
from evenspin.model.machine import load_machine

SWEEP = drive.Machine(duration_s=12.0, period_s=6.0)
STEP = drive.Machine(cogging_a=0.2286, knots=drive.steps((10.0, 6.0), (25.0, 6.0)), duration_s=12.0)


def balance(folder: Path, machine: drive.Machine, *, model: bool, **changes: Any) -> BalanceResult:
    columns = drive.run(machine) | changes
    given = drive.model_file(folder / "given.toml", machine) if model else None
    return run_balance(drive.write(folder / "log.csv", columns), given, None)


def missed(verdict: dict[str, Any], machine: drive.Machine) -> list[tuple[str, float, float, float]]:
    return [row for row in drive.intervals(verdict, machine) if abs(row[2] - row[1]) > row[3]]


@pytest.mark.parametrize(("cogging_a", "model"), [(0.057, True), (0.229, False)])
def test_a_swept_log_with_cogging_tells_inertia_friction_and_line(
    tmp_path: Path, cogging_a: float, model: bool
) -> None:
    machine = replace(SWEEP, cogging_a=cogging_a)

    verdict = balance(tmp_path, machine, model=model).verdict

    assert drive.names_wrong(verdict, machine) == []
    assert missed(verdict, machine) == []
    inertia = verdict["identified"]["inertia.inertia_as2_per_rad"]
    assert inertia["half"] < 0.1 * inertia["value"]  # an interval that is everything holds everything


def test_a_step_of_the_speed_in_the_middle_is_no_second_experiment(tmp_path: Path) -> None:
    verdict = balance(tmp_path, STEP, model=False).verdict

    assert drive.names_wrong(verdict, STEP) == []
    assert missed(verdict, STEP) == []
    assert verdict["parameters"]["cogging"]["amplitude_half_a_equiv"] < 0.1 * STEP.cogging_a
    assert not any("linearly" in text for text in verdict["unexplained"])


def test_friction_of_one_direction_is_given_as_friction_or_load_with_what_would_separate_them(tmp_path: Path) -> None:
    result = balance(tmp_path, STEP, model=True)

    assert "coulomb_friction or load_torque" in result.verdict["verdict"]
    assert result.verdict["cannot_separate"]["coulomb_friction"] == ["load_torque"]
    assert any("other direction" in text for text in result.warnings)


def test_a_current_of_the_wrong_sign_is_refused_and_nothing_is_named(tmp_path: Path) -> None:
    columns = drive.run(SWEEP)

    with pytest.raises(InputError, match="opposite sign of iq_a"):
        balance(tmp_path, SWEEP, model=True, iq_a=-columns["iq_a"])


def test_a_drag_that_falls_with_the_speed_is_no_negative_friction(tmp_path: Path) -> None:
    columns = drive.run(SWEEP)
    folder = tmp_path / "out"
    folder.mkdir()
    changed = columns | {"iq_a": columns["iq_a"] - 8.0 * SWEEP.viscous_as * columns["speed_rad_s"]}

    verdict = run_balance(drive.write(tmp_path / "log.csv", changed), None, folder).verdict

    assert any("would be negative" in text for text in verdict["unexplained"])
    assert "viscous_friction.viscous_as_per_rad" not in verdict["identified"]
    assert load_machine(folder / "model.toml").plant["viscous_nms"] == 0.0


def test_a_speed_in_revolutions_per_minute_is_reported_where_the_model_knows_the_inertia(tmp_path: Path) -> None:
    columns = drive.run(SWEEP)
    del columns["theta_m_rad"]
    columns["speed_rad_s"] = columns["speed_rad_s"] * 60.0 / (2.0 * np.pi)

    model = drive.model_file(tmp_path / "m.toml", SWEEP)
    with pytest.raises(InputError, match="speed_rad_s in r/min"):
        run_balance(drive.write(tmp_path / "log.csv", columns), model, None)


def test_the_model_that_is_written_gives_the_gap_that_was_reported(tmp_path: Path) -> None:
    machine = replace(SWEEP, cogging_a=0.12)
    log = drive.write(tmp_path / "log.csv", drive.run(machine))
    given = drive.model_file(tmp_path / "given.toml", machine)
    folder = tmp_path / "out"
    folder.mkdir()

    first = run_balance(log, given, folder).verdict
    load_machine(folder / "model.toml")
    again = run_balance(log, folder / "model.toml", None).verdict

    assert again["verdict"] == []
    assert again["gap_before"] == pytest.approx(first["gap_after"], rel=0.02)


def test_a_model_without_inertia_is_not_held_against_that_of_another_machine(tmp_path: Path) -> None:
    log = drive.write(tmp_path / "log.csv", drive.run(SWEEP))
    verdict = run_balance(log, drive.model_file(tmp_path / "m.toml", SWEEP, inertia=False), None).verdict

    assert drive.names_wrong(verdict, SWEEP) == []
    assert missed(verdict, SWEEP) == []


@pytest.mark.parametrize("model", [True, False])
def test_a_measured_load_is_taken_off_the_current_or_said_to_be_unused(tmp_path: Path, model: bool) -> None:
    columns = drive.run(SWEEP)
    load_a = 0.3 * (columns["t_s"] > 5.0)  # as a load machine would have put on
    changes = {"iq_a": columns["iq_a"] + load_a, "load_torque_nm": load_a * drive.KT, "vq_v": load_a}

    result = balance(tmp_path, SWEEP, model=model, **changes)

    said = " ".join(result.warnings)
    assert "vq_v: not used" in said
    assert ("load_torque_nm: taken off" in said) is model
    assert ("load_torque_nm: not used" in said) is not model
    assert ("load_torque" in result.verdict["verdict"]) is not model or not result.verdict["clear"]
    if model:
        assert result.verdict["verdict"] == ["coulomb_friction"]


def test_what_no_effect_explains_is_no_all_clear(tmp_path: Path) -> None:
    """A load that comes and goes with the time: nothing of the table, and much more than noise."""
    columns = drive.run(SWEEP)
    odd_a = 0.3 * np.sin(2.0 * np.pi * 0.9 * columns["t_s"]) ** 3

    result = balance(tmp_path, SWEEP, model=True, iq_a=columns["iq_a"] + odd_a)

    assert not result.verdict["clear"]
    assert any("noise alone" in text for text in result.verdict["unexplained"])
    assert not any("nothing that stands out" in text for text in result.summary)


def test_a_long_rest_is_left_out_and_reported(tmp_path: Path) -> None:
    machine = drive.Machine(
        knots=((0.0, 0.0), (4.0, 0.0), (8.0, 20.0), (12.0, -20.0), (16.0, 20.0)), duration_s=16.0, cogging_a=0.03
    )
    result = balance(tmp_path, machine, model=True)

    assert any("rests for" in text for text in result.warnings)
    assert missed(result.verdict, machine) == []


def test_stretches_that_fit_and_that_validate_have_the_same_speeds(tmp_path: Path) -> None:
    for machine in (SWEEP, STEP):
        grid = grid_of(read_log(drive.write(tmp_path / "log.csv", drive.run(machine))))
        found = stretches_of(grid)

        edges = np.linspace(found.slow_rad_s.min(), found.slow_rad_s.max() + 1e-9, 6)
        fits, validates = (
            np.histogram(found.slow_rad_s[part & ~found.idle], edges)[0] / np.count_nonzero(part & ~found.idle)
            for part in (found.fits, ~found.fits)
        )

        assert fits == pytest.approx(validates, abs=0.12)  # halves of the step would differ by 1
        assert 0.4 < np.mean(found.fits) < 0.6


def test_the_order_of_the_stretches_has_no_period() -> None:
    turns = np.where(thue_morse(64), 1.0, -1.0)

    for period in (2, 4, 6, 8, 10, 16):
        wave = np.exp(2j * np.pi * np.arange(64) / period)
        assert abs(np.mean(turns * wave)) < 0.5  # a strict alternation would be 1 at period 2


@pytest.mark.parametrize(
    "machine",
    [
        replace(SWEEP, cogging_a=0.22, order=24, counts=2**12, swing_rad_s=50.0, coulomb_a=0.04, noise_a=0.0025),
        replace(STEP, cogging_a=0.209, order=72, counts=2**15, inertia_as2=1.63e-3, noise_a=0.02,
                knots=drive.steps((17.0, 6.0), (40.0, 6.0))),
    ],
    ids=["coarse encoder at high speed", "a line that only the shortest smoothing shows"],
)  # fmt: skip
def test_cogging_of_a_fast_shaft_is_named_through_the_noise_of_its_angle(
    tmp_path: Path, machine: drive.Machine
) -> None:
    verdict = balance(tmp_path, machine, model=True).verdict

    assert drive.names_wrong(verdict, machine) == []
    assert missed(verdict, machine) == []
    assert verdict["parameters"]["cogging"]["amplitude_half_a_equiv"] < 0.2 * machine.cogging_a
    # The same drive without cogging: the noise is as loud, and is no line.
    smooth = replace(machine, cogging_a=0.0)
    assert drive.names_wrong(balance(tmp_path, smooth, model=True).verdict, smooth) == []
