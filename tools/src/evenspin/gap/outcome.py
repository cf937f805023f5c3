"""How far a machine is from the validation records, which nothing was fitted to: the gap, its noise floor, traces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evenspin.compare import Replay
from evenspin.log.case import Case
from evenspin.log.csvfile import write_csv
from evenspin.log.experiments import VALIDATION
from evenspin.log.gap import GAP_SIGNALS, RecordGap, gap_of_record, gap_of_records
from evenspin.log.unit import Unit

SIGNALS = tuple(GAP_SIGNALS)
TRACE_COLUMNS = ("t_s", *SIGNALS)
TRACE_NAMES = {"validation": "", "validation_steps": "steps."}  # as the result format calls them
NOISE_SEEDS = (901, 902, 903)

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Trace:
    """A validation record, measured and simulated; columns of each table as SIGNALS."""

    record: str
    t_s: Array
    measured: Array
    simulated: Array

    @property
    def gap(self) -> RecordGap:
        return gap_of_record(self.record, self.simulated - self.measured)


@dataclass(frozen=True, slots=True)
class Outcome:
    """One machine on every validation record."""

    traces: tuple[Trace, ...]

    @property
    def records(self) -> tuple[RecordGap, ...]:
        return tuple(trace.gap for trace in self.traces)

    @property
    def gap(self) -> float:
        """nan where there is no validation record."""
        return gap_of_records(self.records)


class Validation:
    """The validation records of a case, ready for any machine."""

    def __init__(self, case: Case) -> None:
        self.case = case
        starts = case.starts_s()
        self.records = {name: case.experiments[name] for name in VALIDATION if name in case.experiments}
        self.replays = {
            name: Replay(case.path, case.meta, name, record, starts[name]) for name, record in self.records.items()
        }

    def outcome(self, unit: Unit) -> Outcome:
        return Outcome(
            tuple(
                Trace(name, record["t_s"], record.pick(SIGNALS).values, self.replays[name].run(SIGNALS, unit))
                for name, record in self.records.items()
            )
        )

    def noise_floor(self, unit: Unit) -> tuple[RecordGap, ...]:
        """The gap that a machine has to its own noisy log: what no model can close."""
        out = []
        for name, replay in self.replays.items():
            model = replay.run(SIGNALS, unit)
            noisy = [
                replay.run(SIGNALS, Unit(unit.effects, unit.factors, seed, (i + 0.5) / len(NOISE_SEEDS)))
                for i, seed in enumerate(NOISE_SEEDS)
            ]
            out.append(gap_of_record(name, np.concatenate([run - model for run in noisy])))
        return tuple(out)


def write_traces(folder: Path, case: str, outcomes: Mapping[str, Outcome]) -> None:
    """CASE.WHEN.csv and CASE.steps.WHEN.csv for each WHEN (before, after)."""
    for when, outcome in outcomes.items():
        for trace in outcome.traces:
            path = folder / f"{case}.{TRACE_NAMES[trace.record]}{when}.csv"
            write_csv(path, TRACE_COLUMNS, np.column_stack((trace.t_s, trace.simulated)))
