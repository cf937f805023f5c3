"""Run the motions with every method and collect what they give."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from evenspin.errors import NativeError
from evenspin.identify.experiments import Experiment, by_kind, perform, plan, torque_per_a
from evenspin.identify.result import KINDS, Identified, identify
from evenspin.identify.source import Run as LoggedRun
from evenspin.identify.source import run_of
from evenspin.model import Setup, builtin_scenario
from evenspin.native import load, tables
from evenspin.reproduce.check import Check
from evenspin.reproduce.yeh2024.checks import check_identified, check_rows
from evenspin.reproduce.yeh2024.measure import SIGNALS, Row, row_of
from evenspin.reproduce.yeh2024.printed import SPEEDS_RPM
from evenspin.sim import Record, simulate
from evenspin.sim.many import Progress, plain, run_all

MODEL = "yeh2024"
METHODS = ("ppi", "silc", "src", "rdc", "rdc-beyond")
WITH_WRONG_MODELS = ("rdc", "rdc-beyond")
WRONG_RPM = 20.0
ALL_WRONG = "all wrong"

# rdc-beyond: limited acceleration, its inertia fed forward, and slow learning of the torque that is left.
BEYOND = {"profile_accel_rad_s2": 20.0, "rdc_learn_gain": 0.3}


@dataclass(frozen=True, slots=True)
class Run:
    """One motion with one method; `models`: "true" or "all wrong"."""

    method: str
    speed_rpm: float
    models: str
    setup: Setup
    record: Record
    row: Row


@dataclass(frozen=True, slots=True)
class Result:
    """Everything that `evenspin reproduce yeh2024` found."""

    numeric: str
    runs: Sequence[Run]
    identified: Mapping[str, Any]
    checks: Sequence[Check] = field(default_factory=list)
    fit: Identified | None = None

    @property
    def rows(self) -> list[Row]:
        return [run.row for run in self.runs]

    @property
    def passed(self) -> bool:
        return all(check.passed for check in self.checks if check.required)

    def run(self, method: str, speed_rpm: float, models: str = "true") -> Run | None:
        wanted = (method, speed_rpm, models)
        return next((run for run in self.runs if (run.method, run.speed_rpm, run.models) == wanted), None)

    def as_json(self) -> dict[str, Any]:
        return plain(
            {
                "paper": "Yeh and Liu 2024, Machines 12(11), 771",
                "numeric": self.numeric,
                "passed": self.passed,
                "rows": [row for row in self.rows if row.get("models") != ALL_WRONG],
                "rows_all_wrong": [row for row in self.rows if row.get("models") == ALL_WRONG],
                "identified": self.identified,
                "checks": [check.as_json() for check in self.checks],
            }
        )


def drive_of(method: str) -> dict[str, float]:
    """Drive parameters of a method, on top of the scenario's."""
    word = "rdc" if method == "rdc-beyond" else method
    changes = {"position_method": tables().params["position_method"].to_number(word)}
    return changes | BEYOND if method == "rdc-beyond" else changes


def reproduce(numeric: str = "float", methods: Sequence[str] = METHODS, progress: Progress | None = None) -> Result:
    """Run it; with all methods, identify the machine from simulated experiments, too."""
    wrong = [method for method in WITH_WRONG_MODELS if method in methods]
    return gather(numeric, methods, wrong, KINDS if set(methods) == set(METHODS) else (), progress)


def gather(
    numeric: str, methods: Sequence[str], wrong: Sequence[str], kinds: Sequence[str], progress: Progress | None
) -> Result:
    """These methods at the three speeds, `wrong` with all models wrong, and these experiments of identification."""
    load(numeric)
    work: list[Callable[[], Any]] = [
        _later(method, f"rpm{rpm:g}", rpm, "true", numeric) for method in methods for rpm in SPEEDS_RPM
    ]
    work += [_later(method, "all_wrong", WRONG_RPM, "all wrong", numeric) for method in wrong]
    experiments = plan(MODEL, kinds) if kinds else []
    done = run_all([*(_experiment_later(each, numeric) for each in experiments), *work], progress)
    logs, runs = done[: len(experiments)], done[len(experiments) :]
    checks = check_rows([run.row for run in runs])
    if not experiments:
        return Result(numeric, runs, {}, checks)
    fit = identify(by_kind(logs))
    found = fit.as_json()
    if set(kinds) == set(KINDS):
        checks += check_identified(found)
    return Result(numeric, runs, found, checks, fit)


def _experiment_later(experiment: Experiment, numeric: str) -> Callable[[], LoggedRun]:
    return lambda: run_of(perform(experiment, numeric), experiment.name, torque_per_a(experiment))


def _later(method: str, scenario: str, speed_rpm: float, models: str, numeric: str) -> Callable[[], Run]:
    setup = builtin_scenario(f"yeh2024/{scenario}").with_changes(drive_of(method))

    def run() -> Run:
        record = simulate(setup, SIGNALS, numeric)
        if record["fault"].any():
            fault = tables().faults[int(record["fault"].max())]
            raise NativeError(f"{setup.name}, {method}: the drive tripped: {fault.name}; {fault.check}")
        return Run(method, speed_rpm, models, setup, record, row_of(record, method, speed_rpm, numeric, models))

    return run
