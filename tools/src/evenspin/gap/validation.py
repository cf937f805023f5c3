"""The gap on the validation records, which no fit has seen (docs/log-format.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from evenspin.compare import GAP_SIGNALS, VALIDATION, Replay
from evenspin.gap.tolerance import unit_of
from evenspin.log.case import Case

Array = NDArray[np.float64]
SIGNALS = tuple(GAP_SIGNALS)


class Validation:
    """The validation records of a case, ready to be simulated often."""

    def __init__(self, case: Case) -> None:
        names = [name for name in VALIDATION if name in case.experiments]
        self.replays = {name: Replay(case.path, case.meta, name, case.experiments[name]) for name in names}
        self.measured = {name: case.experiments[name].pick(SIGNALS).values for name in names}

    def gap(self, effects: Mapping[str, Mapping[str, float]], delta: Array | None = None) -> float:
        """Root mean square over signals and records, no unit; nan without validation records."""
        unit = unit_of(effects, delta)
        squares = [
            np.mean(((replay.run(SIGNALS, unit) - self.measured[name]) / tuple(GAP_SIGNALS.values())) ** 2)
            for name, replay in self.replays.items()
        ]
        return float(np.sqrt(np.mean(squares))) if squares else float("nan")
