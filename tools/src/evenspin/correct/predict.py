"""The machine that was found, with and without a correction in its drive: the firmware in the loop.

A record of the log is simulated again from its references, as the gap workflow does it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.compare import Replay
from evenspin.correct.changes import Change, composed
from evenspin.correct.found import Found
from evenspin.correct.quantities import KINDS, Drive, Quantity, Records
from evenspin.errors import EvenspinError
from evenspin.log.case import Case
from evenspin.log.unit import Unit
from evenspin.native import tables
from evenspin.sim.record import Record

SIGNALS = ("speed_rad_s", "theta_m_rad", "iq_ref_a", "id_a", "iq_a", "vd_v", "vq_v")
GIVEN = ("t_s", "speed_ref_rad_s", "id_ref_a", "load_torque_nm")  # of the log, which the simulation follows
MACHINES = 6  # at ends of the intervals
AGAIN = 2  # times the machine without correction is simulated once more: another noise, another place of the shaft
SEED = 61

Corrections = Mapping[str, Sequence[Change]]


@dataclass(frozen=True, slots=True)
class Prediction:
    """One quantity: in the log, simulated without and with the correction, and what the intervals make of the last.

    `healthy`: of the machine without the effects, which no correction gets below. `without_low`: the least of
    some runs without the correction that differ by chance alone; nan where nobody has simulated them.
    """

    log: float
    healthy: float
    without: float
    corrected: float
    low: float
    high: float
    without_low: float = math.nan

    @property
    def reduction(self) -> float:
        """Share that the correction takes away of what the effects add."""
        return reduction(self.without, self.corrected, self.healthy)


def reduction(before: float, after: float, healthy: float = 0.0) -> float:
    """Share that is taken away of what stands above the healthy machine, whose part is independent of the rest."""
    over = [math.sqrt(max(value**2 - healthy**2, 0.0)) for value in (before, after)]
    return 1.0 - over[1] / over[0] if over[0] > 0.0 else 0.0


class Simulated:
    """The records of a case, ready to be simulated with any correction."""

    def __init__(self, case: Case, found: Found) -> None:
        self.case, self.found = case, found
        self._replays: dict[str, Replay] = {}
        self._designed: dict[str, Record] = {}
        defaults = {name: field.default for name, field in tables().params.items()}
        self.before = {**defaults, **found.nominal.drive}

    def records(self, names: Sequence[str], unit: Unit, corrections: Corrections) -> dict[str, Record]:
        drive = composed(corrections, self.before)
        return {name: self._record(name, unit, drive) for name in names if name in self.case.experiments}

    def drive(self, quantity: Quantity) -> Drive:
        return Drive.of(self.case.meta, self.designed(quantity.records) if KINDS[quantity.kind].designed else {})

    def designed(self, names: Sequence[str]) -> Records:
        for name in names:
            if name in self.case.experiments and name not in self._designed:
                self._designed[name] = self._record(name, Unit(), {})
        return self._designed

    def predict(self, quantity: Quantity, corrections: Corrections, effects: Sequence[str]) -> Prediction:
        """Of the quantity that `effects` spoil. Machines at the ends of the intervals get the correction that was made
        for the middle."""
        drive = self.drive(quantity)
        random = np.random.default_rng(SEED)

        def measured(found: Found, given: Corrections, seed: int) -> float:
            unit = found.unit(seed, float(random.random()))
            return quantity.measured(self.records(quantity.records, unit, given), drive)

        healthy = measured(self.found.less(effects), {}, SEED)
        without = measured(self.found, {}, SEED)
        others = [measured(self.found.other(random), corrections, SEED + i) for i in range(1, MACHINES + 1)]
        ideal = measured(self.found, corrections, SEED)
        likely = float(np.mean([ideal, *others]))
        again = [measured(self.found, {}, SEED + MACHINES + i) for i in range(1, AGAIN + 1)]
        return Prediction(
            quantity.measured(self.case.experiments, drive),
            healthy,
            without,
            likely,
            min(ideal, *others),
            max(ideal, *others),
            min(without, *again),
        )

    def best(
        self, quantity: Quantity, changes: Sequence[Change], choices: Sequence[Sequence[Change]]
    ) -> Sequence[Change]:
        """The choice that leaves least of the quantity beside these changes, of those that the drive takes."""
        drive, unit = self.drive(quantity), self.found.unit(SEED)
        left: dict[int, float] = {}
        for number, choice in enumerate(choices):
            try:
                measured = quantity.measured(self.records(quantity.records, unit, {"": (*changes, *choice)}), drive)
            except EvenspinError:
                if number == len(choices) - 1 and not left:
                    raise
                continue
            left[number] = measured if math.isfinite(measured) else math.inf
        return choices[min(left, key=left.__getitem__)]

    def grows(self, quantity: Quantity, changes: Sequence[Change]) -> tuple[float, float]:
        """The quantity of the machine that was found, without and with these changes."""
        drive, unit = self.drive(quantity), self.found.unit(SEED)
        without, corrected = (
            quantity.measured(self.records(quantity.records, unit, given), drive) for given in ({}, {"": changes})
        )
        return without, corrected

    def _record(self, name: str, unit: Unit, drive: Mapping[str, float]) -> Record:
        if name not in self._replays:
            self._replays[name] = Replay(self.case.path, self.case.meta, name, self.case.experiments[name])
        return _simulated(self._replays[name], self.case.experiments[name], unit, drive)


def designed(folder: Path, meta: Mapping[str, Any], records: Records) -> dict[str, Record]:
    """What the machine of meta.json does with the gains of meta.json from the references of these records."""
    return {
        name: _simulated(Replay(folder, meta, name, record), record, Unit(), {}) for name, record in records.items()
    }


def _simulated(replay: Replay, measured: Record, unit: Unit, drive: Mapping[str, float]) -> Record:
    values = replay.run(SIGNALS, unit, drive=drive)
    given = measured.pick(GIVEN)
    units = (*given.units, *(tables().signals[signal].unit for signal in SIGNALS))
    return Record((*GIVEN, *SIGNALS), units, np.column_stack((given.values, values)))
