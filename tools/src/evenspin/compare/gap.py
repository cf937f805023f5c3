"""The gap between the validation records of a case and their re-simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from evenspin.compare.resimulate import resimulate
from evenspin.compare.sound import check_for_comparison
from evenspin.errors import InputError
from evenspin.log.case import Case, read_case
from evenspin.log.experiments import VALIDATION
from evenspin.log.gap import GAP_SIGNALS, RecordGap, gap_of_record, gap_of_records


@dataclass(frozen=True, slots=True)
class CaseGap:
    case: str
    records: tuple[RecordGap, ...]

    @property
    def gap(self) -> float:
        return gap_of_records(self.records)


def record_gap(case: Case, name: str, effects: Mapping[str, Mapping[str, float]] | None = None) -> RecordGap:
    measured = case.experiments[name]
    simulated = resimulate(case.path, case.meta, name, measured, tuple(GAP_SIGNALS), effects)
    return gap_of_record(name, simulated - measured.pick(tuple(GAP_SIGNALS)).values)


def case_gap(folder: Path, effects: Mapping[str, Mapping[str, float]] | None = None) -> CaseGap:
    """Gap over the validation records of a case folder."""
    case = read_case(folder)
    names = [name for name in VALIDATION if name in case.experiments]
    if not names:
        raise InputError(
            folder, "experiments", list(case.experiments), "with validation or validation_steps", "record one"
        )
    check_for_comparison(case, names)
    return CaseGap(str(case.meta.get("case", folder.name)), tuple(record_gap(case, name, effects) for name in names))
