"""What is wrong with a case is an error of one line, or it is mended and said. Never silently taken."""

from __future__ import annotations

import functools
import gzip
import json
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evenspin.errors import InputError
from evenspin.gap.check import checked_case
from evenspin.log import LOG_COLUMNS, write_csv
from evenspin.log.columns import LOG_UNITS
from evenspin.log.csvfile import read_csv
from evenspin.sim import Record

CLEAN = Path(__file__).parents[3] / "tests" / "data" / "foreign_drive" / "example_clean"
SHORT = ("staircase_load", "standstill_steps")  # enough to investigate, quick to read
ROW = {name: i for i, name in enumerate(LOG_COLUMNS)}
Values = np.ndarray[Any, np.dtype[np.float64]]


@functools.cache
def clean(name: str) -> Record:
    return read_csv(CLEAN / f"{name}.csv.gz", LOG_COLUMNS, LOG_UNITS)


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """A sound case of two records; meta.json is a copy, records are links."""
    meta = json.loads((CLEAN / "meta.json").read_text())
    (tmp_path / "meta.json").write_text(json.dumps({**meta, "experiments": list(SHORT)}))
    for name in SHORT:
        os.symlink(CLEAN / f"{name}.csv.gz", tmp_path / f"{name}.csv.gz")
    return tmp_path


def change_meta(case: Path, change: Callable[[dict[str, Any]], Any]) -> None:
    meta = json.loads((case / "meta.json").read_text())
    change(meta)
    (case / "meta.json").write_text(json.dumps(meta))


def change_record(case: Path, change: Callable[[Values], Values], name: str = "staircase_load") -> None:
    values = change(clean(name).values.copy())
    (case / f"{name}.csv.gz").unlink()
    write_csv(case / f"{name}.csv", LOG_COLUMNS, values)


def test_a_sound_case_is_taken_as_it_is_without_a_word(case: Path) -> None:
    checked, said = checked_case(case)

    assert said == ()
    for name in SHORT:
        assert np.array_equal(checked.experiments[name].values, clean(name).values, equal_nan=True)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda m: m["motor"].pop("psi_wb"), r"motor\.psi_wb = \(missing\): must be a number above 0"),
        (lambda m: m["motor"].update(ld_h=-1e-3), r"motor\.ld_h = -0.001: must be a number above 0"),
        (lambda m: m["motor"].update(rated_torque_nm="2 Nm"), r"motor\.rated_torque_nm = '2 Nm'"),
        (lambda m: m.pop("encoder"), r"encoder\.counts_per_rev = \(missing\)"),
        (lambda m: m["speed_filter"].pop("ki"), r"speed_filter\.ki = \(missing\)"),
        (lambda m: m["speed_filter"].update(type="fir"), r"speed_filter\.type = 'fir': must be \"tracking_pll\""),
        (lambda m: m["current_loop"].update(computation_delay_periods=2), r"computation_delay_periods = 2: must be 1"),
        (lambda m: m["current_loop"].update(ts_s=2e-4), r"current_loop\.ts_s = 0.0002: must be one PWM period"),
        (lambda m: m["speed_loop"].update(ts_s=1.04e-3), r"speed_loop\.ts_s = 0.00104: must be a whole number"),
        (lambda m: m["motor"].update(pole_pairs=4), r"motor\.pole_pairs = 4: must be 3, as ia_a, ib_a"),
        (lambda m: m.update(experiments=["gone"]), "at least one file"),
    ],
)
def test_a_meta_json_that_cannot_be_worked_with_is_one_line(case: Path, change: Any, said: str) -> None:
    change_meta(case, change)

    with pytest.raises(InputError, match=said) as error:
        checked_case(case)

    assert "\n" not in str(error.value)


def test_a_pwm_rate_that_contradicts_the_sampling_is_one_line(case: Path) -> None:
    def change(meta: dict[str, Any]) -> None:
        meta.update(pwm_hz=8300.0)
        meta["current_loop"].update(ts_s=1.0 / 8300.0)
        meta["speed_loop"].update(ts_s=8.0 / 8300.0)

    change_meta(case, change)

    with pytest.raises(InputError, match="pwm_hz = 8300 in meta.json contradicts the log"):
        checked_case(case)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda m: m["motor"].pop("slots"), "motor.slots is not in meta.json"),
        (lambda m: m["encoder"].update(counts_per_rev=3000), "does not move in counts of 2 pi / 3000"),
        (lambda m: m["encoder"].update(counts_per_rev=8000), "steps of 2 counts: is encoder.counts_per_rev 4000?"),
        (lambda m: m.update(dc_link_v=300.0), "vdc_v is 150 V, dc_link_v in meta.json 300 V"),
        (lambda m: m.update(dc_link_v=30.0), "the drive commanded"),
        (lambda m: m["speed_loop"].update(iq_limit_a=1.0), "speed_loop.iq_limit_a in meta.json is 1 A"),
        (lambda m: m["experiments"].append("coast_down"), "coast_down is in meta.json, but there is no file of it"),
        (lambda m: m.update(experiments=["staircase_load"]), "standstill_steps.csv.gz is not in meta.json: not read"),
    ],
)
def test_what_only_looks_odd_is_said_and_the_work_goes_on(case: Path, change: Any, said: str) -> None:
    change_meta(case, change)

    warnings = checked_case(case)[1]

    assert any(said in warning for warning in warnings), warnings


def with_nan(column: str, share: float) -> Callable[[Values], Values]:
    def change(values: Values) -> Values:
        rows = np.random.default_rng(1).choice(len(values), round(share * len(values)), replace=False)
        values[rows[rows > 0], ROW[column]] = np.nan
        return values

    return change


