"""What is filled into a record, on rows where the wrong way of filling would show."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from evenspin.gap.repair import repaired
from evenspin.log import LOG_COLUMNS
from evenspin.log.columns import LOG_UNITS
from evenspin.sim import Record

ROWS = 200
HOLE = 100  # row


def record(**columns: Any) -> Record:
    """Zeros at 2 kHz, but for these columns."""
    values = np.zeros((ROWS, len(LOG_COLUMNS)))
    values[:, 0] = np.arange(ROWS) * 5e-4
    for name, column in columns.items():
        values[:, LOG_COLUMNS.index(name)] = column
    return Record(LOG_COLUMNS, LOG_UNITS, values)


def with_hole(values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    out = values.copy()
    out[HOLE] = np.nan
    return out


def stepped(step_at: int) -> np.ndarray[Any, Any]:
    return np.where(np.arange(ROWS) < step_at, 0.0, 10.0)


@pytest.mark.parametrize("name", ["speed_ref_rad_s", "id_ref_a", "iq_ref_a"])
def test_a_reference_is_held_where_it_is_not_known(name: str) -> None:
    mended = repaired(record(**{name: with_hole(stepped(HOLE + 1))}), [], "staircase")

    assert mended is not None
    assert mended[name][HOLE] == 0.0  # not halfway to 10


def test_a_signal_is_drawn_straight_where_it_is_not_known() -> None:
    mended = repaired(record(iq_a=with_hole(stepped(HOLE + 1))), [], "staircase")

    assert mended is not None
    assert mended["iq_a"][HOLE] == pytest.approx(5.0)


def wrapped() -> np.ndarray[Any, Any]:
    """Past a full turn just at the hole."""
    return (0.1 * (np.arange(ROWS) - HOLE) + math.tau) % math.tau


def test_an_angle_is_filled_across_the_turn() -> None:
    mended = repaired(record(theta_m_rad=with_hole(wrapped())), [], "staircase")

    assert mended is not None
    assert abs(math.remainder(mended["theta_m_rad"][HOLE], math.tau)) < 1e-9
    assert np.delete(mended["theta_m_rad"], HOLE) == pytest.approx(np.delete(wrapped(), HOLE))


def test_missing_rows_come_back_with_references_held_and_the_angle_across_the_turn() -> None:
    full = record(theta_m_rad=wrapped(), speed_ref_rad_s=stepped(HOLE + 1), iq_a=np.arange(ROWS))
    holed = Record(full.names, full.units, np.delete(full.values, HOLE, axis=0))
    said: list[str] = []

    mended = repaired(holed, said, "staircase")

    assert mended is not None and len(mended) == ROWS
    assert mended["speed_ref_rad_s"][HOLE] == 0.0
    assert mended["iq_a"][HOLE] == pytest.approx(HOLE)
    assert abs(math.remainder(mended["theta_m_rad"][HOLE], math.tau)) < 1e-9
    assert said == ["staircase: 1 rows are missing in short gaps: straight lines between their neighbours"]


def test_a_load_that_is_never_measured_stays_so_without_a_word() -> None:
    said: list[str] = []

    mended = repaired(record(load_torque_nm=np.full(ROWS, np.nan)), said, "staircase")

    assert mended is not None and np.isnan(mended["load_torque_nm"]).all()
    assert said == []


def test_a_load_that_is_measured_in_part_is_none_elsewhere_and_that_is_said() -> None:
    said: list[str] = []

    mended = repaired(record(load_torque_nm=np.where(np.arange(ROWS) < 50, np.nan, 1.1)), said, "validation")

    assert mended is not None
    assert np.array_equal(mended["load_torque_nm"], np.where(np.arange(ROWS) < 50, 0.0, 1.1))
    assert said == ["validation: load_torque_nm is not known in 50 of 200 rows: taken as no load there"]
