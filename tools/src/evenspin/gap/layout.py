"""The parts of a record that are compared: steady stretches, bins after a step, bins along a ramp.

They follow from the log alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.compare import Replay
from evenspin.compare.load import WINDOW, steady_stretches
from evenspin.gap.thresholds_records import COAST_SHARE, COAST_TURNS, MOVING_RAD_S, SETTLE_S, STEADY_MIN_S
from evenspin.sim.record import Record

SETTLE_SHARE = 0.4  # of a stretch that is too short to settle
STEP_BINS_MS = (0, 2, 4, 6, 8, 10, 15, 20, 30, 40, 50, 65, 80, 100, 130, 160, 200, 250, 300)
FORGET_S = 0.1
RAMP_BIN_S = 0.025
COAST_WINDOW_S = 0.4
LOCKED_SAMPLES = 24  # one by one after a current step...
LOCKED_BINS = (24, 30, 40, 50, 75, 100, 150, 200, 300, 400, 500, 600, 800, 1000)  # ...then together


@dataclass(frozen=True, slots=True)
class Stretch:
    """Rows [start, end) of a record with constant references."""

    start: int
    end: int
    speed_rad_s: float  # reference, or what was measured while coasting
    load_nm: float
    coasting: bool = False


@dataclass(frozen=True, slots=True)
class Bins:
    """Edges of consecutive bins, in rows."""

    kind: str  # "step", "ramp" or "coast"
    edges: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Layout:
    record: str
    steady: tuple[Stretch, ...]
    bins: tuple[Bins, ...]

    @property
    def end(self) -> int:
        """Rows from here on are not compared."""
        return max([0, *(stretch.end for stretch in self.steady), *(int(bins.edges[-1]) for bins in self.bins)])


def layout_of(replay: Replay, record: Record) -> Layout:
    rate_hz = 1.0 / float(np.median(np.diff(record["t_s"])))
    if replay.locked:
        return Layout(replay.name, (), _locked_bins(record))
    end = replay.released_at() or len(record)
    load = np.nan_to_num(record["load_torque_nm"])
    cuts, ramps = _cuts(record["speed_ref_rad_s"][:end], load[:end], rate_hz)
    steady: list[Stretch] = []
    bins: list[Bins] = []
    turning = abs(float(record["speed_rad_s"][0])) > MOVING_RAD_S
    for start, stop in zip(cuts, cuts[1:], strict=False):
        if any(first < stop and start < last for first, last in ramps):
            bins.append(Bins("ramp", _even(start, stop, RAMP_BIN_S * rate_hz)))
            continue
        edges = _after_step(start, stop, rate_hz)
        if start == 0 and turning:  # the simulation starts at rest: give both the time to forget it
            edges = edges[edges >= FORGET_S * rate_hz]
        if len(edges) > 1:
            bins.append(Bins("step", edges))
        length = stop - start
        settled = start + min(round(SETTLE_S * rate_hz), round(SETTLE_SHARE * length))
        if stop - settled >= STEADY_MIN_S * rate_hz:
            ref = float(record["speed_ref_rad_s"][start])
            steady.append(Stretch(settled, stop, ref, float(np.median(load[settled:stop]))))
    if end < len(record):
        bins.append(Bins("step", _after_step(end, len(record), rate_hz)))
        slow = _slow_from(record["speed_rad_s"], end)
        bins.append(Bins("coast", _even(end, slow, 2.0 * RAMP_BIN_S * rate_hz)))
        window = round(COAST_WINDOW_S * rate_hz)
        for start in range(end + round(0.01 * rate_hz), slow - window + 1, window):
            speed = float(np.mean(record["speed_rad_s"][start : start + window]))
            if abs(speed) * COAST_WINDOW_S >= COAST_TURNS * 2.0 * math.pi:
                steady.append(Stretch(start, start + window, speed, 0.0, coasting=True))
    return Layout(replay.name, tuple(steady), tuple(bins))


def _slow_from(speed: NDArray[np.float64], released: int) -> int:
    """From here on a coasting rotor may rock to and fro in whatever torque depends on the angle: not reproducible."""
    window = min(20, len(speed) - released)
    fast = COAST_SHARE * abs(float(np.mean(speed[max(0, released - window) : released + 1])))
    below = np.flatnonzero(np.abs(speed[released:]) < fast)
    return released + max(int(below[0]), window) if len(below) else len(speed)


def _cuts(
    ref: NDArray[np.float64], load: NDArray[np.float64], rate_hz: float
) -> tuple[list[int], list[tuple[int, int]]]:
    """Rows at which something changes, with 0 and the end, and the ramps of the reference."""
    end = len(ref)
    moved = np.flatnonzero(np.diff(ref) != 0.0) + 1
    cuts, ramps = {0, end}, []
    gap = round(0.02 * rate_hz)
    for group in np.split(moved, np.flatnonzero(np.diff(moved) > gap) + 1) if len(moved) else []:
        first, last = int(group[0]), int(group[-1])
        cuts.update((first, last))
        if last > first:
            ramps.append((first, last))
    stands = steady_stretches(load)
    for (_, before), (after, _) in zip(stands, stands[1:], strict=False):
        if after - before < 10 * gap:
            cuts.add(before + WINDOW)
    merged = sorted(cuts)
    kept = [merged[0]]
    for cut in merged[1:-1]:
        if cut - kept[-1] >= gap and end - cut >= gap:
            kept.append(cut)
    return [*kept, end], ramps


def _after_step(start: int, stop: int, rate_hz: float) -> NDArray[np.int64]:
    edges = start + np.round(1e-3 * np.array(STEP_BINS_MS) * rate_hz).astype(np.int64)
    return np.unique(edges[edges <= stop])


def _even(start: int, stop: int, width: float) -> NDArray[np.int64]:
    return np.unique(np.round(np.linspace(start, stop, max(2, round((stop - start) / width) + 1))).astype(np.int64))


def _locked_bins(record: Record) -> tuple[Bins, ...]:
    moved = np.flatnonzero((np.diff(record["id_ref_a"]) != 0.0) | (np.diff(record["iq_ref_a"]) != 0.0)) + 1
    cuts = [0, *(int(row) for row in moved), len(record)]
    bins = []
    for start, stop in zip(cuts, cuts[1:], strict=False):
        edges = start + np.concatenate((np.arange(LOCKED_SAMPLES), LOCKED_BINS))
        bins.append(Bins("step", np.append(edges[edges < stop], stop)))
    return tuple(bins)
