"""What is wrong with a column, in the words of an error."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import EvenspinError, InputError, one_line

Array = NDArray[np.float64]

MOST = 1e9  # no signal of a drive is larger, in any unit
MOST_TIME = 1e16  # microseconds since 1970 are fewer


@dataclass(frozen=True, slots=True)
class Finding:
    column: str
    data: str  # what the data say
    must: str
    hint: str  # what is likely wrong, and what to do

    def error(self, where: str | Path) -> InputError:
        return ColumnError(where, self.column, self.data, self.must, self.hint)


class ColumnError(InputError):
    """The value is what the data of a column say, in words."""

    def __str__(self) -> str:
        return one_line(f"{self.where}: {self.key}: {self.value}: must be {self.must}; {self.hint}")


class ChannelError(EvenspinError):
    """A log that says nothing."""

    def __init__(self, where: str | Path, data: str, hint: str) -> None:
        super().__init__(one_line(f"{where}: {data}; {hint}"))


def is_signal(column: Array, name: str = "") -> NDArray[np.bool_]:
    """Rows with a number that a drive can have."""
    return np.abs(column) < (MOST_TIME if name == "t_s" else MOST)


def rms(x: Array) -> float:
    return float(np.sqrt(np.mean(np.square(x)))) if np.size(x) else 0.0


def share(left: Array, of: Array) -> float:
    """How much of a signal is not explained; infinite where there is no signal."""
    size = rms(of)
    return rms(left) / size if size > 0.0 else float("inf")
