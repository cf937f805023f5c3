"""Backlash, by what it does to the balance of torque: while the gap is crossed, the load takes no part in it.

The rotor then follows the torque with its own inertia alone. What a stiff shaft leaves unexplained is the torque that
the load would need, a fixed share of what the air gap makes:

    left = T - J dw/dt,   T = (1 - share) J dw/dt   =>   -left / (T - left) = share

Noise, loads and bursts of torque leave shares of either sign and of any size; a gap leaves one share, time and again.
How the load bounces between the flanks hangs on how each crossing began, so that a log tells that there is a gap, how
much of the inertia is behind it and about how wide it is, and not how hard the flanks are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.driven.judge import MOST_OF_A_SHAFT, Verdict
from evenspin.effects import backlash
from evenspin.gap.intervals import Interval
from evenspin.weakform.analysis import Explained, Recording
from evenspin.weakform.equations import Equations
from evenspin.weakform.terms import SHAFT

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

BACKLASH, INERTIA = "backlash", "inertia"
FINE = 1  # place of the short windows among the equations of a log
SLOWEST_S = 1.05e-3  # rows further apart do not resolve a crossing
BEYOND = 5.0  # times the scatter: what is left in a window of a crossing, at least
DRIVEN = 3.0  # times the scatter: the torque there, at least
BY_ROUNDING = 0.35  # times the most that rounding of the angle can leave there: a tenth of such windows have more
SHARES = np.arange(0.05, 0.98, 0.01)
WITHIN = 0.1  # of a share: impacts at either end of a crossing are in the same windows
LEAST_WINDOWS = 18  # 40 to 69 in four logs with backlash, 13 at most in 30 without
FEW_WINDOWS, NEARLY_ALL = 12, 0.9  # so few are enough where no other share comes up
LEAST_CROSSINGS = 8
OF_SAME_SIGN = 0.5  # of all windows in which the rotor is too fast for the torque
OF_ALL = 0.15  # of all windows in which much is left
GAPS_RAD, FLANKS_HZ = np.geomspace(0.004, 0.15, 36), (70.0, 120.0, 200.0)  # tried for the width
BOUNCES_S = 0.05
SPEED_WITHIN = 1.0  # counts in the length of a window: how well its speed is known, and how much it changes
SAWTOOTH_ORDERS = (1, 2, 3)  # of the rounding of the angle; the fourth leaves a quarter of the first
CONFIRMED = (
    0.85  # of what a stiff shaft leaves: 0.52 to 1.08 in twelve logs with backlash, 1.05 in one with a soft shaft
)
WORSE = 1.15  # of what a stiff shaft leaves: pushes that are all alike, with which no gap has to do, leave 1.23
ALIKE = 1.15  # of the least that any width leaves: as good
GAP_SHARE, RATIO_HALF = 0.5, 0.12  # of the width, and of the load's share: half widths; seven of eight widths were held
FLANK_HZ, FLANK_DAMPING = 120.0, 0.1  # for the simulator: no log of this kind tells them


@dataclass(frozen=True, slots=True)
class OpenGap:
    load_ratio: float
    gap_rad: float
    gap_half_rad: float
    left: float  # near the crossings with this gap, of what a stiff shaft leaves there
    windows: int
    crossings: int

    def __str__(self) -> str:
        return (
            f"{self.crossings} times a share of about {self.load_ratio:.2f} of the inertia took no part for some "
            "milliseconds, as behind backlash"
        )


@dataclass(frozen=True, slots=True)
class _Open:
    """Windows of one log in which much is left: the share of the torque that is, and where. `left`: of all windows."""

    share: Array
    row: NDArray[np.int64]
    left: Array
    recording: Recording

    def _rows(self, ratio: float) -> NDArray[np.int64]:
        return np.sort(self.row[np.abs(self.share - ratio) < WITHIN])

    def crossings(self, ratio: float) -> int:
        """Apart by more than neighbouring windows."""
        rows = self._rows(ratio)
        return int(np.count_nonzero(np.diff(rows) > 1.5 * self.recording.equations.fine.bump.half)) + int(len(rows) > 0)

    def near(self, ratio: float) -> Flags:
        """Windows in which the load may still bounce."""
        rows, over = self._rows(ratio), self.recording.equations.fine
        if len(rows) == 0:
            return np.zeros(len(self.left), dtype=bool)
        centre = over.centre[over.used]
        at = np.searchsorted(rows, centre)
        apart = np.minimum(
            np.abs(centre - rows[np.clip(at - 1, 0, None)]), np.abs(centre - rows[np.clip(at, 0, len(rows) - 1)])
        )
        return np.asarray(apart * self.recording.signals.period_s < BOUNCES_S)


def open_gap(found: Explained) -> OpenGap | None:
    """Of all logs together; None where there is no sign of a gap."""
    logs = [_opened(found, log) for log in range(len(found.recordings))]
    there = [each for each in logs if each is not None]
    if not there:
        return None
    share = np.concatenate([each.share for each in there])
    ahead = share[(share > SHARES[0]) & (share < 1.0)]
    inside = [int(np.count_nonzero(np.abs(ahead - at) < WITHIN)) for at in SHARES]
    best = int(np.argmax(inside))
    least = FEW_WINDOWS if inside[best] >= NEARLY_ALL * len(ahead) else LEAST_WINDOWS
    if inside[best] < max(least, OF_SAME_SIGN * len(ahead), OF_ALL * len(share)):
        return None
    near = ahead[np.abs(ahead - SHARES[best]) < WITHIN]
    ratio = float(np.median(near))
    crossings = sum(each.crossings(ratio) for each in there)
    if crossings < LEAST_CROSSINGS:
        return None
    opened = OpenGap(ratio, *_width(found, there, ratio), len(near), crossings)
    return opened if opened.left < WORSE else None


def name_backlash(verdict: Verdict, opened: OpenGap) -> None:
    """In place of a shaft that twists, which looks much alike. No name beside a cause that the table does not have,
    nor where no gap explains what is left near the crossings."""
    if verdict.unknown:
        _forget(verdict, INERTIA)
        verdict.nearest.append(BACKLASH)
        verdict.unexplained.append(str(opened))
        return
    if opened.left > CONFIRMED:
        verdict.warnings.append(
            f"{opened}, or a shaft that twists; no gap that was tried explains it, so it has no name"
        )
        return
    _forget(verdict, SHAFT)
    params = {"gap_rad": opened.gap_rad, "load_ratio": opened.load_ratio}
    halves = {"gap_rad": opened.gap_half_rad, "load_ratio": RATIO_HALF}
    verdict.names.append(BACKLASH)
    verdict.effects.append((BACKLASH, params | {"f_res_hz": FLANK_HZ, "damping_ratio": FLANK_DAMPING}))
    verdict.confidence[BACKLASH] = MOST_OF_A_SHAFT
    verdict.intervals[BACKLASH] = [Interval(BACKLASH, name, value, halves[name]) for name, value in params.items()]
    verdict.warnings.append(
        f"backlash: {opened}. Stiffness and damping of its flanks are not in such a log: model.toml has "
        f"{FLANK_HZ:g} Hz and {FLANK_DAMPING:g}"
    )


def _forget(verdict: Verdict, effect: str) -> None:
    """A name that a load which is missing now and then puts there."""
    if effect in verdict.names:
        verdict.names.remove(effect)
        verdict.effects = [each for each in verdict.effects if each[0] != effect]
        for table in (verdict.confidence, verdict.intervals, verdict.cannot_separate, verdict.called):
            table.pop(effect, None)


def _opened(found: Explained, log: int) -> _Open | None:
    recording = found.recordings[log]
    e = recording.equations
    if e.signals.period_s > SLOWEST_S:
        return None
    stiff = found.point | {term.name: term.off for term in found.model.terms if term.effect == SHAFT}
    left = found.model.residual(stiff, log, shaft_only=True)[FINE]
    if len(left) < LEAST_WINDOWS:
        return None
    inertia = e.plant["inertia_kgm2"]
    if INERTIA in found.point:
        inertia *= 1.0 + float(found.point[INERTIA][0])
    torque = left + inertia * e.acceleration(e.fine)
    scatter = 1.4826 * float(np.median(np.abs(left)))
    much = (np.abs(left) > BEYOND * scatter) & (np.abs(torque) > DRIVEN * scatter)
    centre = e.fine.centre[e.fine.used]
    much[much] = np.abs(left[much]) > BY_ROUNDING * _rounding(e, inertia, centre[much])
    share = -left[much] / np.where(torque[much] == left[much], np.inf, torque[much] - left[much])
    return _Open(share, centre[much], left, recording)


def _rounding(e: Equations, inertia: float, centre: NDArray[np.int64]) -> Array:
    """The torque that rounding of the angle to counts can leave in the windows around these rows, N m.

    It is a sawtooth over the angle, and noise that a window averages away, except where a row has a whole number of
    counts, or half of one or a third: there it stands still for the length of a window, and its second derivative,
    times the inertia, looks like a torque.
    """
    bump, theta = e.fine.bump, e.signals.theta_m_rad
    counts_per_rev = e.plant["counts_per_rev"]
    if counts_per_rev <= 0.0 or len(centre) == 0:
        return np.zeros(len(centre))
    first, last = np.clip(centre - bump.rows, 0, None), np.clip(centre + bump.rows, None, len(theta) - 1)
    counts = (theta[last] - theta[first]) / (last - first) * (counts_per_rev / (2.0 * np.pi))
    periods = np.linspace(0.0, 0.5, 50 * bump.rows)  # per row, of a line after sampling
    passed = np.abs(np.exp(2j * np.pi * np.outer(periods, np.arange(bump.rows))) @ bump.curve)
    left = np.zeros(len(centre))
    for order in SAWTOOTH_ORDERS:
        alias = np.abs(order * counts - np.round(order * counts))
        near = np.abs(periods - alias[:, None]) < order * SPEED_WITHIN / bump.rows
        left += np.max(np.where(near, passed, 0.0), axis=1) / order
    return np.asarray(inertia * left * 2.0 / counts_per_rev)


def _width(found: Explained, logs: Sequence[_Open], ratio: float) -> tuple[float, float, float]:
    """The gap with which a load that hangs on the measured rotor leaves least near the crossings; how far from it
    others leave hardly more; and what is left then, of what a stiff shaft leaves.

    How the load bounces is never quite right, so that sums of absolute values are compared.
    """
    left = np.zeros((len(FLANKS_HZ), len(GAPS_RAD)))
    stiff = 0.0
    for each in logs:
        e = each.recording.equations
        s, own = e.signals, ratio * e.plant["inertia_kgm2"]
        near = each.near(ratio)
        load = s.load_nm / own if s.has_load else None
        stiff += float(np.sum(np.abs(each.left[near])))
        for k, f_hz in enumerate(FLANKS_HZ):
            for n, gap_rad in enumerate(GAPS_RAD):
                swing = backlash.swing_of(s.theta_m_rad, f_hz, FLANK_DAMPING, float(gap_rad), s.period_s, load)
                left[k, n] += float(np.sum(np.abs(each.left + own * e.fine.curve(swing))[near]))
    least = left.min(axis=0)
    best = float(GAPS_RAD[int(np.argmin(least))])
    alike = GAPS_RAD[least < ALIKE * least.min()]
    half = max(GAP_SHARE * best, float(np.max(np.abs(alike - best))))
    return best, half, float(least.min()) / max(stiff, 1e-300)
