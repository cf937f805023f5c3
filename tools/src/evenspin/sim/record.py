"""What a run recorded: named columns with units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Record:
    """`values` has a row per sample and a column per name; `record["speed_rad_s"]` is a column."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: NDArray[np.float64]

    def __post_init__(self) -> None:
        self.values.flags.writeable = False

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.values[:, self.names.index(name)]

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def __len__(self) -> int:
        return len(self.values)

    def unit(self, name: str) -> str:
        return self.units[self.names.index(name)]

    def pick(self, names: Sequence[str]) -> Record:
        """Only these columns, in this order."""
        columns = [self.names.index(name) for name in names]
        return Record(tuple(names), tuple(self.units[i] for i in columns), self.values[:, columns])

    def between(self, start_s: float, end_s: float) -> Record:
        """Rows with start_s <= t_s < end_s."""
        first, last = np.searchsorted(self["t_s"], (start_s - 1e-9, end_s - 1e-9))
        return Record(self.names, self.units, self.values[first:last])