@pytest.mark.parametrize("column", ["speed_ref_rad_s", "theta_m_rad", "iq_a", "load_torque_nm"])
def test_a_few_values_that_are_not_numbers_are_filled_in(case: Path, column: str) -> None:
    change_record(case, with_nan(column, 0.005))

    checked, said = checked_case(case)

    true = clean("staircase_load")[column]
    found = checked.experiments["staircase_load"][column]
    error = np.abs(found - true)
    error = np.minimum(error, math.tau - error) if column == "theta_m_rad" else error
    # a row is 0.5 ms: at most 1.5 counts of the angle, five times the noise of 15 mA or of the torque reading
    assert np.max(error) < {"speed_ref_rad_s": 1e-9, "theta_m_rad": 0.03, "iq_a": 0.2, "load_torque_nm": 0.1}[column]
    assert any(f"values of {column} are not numbers" in line for line in said)


def test_a_record_with_too_many_of_them_is_left_out(case: Path) -> None:
    change_record(case, with_nan("iq_a", 0.1))

    checked, said = checked_case(case)

    assert list(checked.experiments) == ["standstill_steps"]
    assert any("the record is left out" in line for line in said)


def test_repeated_times_are_left_out_and_the_rest_stays(case: Path) -> None:
    change_record(case, lambda v: np.insert(v, [100, 200], v[[99, 199]], axis=0))

    checked, said = checked_case(case)

    assert np.array_equal(checked.experiments["staircase_load"].values, clean("staircase_load").values)
    assert any(line.startswith("staircase_load: 2 rows whose time repeats") for line in said)


def test_a_short_gap_is_bridged_on_an_even_grid(case: Path) -> None:
    change_record(case, lambda v: np.delete(v, [500, 501, 502], axis=0))

    checked, said = checked_case(case)

    record = checked.experiments["staircase_load"]
    assert len(record) == len(clean("staircase_load"))
    assert np.allclose(np.diff(record["t_s"]), 5e-4)
    assert any("3 rows are missing in short gaps" in line for line in said)


def test_after_a_long_gap_the_record_ends(case: Path) -> None:
    change_record(case, lambda v: np.delete(v, slice(4000, 4100), axis=0))

    checked, said = checked_case(case)

    assert len(checked.experiments["staircase_load"]) == 4000
    assert any("100 rows are missing" in line for line in said)


def test_three_samples_are_left_out_and_alone_they_are_one_line(case: Path) -> None:
    change_record(case, lambda v: v[:3])
    assert any("3 rows are too few" in line for line in checked_case(case)[1])

    change_meta(case, lambda m: m.update(experiments=["staircase_load"]))
    with pytest.raises(InputError, match="at least one record to fit.*3 rows are too few"):
        checked_case(case)


def test_a_record_that_does_not_start_at_rest_is_left_out(case: Path) -> None:
    change_record(case, lambda v: v[3000:])
    os.symlink(CLEAN / "reversal.csv.gz", case / "reversal.csv.gz")  # the shaft turns in this one, too
    change_meta(case, lambda m: m["experiments"].append("reversal"))

    checked, said = checked_case(case)
    assert any("does not start at rest" in line for line in said)
    assert "staircase_load" not in checked.experiments and "reversal" in checked.experiments


def test_when_no_record_with_a_turning_shaft_starts_at_rest_there_is_no_verdict(case: Path) -> None:
    change_record(case, lambda v: v[3000:])

    with pytest.raises(InputError, match="staircase_load.*at rest at the start.*hold it"):
        checked_case(case)


def test_a_load_that_was_not_measured_leaves_the_record_out(case: Path) -> None:
    def unmeasured(values: Values) -> Values:
        values[:, ROW["load_torque_nm"]] = np.nan
        return values

    change_record(case, unmeasured)

    assert any("load_torque_nm was not measured" in line for line in checked_case(case)[1])


def test_a_speed_in_rpm_is_one_line(case: Path) -> None:
    def in_rpm(values: Values) -> Values:
        values[:, ROW["speed_rad_s"]] *= 30.0 / math.pi
        return values

    change_record(case, in_rpm)

    with pytest.raises(InputError, match="speed_rad_s: 9.53 times .*looks like speed_rad_s in r/min"):
        checked_case(case)


def test_a_locked_rotor_that_turns_is_said(case: Path) -> None:
    def turning(values: Values) -> Values:
        values[:, ROW["theta_m_rad"]] = np.linspace(0.0, 1.0, len(values))
        return values

    change_record(case, turning, "standstill_steps")

    assert any("the rotor is stated to be locked" in line for line in checked_case(case)[1])


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda text: text.replace("iq_a", "iq_ma", 1), "iq_a"),
        (lambda text: text[: len(text) // 2].rsplit(",", 3)[0], "columns"),
        (lambda text: text.replace("0.", "x.", 1), "must be a number"),
        (lambda text: text.split("\n")[0] + "\n", "rows = 0"),
    ],
)
def test_a_file_that_cannot_be_read_is_one_line(case: Path, damage: Any, said: str) -> None:
    text = gzip.open(CLEAN / "staircase_load.csv.gz", "rt").read()
    (case / "staircase_load.csv.gz").unlink()
    (case / "staircase_load.csv").write_text(damage(text))

    with pytest.raises(InputError, match=said) as error:
        checked_case(case)

    assert "\n" not in str(error.value)


def test_a_compressed_file_that_is_cut_off_is_one_line(case: Path) -> None:
    raw = (CLEAN / "staircase_load.csv.gz").read_bytes()
    (case / "staircase_load.csv.gz").unlink()
    (case / "staircase_load.csv.gz").write_bytes(raw[: len(raw) // 2])

    with pytest.raises(InputError, match="complete .gz file; copy it again"):
        checked_case(case)
