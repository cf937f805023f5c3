"""The gap between a log and a simulation of it, as docs/log-format.md defines it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

GAP_SIGNALS = {"speed_rad_s": 1.0, "id_a": 0.1, "iq_a": 0.1, "vd_v": 1.0, "vq_v": 1.0}  # and the unit of each
GAP_UNITS = ("rad/s", "A", "A", "V", "V")


@dataclass(frozen=True, slots=True)
class RecordGap:
    """rms difference per signal, in the signal's own unit, and all together over their gap units."""

    record: str
    rms: Mapping[str, float]
    gap: float


def gap_of_record(record: str, difference: NDArray[np.float64]) -> RecordGap:
    """From simulation less log: a column per signal of GAP_SIGNALS, in that order."""
    rms = {signal: float(np.sqrt(np.mean(difference[:, i] ** 2))) for i, signal in enumerate(GAP_SIGNALS)}
    return RecordGap(record, rms, _rms([rms[signal] / unit for signal, unit in GAP_SIGNALS.items()]))


def gap_of_records(records: Iterable[RecordGap]) -> float:
    """Root mean square over the records; nan where there are none."""
    return _rms([record.gap for record in records])


def _rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean([value**2 for value in values]))) if values else math.nan
