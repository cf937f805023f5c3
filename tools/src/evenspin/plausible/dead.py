"""Channels that say nothing: the same number in every row, or for a long time while everything else goes on."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from evenspin.plausible.currents import CURRENTS, park
from evenspin.plausible.finding import Array, rms

STUCK_SHARE = 0.2  # of the rows that one number may stand
STUCK_ROWS = 200
MOVED = 0.005  # of the largest current: what goes on meanwhile
STILL_RAD = 0.02
STILL_COUNTS = 8.0
STILL_TRAVEL = 1.0  # rad that the noise of a speed may add up to
FLOWED = 0.3  # of the current that is asked for
SPACING = 20  # rows between two angles whose difference gives a speed
FOLLOWED = 0.5  # correlation with what is asked for
UNFOLLOWED = 0.7  # share of the speed that its reference leaves
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
        values = ", ".join(dict.fromkeys(f"{columns[name][0] + 0.0:g}" for name in dead))
        return f"{' and '.join(dead)} {'is' if len(dead) == 1 else 'are'} {values} in every row: a dead channel"
    return _unasked(columns, locked) or _stuck(columns, pole_pairs)


def unusable_columns(columns: Columns, optional: Collection[str]) -> str | None:
    """Columns without a number, or a time that stands: nothing can be mended."""
    empty = [name for name, column in columns.items() if name not in optional and not np.isfinite(column).any()]
    if empty:
        return f"{' and '.join(empty)} {'has' if len(empty) == 1 else 'have'} no number in any row"
    if len(columns["t_s"]) > 1 and is_constant(columns["t_s"]):
        return f"t_s is {columns['t_s'][0] + 0.0:g} in every row: a dead channel"
    return None


def _unasked(columns: Columns, locked: bool) -> str | None:
    """References that say nothing, or nothing that follows them."""
    d_ref, q_ref, d, q = (columns[name] for name in ("id_ref_a", "iq_ref_a", "id_a", "iq_a"))
    asked, flowed = np.hypot(rms(d_ref), rms(q_ref)), np.hypot(rms(d), rms(q))
    like = float(np.mean(d * d_ref + q * q_ref)) / float(asked * flowed) if asked * flowed > 0.0 else 0.0
    if is_constant(q_ref) and (not locked or is_constant(d_ref)):
        names = "id_ref_a and iq_ref_a are constant" if locked else f"iq_ref_a is {q_ref[0] + 0.0:g}"
        hint = "a dead channel, or nothing was done" if is_constant(d_ref) else "are id_ref_a and iq_ref_a exchanged?"
        return f"{names} in every row: {hint}"
    if flowed < FLOWED * asked and abs(like) < FOLLOWED:
        return f"the current never flowed: {asked:.3g} A rms are asked for, id_a and iq_a have {flowed:.2g} A"
    ref, speed = columns["speed_ref_rad_s"], columns["speed_rad_s"]
    if locked or not is_constant(ref) or _turns(columns) < 1.0:
        return None
    driven = int(np.flatnonzero(q_ref)[-1]) + 1  # a shaft that coasts follows nothing
    angle, t_s = np.unwrap(columns["theta_m_rad"]), columns["t_s"]
    rate = (angle[SPACING:] - angle[:-SPACING]) / (t_s[SPACING:] - t_s[:-SPACING])
    # the angle and the speed have to say it: one of them alone may be in another unit
    if all(rms(x[:driven] - ref[0]) > UNFOLLOWED * rms(x[:driven]) for x in (speed, rate)):
        return f"speed_ref_rad_s is {ref[0] + 0.0:g} in every row, and the shaft does something else: a dead channel"
    return None


def _is_still(columns: Columns, counts: float) -> bool:
    theta, speed = columns["theta_m_rad"], columns["speed_rad_s"]
    least = max(STILL_RAD, STILL_COUNTS * 2.0 * np.pi / counts if counts > 0.0 else 0.0)
    travel = np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(columns["t_s"]))
    return float(np.ptp(np.unwrap(theta))) < least and float(np.ptp(travel)) < STILL_TRAVEL


def _turns(columns: Columns) -> float:
    return float(np.ptp(np.unwrap(columns["theta_m_rad"]))) / (2.0 * np.pi)


def _stuck(columns: Columns, pole_pairs: int) -> str | None:
    """A current that stands while the three others and the angle show that it moves."""
    angle = pole_pairs * columns["theta_m_rad"]
    d, q = park(columns["ia_a"], columns["ib_a"], angle)
    a = np.cos(angle) * columns["id_a"] - np.sin(angle) * columns["iq_a"]
    turned = angle - 2.0 * np.pi / 3.0
    b = np.cos(turned) * columns["id_a"] - np.sin(turned) * columns["iq_a"]
    currents = dict(zip(CURRENTS, (d, q, a, b), strict=True))
    for name in CURRENTS:
        start, end = longest_stand(columns[name])
        if end - start < max(STUCK_ROWS, STUCK_SHARE * len(angle)):
            continue
        if float(np.ptp(currents[name][start:end])) > MOVED * float(np.max(np.abs(currents[name]))) > 0.0:
            t_s = columns["t_s"]
            return f"{name} stands at {columns[name][start]:g} from {t_s[start]:.4g} to {t_s[end - 1]:.4g} s: stuck"
    return None


def longest_stand(column: Array) -> tuple[int, int]:
    """Rows [start, end) of the longest run of one value."""
    edges = np.concatenate(([0], np.flatnonzero(np.diff(column)) + 1, [len(column)]))
    longest = int(np.argmax(np.diff(edges)))
    return int(edges[longest]), int(edges[longest + 1])
