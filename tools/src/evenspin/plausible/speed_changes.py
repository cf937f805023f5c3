"""Changes from one speed to another: how much current each takes beside what flows before and after.

A controller answers load steps and torque ripple with current against the acceleration, so that a regression over a
whole log shows the wrong sign where those prevail. A change of the speed level does not: the current that makes it
flows only while it lasts, friction and load flow before and after it as well.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from evenspin.plausible.finding import Array
from evenspin.plausible.torque import mean_of

SMOOTH_S = 0.01
SMOOTH_SHARE, REST_SHARE = 1e-3, 4e-3  # of the log, where that is shorter: a log of one second shows fast changes
SMOOTH_ROWS = 4
LEAST_SHARE = 0.12  # of the range of the speed that a change has to cross
FAST = 0.2  # of a large acceleration: a change is under way
LARGE = (99.5, 97.0, 92.0)  # percentiles that may stand for a large one; load steps can be faster than all ramps
SETTLED = 0.35  # of the acceleration of a change: before and after it
REST_S = 0.06  # before and after
LONGEST_S = 3.0
LEAST = 3
MOST = 400
AGREE = 0.5  # share of the votes that decides, of -1..1


@dataclass(frozen=True, slots=True)
class SpeedChanges:
    """Current over acceleration of each, A s^2/rad, weighted by the change of speed; and the acceleration, rad/s^2."""

    slopes: Array
    weights: Array
    accelerations: Array

    @property
    def decide(self) -> bool:
        return len(self.slopes) >= LEAST and abs(self.vote) > AGREE

    @property
    def vote(self) -> float:
        """1: all currents accelerate; -1: all of them brake."""
        total = float(np.sum(self.weights))
        return float(np.sum(self.weights * np.sign(self.slopes))) / total if total > 0.0 else 0.0

    @property
    def slope(self) -> float:
        """Weighted median."""
        return self._at(0.5)

    @property
    def scatter(self) -> float:
        """Half the distance of the quartiles over the median."""
        return abs(0.5 * (self._at(0.75) - self._at(0.25)) / self.slope) if self.slope != 0.0 else np.inf

    def _at(self, share: float) -> float:
        order = np.argsort(self.slopes)
        below = np.cumsum(self.weights[order])
        return float(self.slopes[order][np.searchsorted(below, share * below[-1])])


def speed_changes(t_s: Array, speed: Array, current: Array) -> SpeedChanges:
    """Of a log with rows in the order of time."""
    step_s = float(np.median(np.diff(t_s))) if len(t_s) > 1 else 0.0
    whole_s = float(t_s[-1] - t_s[0]) if len(t_s) else 0.0
    n = max(SMOOTH_ROWS, round(min(SMOOTH_S, SMOOTH_SHARE * whole_s) / step_s)) if step_s > 0.0 else 0
    if n == 0 or len(t_s) < 20 * n:
        return SpeedChanges(np.empty(0), np.empty(0), np.empty(0))
    even = t_s[0] + step_s * np.arange(min(len(t_s), 1 + int((t_s[-1] - t_s[0]) / step_s)))
    w = mean_of(np.interp(even, t_s, speed), n)
    i = mean_of(np.interp(even, t_s, current), n)
    accel = (w[n:] - w[:-n]) / (n * step_s)
    middle = slice(n // 2, n // 2 + len(accel))
    rest = max(n, round(min(REST_S, REST_SHARE * whole_s) / step_s))
    tried = [
        list(_changes(accel, w[middle], i[middle], step_s, rest, FAST * float(large)))
        for large in np.percentile(np.abs(accel), LARGE)
    ]
    found = np.array(max(tried, key=lambda changes: sum(weight for _, weight, _ in changes))).reshape(-1, 3)
    return SpeedChanges(found[:, 0], found[:, 1], found[:, 2])


def _changes(
    accel: Array, w: Array, i: Array, step_s: float, rest: int, threshold: float
) -> Iterator[tuple[float, float, float]]:
    if len(accel) < 4 * rest:
        return
    low, high = np.percentile(w, (0.5, 99.5))
    fast = np.abs(accel) > threshold
    edges = np.flatnonzero(np.diff(np.concatenate(([False], fast, [False])).astype(int)))
    sums_i, sums_a = np.concatenate(([0.0], np.cumsum(i))), np.concatenate(([0.0], np.cumsum(accel)))
    runs = [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if a >= rest and b + rest <= len(w)]
    for start, end in sorted(runs, key=lambda run: -abs(w[run[1] - 1] - w[run[0]]))[:MOST]:
        change = w[end - 1] - w[start]
        if abs(change) < LEAST_SHARE * (high - low) or (end - start) * step_s > LONGEST_S:
            continue
        inside = (sums_a[end] - sums_a[start]) / (end - start)
        before = (sums_a[start] - sums_a[start - rest]) / rest
        after = (sums_a[end + rest] - sums_a[end]) / rest
        if max(abs(before), abs(after)) > SETTLED * abs(inside):
            continue
        flows = (sums_i[end] - sums_i[start]) / (end - start)
        beside = 0.5 * (sums_i[start] - sums_i[start - rest] + sums_i[end + rest] - sums_i[end]) / rest
        yield (flows - beside) / (inside - 0.5 * (before + after)), abs(change), abs(inside)
