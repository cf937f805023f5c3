"""Four currents and an angle that belong together: id_a and iq_a are the transform of ia_a and ib_a with the angle.

The drive calculates one from the other, so that a sensor that reads wrong is in both: what does not fit is a column.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from evenspin.plausible.finding import Array, Finding, rms

ODD = 0.2  # of the current that may be at odds with the angle
RIGHT = 0.05  # what a right assignment leaves of it
SUSPECT, SURE = 0.1, 0.02  # ODD and RIGHT for the assignment of columns, of which many are tried
ROWS = 4000  # are enough
POLE_PAIRS_MOST = 60
CURRENTS = ("id_a", "iq_a", "ia_a", "ib_a")
PEAK, POWER = math.sqrt(2.0), math.sqrt(1.5)

Columns = Mapping[str, Array]
Pair = tuple[Array, Array]


def park(ia: Array, ib: Array, angle_el: Array) -> Pair:
    alpha, beta = ia, (ia + 2.0 * ib) / math.sqrt(3.0)
    return np.cos(angle_el) * alpha + np.sin(angle_el) * beta, np.cos(angle_el) * beta - np.sin(angle_el) * alpha


def park_share(columns: Columns, pole_pairs: int) -> float:
    """rms of what the transform leaves of id and iq, over the rms of those; 0 where no current flows."""
    dq = columns["id_a"], columns["iq_a"]
    return _left(dq, park(columns["ia_a"], columns["ib_a"], pole_pairs * columns["theta_m_rad"]))


def check_currents(columns: Columns, pole_pairs: int) -> Finding | None:
    """A column that is another one, in another unit or of another sign. 0 pole pairs: not known, any will do."""
    step = max(1, len(columns["iq_a"]) // ROWS)
    some = {name: columns[name][::step] for name in (*CURRENTS, "theta_m_rad")}
    tried = [pole_pairs] if pole_pairs > 0 else list(range(1, POLE_PAIRS_MOST + 1))
    if min(park_share(some, p) for p in tried) <= SUSPECT:
        return None
    found = [
        (_left(change(dq), expected), what)
        for p in tried
        for expected, whats in _expected(some, p)
        for dq in [(some["id_a"], some["iq_a"])]
        for what, change in whats.items()
    ]
    left, what = min(found, key=lambda pair: pair[0])
    if left > SURE:
        return None
    data = f"at odds with ia_a, ib_a and theta_m_rad, and in accord when {what}"
    hint = "exchange the names" if "exchanged" in what else "correct the column"
    column = next(name for name in (*CURRENTS, "theta_m_rad") if name in what)
    return Finding(column, data, "what its name says", f"{hint} in every file of this recording")


def wrong_pole_pairs(columns: Columns, pole_pairs: int) -> int | None:
    """Pole pairs with which the currents do turn with the angle; None when those that are given do, or none do."""
    step = max(1, len(columns["iq_a"]) // ROWS)
    some = {name: columns[name][::step] for name in (*CURRENTS, "theta_m_rad")}
    if park_share(some, pole_pairs) <= ODD:
        return None
    shares = {p: park_share(some, p) for p in range(1, POLE_PAIRS_MOST + 1)}
    best = min(shares, key=lambda p: shares[p])
    return best if shares[best] < RIGHT else None


def _expected(some: Columns, p: int) -> Iterator[tuple[Pair, Mapping[str, Callable[[Pair], Pair]]]]:
    """The transform of the phases as they are, and as they would be, with what may then be wrong with id and iq."""
    ia, ib, angle = some["ia_a"], some["ib_a"], p * some["theta_m_rad"]
    yield park(ia, ib, angle), DQ
    for what, phases in PHASES.items():
        yield park(*phases((ia, ib)), angle), {what: lambda dq: dq}
    yield park(ia, ib, -angle), {"theta_m_rad has the opposite sign": lambda dq: dq}


DQ: dict[str, Callable[[Pair], Pair]] = {
    "id_a and iq_a are exchanged": lambda x: (x[1], x[0]),
    "iq_a has the opposite sign": lambda x: (x[0], -x[1]),
    "id_a has the opposite sign": lambda x: (-x[0], x[1]),
    "id_a and iq_a (or ia_a and ib_a) have the opposite sign": lambda x: (-x[0], -x[1]),
    "id_a and iq_a are exchanged and iq_a has the opposite sign": lambda x: (-x[1], x[0]),
    "id_a and iq_a are exchanged and id_a has the opposite sign": lambda x: (x[1], -x[0]),
    "iq_a is in mA": lambda x: (x[0], x[1] / 1e3),
    "id_a is in mA": lambda x: (x[0] / 1e3, x[1]),
    "id_a and iq_a are in mA": lambda x: (x[0] / 1e3, x[1] / 1e3),
    "ia_a and ib_a are in mA": lambda x: (x[0] * 1e3, x[1] * 1e3),
    "id_a and iq_a are of the power-invariant transform, sqrt(3/2) too large": lambda x: (x[0] / POWER, x[1] / POWER),
    "id_a and iq_a are rms, sqrt(2) too small": lambda x: (x[0] * PEAK, x[1] * PEAK),
}
PHASES: dict[str, Callable[[Pair], Pair]] = {
    "ia_a and ib_a are exchanged": lambda x: (x[1], x[0]),
    "ia_a has the opposite sign": lambda x: (-x[0], x[1]),
    "ib_a has the opposite sign": lambda x: (x[0], -x[1]),
    "ib_a is the third phase": lambda x: (x[0], -x[0] - x[1]),
    "ia_a is the third phase": lambda x: (-x[0] - x[1], x[1]),
    "ia_a is in mA": lambda x: (x[0] / 1e3, x[1]),
    "ib_a is in mA": lambda x: (x[0], x[1] / 1e3),
}


def _left(dq: Pair, expected: Pair) -> float:
    size = math.hypot(rms(dq[0]), rms(dq[1]))
    return math.hypot(rms(dq[0] - expected[0]), rms(dq[1] - expected[1])) / size if size > 0.0 else 0.0
