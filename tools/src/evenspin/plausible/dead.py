"""Channels that say nothing: the same number in every row, or for a long time while everything else goes on."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from evenspin.plausible.currents import CURRENTS, park
from evenspin.plausible.finding import Array, rms

STUCK_SHARE = 0.2  # of the rows that one number may stand
STUCK_ROWS = 200
MOVED = 0.05  # of the largest current: what goes on meanwhile
STILL_RAD = 0.02
STILL_COUNTS = 8.0
FLOWED = 0.05  # of the current that is asked for
DIGITS = 3  # so many different values...
FLICKER = 0.05  # ...that change in this share of the rows are the noise of a last digit

Columns = Mapping[str, Array]
TURNING = ("theta_m_rad", "speed_rad_s", "id_a", "iq_a", "ia_a", "ib_a", "vd_v", "vq_v")
LOCKED = ("id_a", "iq_a", "ia_a", "ib_a", "vd_v", "vq_v")


def is_constant(column: Array) -> bool:
    good = column[np.isfinite(column)]
    return len(good) > 0 and float(np.ptp(good)) <= 1e-12 * float(np.max(np.abs(good)))


def is_flicker(column: Array) -> bool:
    """Only the last digit of a converter moves."""
    changes = np.count_nonzero(np.diff(column))
    if changes <= FLICKER * len(column):
        return False
    values = np.unique(column)
    return len(values) <= DIGITS and bool(np.ptp(values) <= 2.5 * np.min(np.diff(values)))


def dead_record(columns: Columns, locked: bool, pole_pairs: int, counts: float) -> str | None:
    """Why a record of the log format says nothing; None where every channel lives."""
    dead = [name for name in (LOCKED if locked else TURNING) if is_constant(columns[name])]
    if not locked and (not dead or set(dead) & {"theta_m_rad", "speed_rad_s"}) and _is_still(columns, counts):
        return "the shaft never turned: theta_m_rad and speed_rad_s stand in all rows"
    if dead:
        values = ", ".join(dict.fromkeys(f"{columns[name][0]:g}" for name in dead))
        return f"{' and '.join(dead)} {'is' if len(dead) == 1 else 'are'} {values} in every row: a dead channel"
    asked = np.hypot(columns["id_ref_a"], columns["iq_ref_a"])
    flowed = np.hypot(columns["id_a"], columns["iq_a"])
    if rms(flowed) < FLOWED * rms(asked):
        return f"the current never flowed: {rms(asked):.3g} A rms are asked for, id_a and iq_a have {rms(flowed):.2g} A"
    if is_constant(asked) and (locked or rms(flowed) > 0.0 and asked[0] == 0.0 and _turns(columns) > 1.0):
        return f"id_ref_a and iq_ref_a are {columns['iq_ref_a'][0]:g} in every row: a dead channel, or nothing was done"
    if not locked and np.all(columns["speed_ref_rad_s"] == 0.0) and _turns(columns) > 1.0:
        return f"speed_ref_rad_s is 0 in every row, and the shaft made {_turns(columns):.0f} turns: a dead channel"
    return _stuck(columns, pole_pairs)


def _is_still(columns: Columns, counts: float) -> bool:
    theta, speed = columns["theta_m_rad"], columns["speed_rad_s"]
    least = max(STILL_RAD, STILL_COUNTS * 2.0 * np.pi / counts if counts > 0.0 else 0.0)
    way = float(np.trapezoid(np.abs(speed), columns["t_s"]))
    return float(np.ptp(np.unwrap(theta))) < least and way < 1.0


def _turns(columns: Columns) -> float:
    return float(np.ptp(np.unwrap(columns["theta_m_rad"]))) / (2.0 * np.pi)


def _stuck(columns: Columns, pole_pairs: int) -> str | None:
    """A current that stands while the three others and the angle tell that it moves."""
    angle = pole_pairs * columns["theta_m_rad"]
    d, q = park(columns["ia_a"], columns["ib_a"], angle)
    a = np.cos(angle) * columns["id_a"] - np.sin(angle) * columns["iq_a"]
    turned = angle - 2.0 * np.pi / 3.0
    b = np.cos(turned) * columns["id_a"] - np.sin(turned) * columns["iq_a"]
    told = dict(zip(CURRENTS, (d, q, a, b), strict=True))
    for name in CURRENTS:
        start, end = longest_stand(columns[name])
        if end - start < max(STUCK_ROWS, STUCK_SHARE * len(angle)):
            continue
        if float(np.ptp(told[name][start:end])) > MOVED * float(np.max(np.abs(told[name]))) > 0.0:
            t_s = columns["t_s"]
            return f"{name} stands at {columns[name][start]:g} from {t_s[start]:.4g} to {t_s[end - 1]:.4g} s: stuck"
    return None


def longest_stand(column: Array) -> tuple[int, int]:
    """Rows [start, end) of the longest run of one value."""
    edges = np.concatenate(([0], np.flatnonzero(np.diff(column)) + 1, [len(column)]))
    longest = int(np.argmax(np.diff(edges)))
    return int(edges[longest]), int(edges[longest + 1])
