"""A table as it stood in a file: columns with the names and units that were printed, no meaning yet."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_COLUMNS = 2000


@dataclass(frozen=True, slots=True)
class RawColumn:
    """`values`: one number per row, NaN where the file has none. `unit`: as printed, "" where nothing is."""

    name: str
    unit: str
    values: Array


@dataclass(frozen=True, slots=True)
class RawTable:
    """Columns of equal length. `rate_hz`: rows per second where the file says so, else None."""

    path: Path
    kind: str
    columns: tuple[RawColumn, ...]
    rate_hz: float | None = None
    notes: tuple[str, ...] = field(default=())

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(column.name for column in self.columns)

    def __len__(self) -> int:
        return len(self.columns[0].values) if self.columns else 0

    def column(self, name: str) -> RawColumn | None:
        return next((column for column in self.columns if column.name == name), None)
