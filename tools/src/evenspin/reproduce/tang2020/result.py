"""Run the conditions with their methods and collect what they give."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import NativeError
from evenspin.model import Setup
from evenspin.native import load, tables
from evenspin.reproduce.check import Check
from evenspin.reproduce.tang2020.checks import check_rows
from evenspin.reproduce.tang2020.conditions import CONDITIONS, METHODS, OFF, Condition
from evenspin.reproduce.tang2020.measure import Evenness, evenness, rms_by_turn, settled_s
from evenspin.reproduce.tang2020.sweep import SPEEDS_RPM, SweepPoint, check_sweep, sweep_point
from evenspin.sim import Record, complete, prepare
from evenspin.sim.many import Progress, plain, run_all

Array = NDArray[np.float64]

SIGNALS = ("t_s", "true_speed_rad_s", "true_theta_m_rad", "fault", "observer_innovation")
# Kept for pictures beside them where the currents are the point.
CURRENTS = ("ia_a", "ib_a", "true_ia_a", "true_ib_a", "true_ic_a")
VISIBLE = 0.03  # lines below this part of the rms, without observer, have no ratio
BEFORE_S = 1.5  # shown before the first window


@dataclass(frozen=True, slots=True)
class Run:
    """One condition with one method. `record`, from before the first window on, is kept only for pictures."""

    condition: Condition
    method: str
    setup: Setup
    seen: Sequence[Evenness]  # one per window
    innovation: float
    turn_s: Array
    turn_rms_rpm: Array
    memory_a: Array
    record: Record | None


@dataclass(frozen=True, slots=True)
class Result:
    """Everything that `evenspin reproduce tang2020` found."""

    numeric: str
    runs: Sequence[Run]
    rows: Sequence[Mapping[str, Any]]
    sweep: Sequence[SweepPoint]
    checks: Sequence[Check]

    @property
    def passed(self) -> bool:
        return all(check.passed for check in self.checks if check.required)

    def run(self, condition: str, method: str) -> Run | None:
        found = (run for run in self.runs if run.condition.name == condition and run.method == method)
        return next(found, None)

    def as_json(self) -> dict[str, Any]:
        content: dict[str, Any] = {
            "paper": "Tang et al. 2020, IEEE Transactions on Industrial Electronics 67",
            "numeric": self.numeric,
            "passed": self.passed,
            "rows": list(self.rows),
            "checks": [check.as_json() for check in self.checks],
        }
        if self.sweep:
            content["sweep"] = [point.as_json() for point in self.sweep]
        return plain(content)


def reproduce(
    numeric: str = "float",
    methods: Sequence[str] = METHODS,
    *,
    conditions: Sequence[str] | None = None,
    sweep: bool = False,
    keep_records: bool = False,
    progress: Progress | None = None,
) -> Result:
    """Run it; `conditions` names those to run (all), `sweep` adds aro-beyond at many speeds, `keep_records` what the
    pictures need.
    """
    chosen = [condition for condition in CONDITIONS if conditions is None or condition.name in conditions]
    load(numeric)
    wanted = {*methods, *(("aro-k21",) if "aro" in methods else ())}
    jobs: dict[tuple[object, ...], tuple[Condition, str]] = {}
    for condition in chosen:
        for method in (OFF, *condition.methods):
            if method in wanted or (method == OFF and wanted & set(condition.methods)):
                jobs.setdefault(_key(condition, method), (condition, method))
    work: list[Callable[[], Any]] = [_later(*job, numeric, keep_records) for job in jobs.values()]
    speeds = SPEEDS_RPM if sweep else ()
    work += [_point_later(rpm, numeric) for rpm in speeds]
    done = run_all(work, progress)
    runs = dict(zip(jobs, done[: len(jobs)], strict=True))
    rows = [
        row
        for condition in chosen
        for method in condition.methods
        if method in wanted
        for row in _rows(runs[_key(condition, OFF)], runs[_key(condition, method)], condition)
    ]
    points = done[len(jobs) :]
    return Result(numeric, list(runs.values()), rows, points, [*check_rows(rows), *check_sweep(points)])


def _key(condition: Condition, method: str) -> tuple[object, ...]:
    return (OFF, *condition.off_key) if method == OFF else (condition.name, method)


def _later(condition: Condition, method: str, numeric: str, keep: bool) -> Callable[[], Run]:
    mechanics = all(name.startswith("observer_") for name in condition.factors)
    return lambda: _run(condition, method, numeric, keep and mechanics)


def _point_later(rpm: float, numeric: str) -> Callable[[], SweepPoint]:
    return lambda: sweep_point(rpm, numeric)


def _run(condition: Condition, method: str, numeric: str, keep: bool) -> Run:
    setup = condition.setup(method)
    signals = (*SIGNALS, *CURRENTS) if keep and "current_offset" in setup.effects else SIGNALS
    simulation = prepare(setup, signals, numeric)
    record = complete(simulation, setup, signals)
    if record["fault"].any():
        fault = tables().faults[int(record["fault"].max())]
        raise NativeError(f"{condition.name}, {method}: the drive tripped: {fault.name}; {fault.check}")
    windows = condition.windows_of(method)
    turn_s, turn_rms_rpm = rms_by_turn(record)
    return Run(
        condition=condition,
        method=method,
        setup=setup,
        seen=[evenness(record, window.start_s, window.end_s) for window in windows],
        innovation=float(record["observer_innovation"][-1]),
        turn_s=turn_s,
        turn_rms_rpm=turn_rms_rpm,
        memory_a=simulation.memory(),
        record=record.between(windows[0].start_s - BEFORE_S, setup.duration_s) if keep else None,
    )


def _rows(off: Run, on: Run, condition: Condition) -> list[dict[str, Any]]:
    """One row per window."""
    rows = []
    for index, window in enumerate(condition.windows):
        before, after = off.seen[min(index, len(off.seen) - 1)], on.seen[index]
        steady = condition.off_windows is not None
        settled = settled_s(on.turn_s, on.turn_rms_rpm, 0.1 * before.rms_rpm) if steady else None
        seen = [order for order, amplitude in before.orders.items() if amplitude >= VISIBLE * before.rms_rpm]
        rows.append(
            {
                "condition": f"{condition.name}, {window.name}" if window.name else condition.name,
                "method": on.method,
                "speed_rpm": condition.speed_rpm,
                "rms_off_rpm": before.rms_rpm,
                "rms_on_rpm": after.rms_rpm,
                "reduction_pct": _reduction(before.rms_rpm, after.rms_rpm),
                "pp_off_rpm": before.pp_rpm,
                "pp_on_rpm": after.pp_rpm,
                "pp_reduction_pct": _reduction(before.pp_rpm, after.pp_rpm),
                # Change of each mechanical order in dB, and what it was and is.
                "orders": {str(order): _db(after.orders[order] / before.orders[order]) for order in seen},
                "orders_off_rpm": {str(order): before.orders[order] for order in seen},
                "orders_on_rpm": {str(order): after.orders[order] for order in seen},
                "observer_innovation": on.innovation,
                "time_to_90_pct_s": settled,
                "window_s": [window.start_s, window.end_s],
            }
        )
    return rows


def _reduction(before: float, after: float) -> float:
    return 100.0 * (1.0 - after / before)


def _db(ratio: float) -> float:
    return 20.0 * math.log10(max(ratio, 1e-12))
