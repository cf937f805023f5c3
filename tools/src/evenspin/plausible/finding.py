"""What is wrong with a column, in the words of an error."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Finding:
    column: str
    data: str  # what the data say
    must: str
    hint: str  # what it looks like, and what to do

    def error(self, where: str | Path) -> InputError:
        return InputError(where, self.column, self.data, self.must, self.hint)


def rms(x: Array) -> float:
    return float(np.sqrt(np.mean(np.square(x)))) if np.size(x) else 0.0


def share(left: Array, of: Array) -> float:
    """How much of a signal is not explained; infinite where there is no signal."""
    size = rms(of)
    return rms(left) / size if size > 0.0 else float("inf")
