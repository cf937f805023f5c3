"""Run the published scenarios with the four methods and collect what they give."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from evenspin.analysis.segments import SIGNALS
from evenspin.errors import NativeError
from evenspin.model import Setup, builtin_scenario
from evenspin.native import load, tables
from evenspin.reproduce.guo2024.checks import Check, check_fixed, check_rows
from evenspin.reproduce.guo2024.frequency import frequency_results
from evenspin.reproduce.guo2024.measure import Row, rows_of
from evenspin.reproduce.guo2024.stability import TRIALS, Trial, as_json, ripple_rpm
from evenspin.sim import Record, simulate
from evenspin.sim.many import Progress, plain, run_all

SETS = ("first", "second", "third")
METHODS = ("pi", "crc", "forc", "fal-forc", "fal-forc-beyond", "corrected")
BEYOND = "fal-forc-beyond"
CORRECTED = "corrected"


@dataclass(frozen=True, slots=True)
class Run:
    """One set with one method."""

    set_name: str
    method: str
    numeric: str
    setup: Setup
    record: Record
    rows: Sequence[Row]


@dataclass(frozen=True, slots=True)
class Result:
    """Everything that `evenspin reproduce guo2024` found."""

    numeric: str
    runs: Sequence[Run]
    float_rows: Sequence[Row]  # for the comparison of a fixed-point run
    gains_db: Mapping[str, Any]
    limits: Mapping[str, Any]
    checks: Sequence[Check] = field(default_factory=list)

    @property
    def rows(self) -> list[Row]:
        return [row for run in self.runs for row in run.rows]

    @property
    def passed(self) -> bool:
        return all(check.passed for check in self.checks if check.required)

    def as_json(self) -> dict[str, Any]:
        rows = self.rows
        content: dict[str, Any] = {
            "paper": "Guo et al. 2024, Actuators 13(2), 73",
            "numeric": self.numeric,
            "passed": self.passed,
            "rows": rows,
            "gains_db": self.gains_db,
            "limits": self.limits,
            "checks": [check.as_json() for check in self.checks],
        }
        if self.numeric == "fixed":
            content["float_rows"] = self.float_rows
        return plain(content)


def reproduce(
    numeric: str = "float",
    methods: Sequence[str] = METHODS,
    sets: Sequence[str] = SETS,
    progress: Progress | None = None,
) -> Result:
    """Run it. A fixed-point run is compared with the float one, which runs along."""
    load("float")
    load(numeric)
    pairs = [(set_name, method) for set_name in sets for method in methods]
    trials = [trial for trial in TRIALS if trial.method in methods]
    work: list[Callable[[], Any]] = [_run_later(set_name, method, numeric) for set_name, method in pairs]
    if numeric != "float":
        work += [_run_later(set_name, method, "float") for set_name, method in pairs]
    work += [_trial_later(trial, numeric) for trial in trials]
    done = run_all(work, progress)
    runs, later = done[: len(pairs)], done[len(pairs) :]
    float_runs, ripples = later[: len(later) - len(trials)], later[len(later) - len(trials) :]
    float_rows = [row for run in float_runs for row in run.rows]
    gains, limits, checks = frequency_results()
    rows = [row for run in runs for row in run.rows]
    checks = [*check_rows(rows), *(check_fixed(rows, float_rows) if float_rows else ()), *checks]
    checks += [
        Check(f"{trial.name} [rpm peak to peak]", "", ripple, trial.low_rpm, trial.high_rpm, required=True)
        for trial, ripple in zip(trials, ripples, strict=True)
    ]
    stability = [as_json(trial, ripple) for trial, ripple in zip(trials, ripples, strict=True)]
    return Result(numeric, runs, float_rows, gains, {**limits, "stability": stability}, checks)


def runs_of(sets: Sequence[str], methods: Sequence[str], numeric: str, progress: Progress | None = None) -> list[Run]:
    """Only the runs."""
    load(numeric)
    return run_all([_run_later(set_name, method, numeric) for set_name in sets for method in methods], progress)


def drive_of(method: str, set_name: str) -> Mapping[str, float]:
    """Drive parameters of a method, on top of the scenario's."""
    if method not in (BEYOND, CORRECTED):
        return {"method": tables().params["method"].to_number(method)}
    printed = builtin_scenario("guo2024/first").setup.drive
    beyond = f"beyond{'_fast' if set_name == 'third' else ''}"
    other = builtin_scenario(f"guo2024/{CORRECTED if method == CORRECTED else beyond}").setup.drive
    return {name: value for name, value in other.items() if value != printed[name]}


def _run_later(set_name: str, method: str, numeric: str) -> Callable[[], Run]:
    setup = builtin_scenario(f"guo2024/{set_name}").with_changes(drive_of(method, set_name))

    def run() -> Run:
        record = simulate(setup, (*SIGNALS, "fault"), numeric)
        if record["fault"].any():
            fault = tables().faults[int(record["fault"].max())]
            raise NativeError(f"{setup.name}, {method}: the drive tripped: {fault.name}; {fault.check}")
        return Run(set_name, method, numeric, setup, record, rows_of(setup, record, set_name, method, numeric))

    return run


def _trial_later(trial: Trial, numeric: str) -> Callable[[], float]:
    return lambda: ripple_rpm(trial, numeric)
