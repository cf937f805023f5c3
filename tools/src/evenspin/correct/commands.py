"""What was commanded in a record: its curves as few points, for a drive that is to do the same again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evenspin.compare import Replay
from evenspin.compare.load import steady_load
from evenspin.log.case import Case
from evenspin.log.experiments import LOCKED, LOCKED_HZ, Experiment
from evenspin.model import InputCurve
from evenspin.sim.record import Record

Array = NDArray[np.float64]

MANY = 100  # changes of a reference: it is a ramp and no sequence of steps
RAMP_SHARE = 0.004  # of the largest value: as far as straight lines may be off it
STEP_SHARE = 1e-5
LOAD_SHARE = 0.02  # of the largest load: what moves less is noise of the torque sensor
LOAD_HOLD_ROWS = 100


def commanded(case: Case, names: list[str]) -> list[Experiment]:
    """The experiments of these records, in the order of the case."""
    return [_experiment(case, name, record) for name, record in case.experiments.items() if name in names]


def _experiment(case: Case, name: str, record: Record) -> Experiment:
    t_s = record["t_s"] - record["t_s"][0]
    step_s = float(np.median(np.diff(t_s)))
    duration_s = round(float(t_s[-1]) + step_s, 4)
    if name in LOCKED:
        curves = {key: _curve(t_s, record[key]) for key in ("id_ref_a", "iq_ref_a")}
        return Experiment(name, "current", duration_s, min(LOCKED_HZ, round(1.0 / step_s, 3)), curves, True)
    curves = {"speed_ref_rad_s": _curve(t_s, record["speed_ref_rad_s"])}
    load = record["load_torque_nm"]
    if np.isfinite(load).any() and np.nanmax(np.abs(load)) > 0.0:
        curves["load_torque_nm"] = _load(t_s, load)
    released = Replay(case.path, case.meta, name, record).released_at()
    return Experiment(
        name, "speed", duration_s, round(1.0 / step_s, 3), curves,
        current_from_s=None if released is None else round(float(t_s[released]), 4),
    )  # fmt: skip


def _curve(t_s: Array, value: Array) -> InputCurve:
    least = STEP_SHARE * float(np.max(np.abs(value)))
    changes = np.flatnonzero(np.abs(np.diff(value)) > least) + 1
    if len(changes) <= MANY:
        rows = [0, *(int(i) for i in changes)]
        return InputCurve(tuple(round(float(t_s[i]), 5) for i in rows), tuple(round(float(value[i]), 6) for i in rows))
    rows = _corners(t_s, value, RAMP_SHARE * float(np.max(np.abs(value))))
    return InputCurve(
        tuple(round(float(t_s[i]), 5) for i in rows), tuple(round(float(value[i]), 6) for i in rows), linear=True
    )


def _load(t_s: Array, reading_nm: Array) -> InputCurve:
    """Levels that are held; what lies between two of them is the way from one to the other."""
    load = steady_load(reading_nm)
    least = LOAD_SHARE * float(np.max(np.abs(load)))
    rows, values = [0], [float(np.mean(load[:LOAD_HOLD_ROWS]))]
    at = 1
    while at < len(load):
        if abs(load[at] - values[-1]) > least:
            level = float(np.median(load[at : at + LOAD_HOLD_ROWS]))
            if abs(level - values[-1]) > least:
                rows.append(at)
                values.append(level)
                at += LOAD_HOLD_ROWS
                continue
        at += 1
    return InputCurve(tuple(round(float(t_s[i]), 5) for i in rows), tuple(round(v, 6) for v in values))


def _corners(t_s: Array, value: Array, tolerance: float) -> list[int]:
    """Rows whose polygon is nowhere farther from the curve (Ramer, Douglas and Peucker)."""
    kept, waiting = {0, len(value) - 1}, [(0, len(value) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        part = slice(first, last + 1)
        straight = np.interp(t_s[part], (t_s[first], t_s[last]), (value[first], value[last]))
        off = np.abs(value[part] - straight)
        worst = first + int(np.argmax(off))
        if off[worst - first] > tolerance and first < worst < last:
            kept.add(worst)
            waiting += [(first, worst), (worst, last)]
    return sorted(kept)
