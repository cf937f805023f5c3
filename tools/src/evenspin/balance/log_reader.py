"""Reads a log with some of the columns: repairs what it can and reports it; anything else is an error of one line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.csv_rows import HINT, header_of, rows_of
from evenspin.balance.plausibility import check_beside, check_living, check_units
from evenspin.errors import InputError
from evenspin.log.textfile import read_text
from evenspin.plausible.finding import is_signal

Array = NDArray[np.float64]

KNOWN = {"t_s": "s", "iq_a": "A", "theta_m_rad": "rad", "speed_rad_s": "rad/s", "speed_ref_rad_s": "rad/s"}
# Only for checks: do they belong to iq_a and the motion?
BESIDE = ("id_a", "ia_a", "ib_a", "id_ref_a", "iq_ref_a", "vd_v", "vq_v", "load_torque_nm")
MANY_A = 1000.0  # a drive with such a current is rare, a log in mA is not
STEMS = {  # how such a column may be called when its name or its unit is another one
    "t_s": ("time", "t", "timestamp"),
    "iq_a": ("iq", "i_q", "current", "iq_meas"),
    "theta_m_rad": ("theta_m", "theta", "angle", "position"),
    "speed_rad_s": ("speed", "omega", "velocity", "w"),
    "speed_ref_rad_s": ("speed_ref", "ref_speed", "speed_reference"),
}

LEAST_ROWS = 500  # half to fit, half to validate, and a few blocks in each for the intervals
LEAST_RATE_HZ = 50.0
SLOW = "record faster; with --model 25 rows per second tell loads, friction, inertia and resistance"
MOST_BAD = 0.2  # share of rows that may be left out; a log with more is refused
GAP_PERIODS = 3.0  # a longer step in time is a gap: nothing is judged across it
MOST_TURN = 0.5  # of a turn between two rows: an angle that jumps by more is wrapped
TURN = 2.0 * np.pi


@dataclass(frozen=True, slots=True)
class Log:
    """Rows in the order of time. A column that the file does not have is None."""

    path: Path
    t_s: Array
    iq_a: Array
    theta_m_rad: Array | None  # unwrapped
    speed_rad_s: Array | None
    speed_ref_rad_s: Array | None
    period_s: float
    repairs: tuple[str, ...]
    limits: tuple[str, ...]
    beside: Mapping[str, Array] = field(default_factory=dict)  # columns of BESIDE, which may have not-a-number
    doubts: tuple[str, ...] = ()  # what is possible and yet may be a wrong unit or sign; among the limits, too

    @property
    def gaps_s(self) -> Array:
        """Start and end of every gap in time."""
        return gaps_of(self.t_s, self.period_s)


def gaps_of(t_s: Array, period_s: float) -> Array:
    wide = np.flatnonzero(np.diff(t_s) > GAP_PERIODS * period_s)
    return np.column_stack((t_s[wide], t_s[wide + 1]))


def read_log(path: Path, least_rate_hz: float = LEAST_RATE_HZ) -> Log:
    """Read, repair and check; whatever the file is, the result is a Log or an InputError."""
    text = read_text(path, HINT)
    header = header_of(text)
    names = _columns(path, header)
    beside = [name for name in BESIDE if header.count(name) == 1]
    repairs: list[str] = []
    table = rows_of(path, text, [header.index(name) for name in (*names, *beside)], repairs)
    _enough(path, len(table))
    check_living(path, dict(zip(names, table.T, strict=False)))
    check_beside(path, dict(zip((*names, *beside), table.T, strict=True)))
    for name, column in zip((*names, *beside), table.T, strict=True):
        column[~is_signal(column, name)] = np.nan
    numbers = np.isfinite(table[:, : len(names)]).all(axis=1)
    table = _left_out(path, table, np.asarray(numbers), "with a value that is not a number", repairs)
    t_s = table[:, names.index("t_s")]
    later = t_s > np.concatenate(([-np.inf], np.maximum.accumulate(t_s)[:-1]))
    table = _left_out(path, table, later, "whose time repeats or goes back", repairs)
    _enough(path, len(table))
    values = {name: np.ascontiguousarray(table[:, i]) for i, name in enumerate(names)}
    others = {name: np.ascontiguousarray(table[:, len(names) + i]) for i, name in enumerate(beside)}
    period_s = float(np.median(np.diff(values["t_s"])))
    doubts = check_units(path, values, others)
    if period_s > 1.0 / least_rate_hz:
        hint = "is the time in milliseconds or microseconds? t_s is in seconds" if period_s > 0.1 else SLOW
        raise InputError(path, "t_s", f"{period_s:g} between rows", f"at most {1.0 / least_rate_hz:g} s", hint)
    theta = values.get("theta_m_rad")
    if theta is not None:
        theta = _unwrapped(theta, np.diff(values["t_s"]), values.get("speed_rad_s"), repairs)
    _say_times(values["t_s"], period_s, repairs)
    speed, reference = values.get("speed_rad_s"), values.get("speed_ref_rad_s")
    limits = _limits(values)
    return Log(
        path,
        values["t_s"],
        values["iq_a"],
        theta,
        speed,
        reference,
        period_s,
        tuple(repairs),
        (*doubts, *limits),
        others,
        doubts,
    )


def _columns(path: Path, header: Sequence[str]) -> list[str]:
    """The known columns of the file; a needed one that only has another unit is reported."""
    twice = next((name for name in KNOWN if header.count(name) > 1), None)
    if twice is not None:
        raise InputError(path, "column", twice, "in the header once", "remove the other", 1)
    for name in ("t_s", "iq_a"):
        if name not in header:
            raise _not_there(path, header, name)
    for name in ("theta_m_rad", "speed_rad_s", "speed_ref_rad_s"):
        other = _lookalike(header, name)
        if name not in header and other is not None:
            raise _wrong_unit(path, other, name)
    if "theta_m_rad" not in header and "speed_rad_s" not in header:
        raise InputError(path, "columns", ", ".join(header), "with theta_m_rad or speed_rad_s", HINT, 1)
    return [name for name in KNOWN if name in header]


def _not_there(path: Path, header: Sequence[str], name: str) -> InputError:
    other = _lookalike(header, name)
    if other is not None:
        return _wrong_unit(path, other, name)
    return InputError(path, "columns", ", ".join(header), f"with {name}", HINT, 1)


def _lookalike(header: Sequence[str], name: str) -> str | None:
    """A column that seems to be this quantity in another unit, or without one."""
    for given in header:
        stem = given.lower()
        if given in KNOWN or (name == "theta_m_rad" and stem.startswith("theta_e")):
            continue
        if stem in STEMS[name] or any(stem in (f"{s}_{unit}" for unit in OTHER_UNITS) for s in STEMS[name]):
            return given
    return None


OTHER_UNITS = (
    "s",
    "ms",
    "us",
    "rpm",
    "rps",
    "rad",
    "deg",
    "turn",
    "rev",
    "counts",
    "deg_s",
    "rad_s",
    "hz",
    "a",
    "ma",
    "m",
)


def _wrong_unit(path: Path, given: str, name: str) -> InputError:
    return InputError(path, "column", given, f"{name} [{KNOWN[name]}]", "convert the unit and rename the column", 1)


def _enough(path: Path, rows: int) -> None:
    if rows < LEAST_ROWS:
        hint = "record longer: one half fits, the other validates"
        raise InputError(path, "rows", rows, f"at least {LEAST_ROWS}", hint)


def _left_out(path: Path, table: Array, good: NDArray[np.bool_], what: str, repairs: list[str]) -> Array:
    bad = int(np.count_nonzero(~good))
    if bad == 0:
        return table
    if bad > MOST_BAD * len(table):
        must = f"at most {100 * MOST_BAD:.0f} % of them"
        raise InputError(path, "rows", f"{bad} of {len(table)} {what}", must, "correct the recording")
    first = int(np.argmin(good)) + 2
    repairs.append(f"{bad} of {len(table)} rows {what} (first: line {first}): left out")
    return table[good]


def _unwrapped(theta: Array, step_s: Array, speed: Array | None, repairs: list[str]) -> Array:
    """A wrapped angle never leaves a turn, and jumps by one. The speed, where known, counts whole turns in gaps."""
    step = np.diff(theta)
    if np.ptp(theta) > TURN * (1.0 + 1e-6) or np.max(np.abs(step)) <= TURN * MOST_TURN:
        return theta
    expected = np.zeros(len(step)) if speed is None else 0.5 * (speed[1:] + speed[:-1]) * step_s
    repairs.append("the angle is wrapped: unwrapped" + ("" if speed is None else ", turns counted with the speed"))
    return theta[0] + np.concatenate(([0.0], np.cumsum(step + TURN * np.round((expected - step) / TURN))))


def _say_times(t_s: Array, period_s: float, repairs: list[str]) -> None:
    step = np.diff(t_s)
    uneven = np.abs(step - period_s) > 0.05 * period_s
    if np.any(uneven):
        share = 100.0 * float(np.mean(uneven))
        repairs.append(
            f"rows are not evenly spaced ({share:.1f} % of the steps differ from {1e3 * period_s:.4g} ms, the longest "
            "is "
            f"{1e3 * step.max():.3g} ms): brought to an even grid by straight lines"
        )
    gaps = gaps_of(t_s, period_s)
    if len(gaps):
        repairs.append(f"{len(gaps)} gaps in time, {np.sum(gaps[:, 1] - gaps[:, 0]):.3g} s together: not judged")


def _limits(values: Mapping[str, Array]) -> tuple[str, ...]:
    """What is not identifiable because a column is missing."""
    limits = []
    if "theta_m_rad" not in values:
        limits.append("no theta_m_rad: what repeats with the angle is not identifiable")
        limits.append("speed_rad_s is taken to be in rad/s, and t_s in s: without theta_m_rad this is not checked")
    if "speed_rad_s" not in values:
        limits.append("no speed_rad_s: speed and acceleration come from the angle alone")
        limits.append("theta_m_rad is taken to be mechanical and in rad: without speed_rad_s this is not checked")
    if "speed_ref_rad_s" not in values:
        limits.append("no speed_ref_rad_s: the speed controller cannot be found, so no closed loop is simulated")
    top_a = float(np.max(np.abs(values["iq_a"])))
    if top_a > MANY_A:
        limits.append(f"iq_a reaches {top_a:.4g} A: if that is in mA, every current of this verdict is too")
    limits.append(
        "no torque constant, voltage or load sensor is used: torque is in ampere equivalents, and a torque_constant, "
        "winding_resistance, dead_time or inductance error does not show"
    )
    return tuple(limits)
