"""The gap between a log and its re-simulation, as docs/log-format.md defines it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evenspin.compare.resimulate import VALIDATION, resimulate
from evenspin.compare.sound import check_for_comparison
from evenspin.errors import InputError
from evenspin.log.case import Case, read_case

GAP_SIGNALS = {"speed_rad_s": 1.0, "id_a": 0.1, "iq_a": 0.1, "vd_v": 1.0, "vq_v": 1.0}  # and the unit of each
GAP_UNITS = ("rad/s", "A", "A", "V", "V")


@dataclass(frozen=True, slots=True)
class RecordGap:
    """rms difference per signal, in the signal's own unit, and all together over their gap units."""

    record: str
    rms: Mapping[str, float]
    gap: float


@dataclass(frozen=True, slots=True)
class CaseGap:
    case: str
    records: tuple[RecordGap, ...]

    @property
    def gap(self) -> float:
        """Root mean square over the records."""
        return float(np.sqrt(np.mean([record.gap**2 for record in self.records])))


def record_gap(case: Case, name: str, effects: Mapping[str, Mapping[str, float]] | None = None) -> RecordGap:
    measured = case.experiments[name]
    simulated = resimulate(case.path, case.meta, name, measured, tuple(GAP_SIGNALS), effects)
    rms = {
        signal: float(np.sqrt(np.mean((simulated[:, i] - measured[signal]) ** 2)))
        for i, signal in enumerate(GAP_SIGNALS)
    }
    gap = float(np.sqrt(np.mean([(rms[signal] / unit) ** 2 for signal, unit in GAP_SIGNALS.items()])))
    return RecordGap(name, rms, gap)


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
