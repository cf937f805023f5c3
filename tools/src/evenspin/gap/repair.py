"""What can be mended in a record, mended and reported: rows that are not numbers, times that repeat, short gaps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.thresholds_records import BACKWARDS_SHARE, BRIDGED_ROWS, FILLED_SHARE
from evenspin.log.columns import LOG_COLUMNS
from evenspin.plausible.finding import is_signal
from evenspin.sim.record import Record

HELD = ("speed_ref_rad_s", "id_ref_a", "iq_ref_a")  # what is commanded stays until it changes
ANGLE, LOAD = "theta_m_rad", "load_torque_nm"
NOT_NEEDED = (LOAD, "vdc_v")  # nan in every row where they were not measured
TURN = 2.0 * np.pi

Array = NDArray[np.float64]


def repaired(record: Record, messages: list[str], name: str) -> Record | None:
    """The record without what is wrong with it; None where too much is. What was done is added to `messages`."""
    values = record.values.copy()
    time = LOG_COLUMNS.index("t_s")
    values = _forward_only(values, time, messages, name)
    if len(values) < (1.0 - BACKWARDS_SHARE) * len(record):
        messages.append(f"{name}: t_s repeats or goes back too often: the record is left out")
        return None
    if len(values) < 2:
        return Record(record.names, record.units, values)
    values = _bridged(values, time, messages, name)
    for i, column in enumerate(record.names):
        bad = ~is_signal(values[:, i], column)
        count = int(np.count_nonzero(bad))
        if count == 0 or (column in NOT_NEEDED and count == len(values)):
            continue
        share = f"{count} of {len(values)}"
        if count > FILLED_SHARE * len(values) and column == LOAD:
            values[bad, i] = 0.0
            messages.append(f"{name}: load_torque_nm is not known in {share} rows: taken as no load there")
            continue
        if count > FILLED_SHARE * len(values):
            messages.append(f"{name}: {share} values of {column} are not numbers: the record is left out")
            return None
        values[:, i] = _filled(values[:, i], bad, column)
        messages.append(f"{name}: {count} values of {column} are not numbers: {_how(column)}")
    return Record(record.names, record.units, values)


def _forward_only(values: Array, time: int, messages: list[str], name: str) -> Array:
    t_s = values[:, time]
    t_s = np.where(np.isfinite(t_s), t_s, -np.inf)
    later = t_s > np.concatenate(([-np.inf], np.maximum.accumulate(t_s)[:-1]))
    dropped = int(np.count_nonzero(~later))
    if dropped:
        messages.append(f"{name}: {dropped} rows whose time repeats, goes back or is not a number: left out")
    return values[later]


def _bridged(values: Array, time: int, messages: list[str], name: str) -> Array:
    """Rows at an even period; the record ends where too many are missing."""
    steps = np.diff(values[:, time])
    period = float(np.median(steps))
    missing = np.round(steps / period).astype(int) - 1
    long = np.flatnonzero(missing > BRIDGED_ROWS)
    if len(long):
        end = int(long[0]) + 1
        messages.append(
            f"{name}: {missing[end - 1]} rows are missing at t = {values[end - 1, time]:.4g} s: "
            f"only the {end} rows before that are used"
        )
        values, missing = values[:end], missing[: end - 1]
    short = int(np.sum(missing[missing > 0]))
    if short == 0:
        return values
    messages.append(f"{name}: {short} rows are missing in short gaps: straight lines between their neighbours")
    at = np.concatenate(([0], np.cumsum(missing + 1)))
    rows = np.arange(at[-1] + 1)
    out = np.column_stack([_spread(rows, at, values[:, i], column) for i, column in enumerate(LOG_COLUMNS)])
    out[at] = values
    return out


def _spread(rows: Array, at: Array, column: Array, name: str) -> Array:
    if name in HELD:
        return column[np.searchsorted(at, rows, side="right") - 1]
    if name == ANGLE:
        return np.interp(rows, at, np.unwrap(column)) % TURN
    return np.interp(rows, at, column)


def _filled(column: Array, bad: NDArray[np.bool_], name: str) -> Array:
    good = np.flatnonzero(~bad)
    rows = np.arange(len(column), dtype=np.float64)
    return _spread(rows, good.astype(np.float64), column[good], name) if name != ANGLE else _angle(rows, good, column)


def _angle(rows: Array, good: NDArray[np.int64], column: Array) -> Array:
    out = np.interp(rows, good, np.unwrap(column[good])) % TURN
    out[good] = column[good]
    return out


def _how(column: str) -> str:
    return "the value before is held" if column in HELD else "straight lines between their neighbours"
