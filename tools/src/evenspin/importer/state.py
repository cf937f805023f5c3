"""What a guess knows so far: the columns that were chosen, their units, and what is still open."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.importer.choose import Choice
from evenspin.importer.names import QUANTITIES
from evenspin.importer.table import RawTable
from evenspin.importer.units import Unit, unit_of

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Known:
    """What is known beside the file."""

    pole_pairs: int | None = None
    counts_per_turn: float | None = None
    rate_hz: float | None = None


@dataclass(slots=True)
class State:
    """Filled step by step, by time first, then motion, then currents and the rest."""

    table: RawTable
    known: Known
    chosen: dict[str, Choice]
    questions: list[str]
    notes: list[str] = field(default_factory=list)
    units: dict[str, str] = field(default_factory=dict)
    scale: dict[str, float] = field(default_factory=dict)
    pole_pairs: int | None = None
    counts: float | None = None
    rate_hz: float | None = None

    def unit(self, quantity: str) -> Unit:
        unit = unit_of(self.units.get(quantity, ""))
        return unit if unit is not None else Unit(QUANTITIES[quantity], 1.0)

    def values(self, quantity: str) -> Array:
        return self.chosen[quantity].column.values

    def name(self, quantity: str) -> str:
        return self.chosen[quantity].column.name

    def free(self) -> list[int]:
        """Numbers of the columns that no quantity has."""
        taken = {choice.column.name for choice in self.chosen.values()}
        return [i for i, column in enumerate(self.table.columns) if column.name not in taken]

    def because(self, quantity: str, reason: str) -> None:
        choice = self.chosen[quantity]
        self.chosen[quantity] = replace(choice, reason=f"{choice.reason}; {reason}")

    def seconds(self) -> Array | None:
        """Time in the column's own unit; rows by the rate without a column; None when neither is known."""
        if "t_s" in self.chosen:
            return self.values("t_s")
        return np.arange(len(self.table)) / self.rate_hz if self.rate_hz else None
