"""The last rows of the stream, in one place for all pages.

The thread that reads the drive writes and never waits; each page reads from where it was. A page that is late gets its
arrears as minimum and maximum per stretch of time, so that a slow page costs itself detail and nobody else anything.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

CAPACITY_ROWS = 1 << 18  # more than 4 minutes at 1 kHz; 8 signals are 8 MB
REDUCE_ABOVE_ROWS = 4096


@dataclass(frozen=True, slots=True)
class Rows:
    """`t_s` is the time since the start of the drive. A row of NaN stands where rows were lost."""

    t_s: NDArray[np.float64]
    values: NDArray[np.float32]  # a row per time
    reduced: bool = False  # pairs of minimum and maximum instead of rows

    def __len__(self) -> int:
        return len(self.t_s)


class History:
    """A ring. One thread appends, any thread reads."""

    def __init__(self, names: tuple[str, ...], capacity: int = CAPACITY_ROWS) -> None:
        self.names = names
        self._guard = threading.Lock()
        self._t_s = np.empty(capacity)
        self._values = np.empty((capacity, len(names)), np.float32)
        self._written = 0  # rows since the beginning

    @property
    def written(self) -> int:
        return self._written

    def append(self, t_s: NDArray[np.float64], values: NDArray[np.float32], *, gap_before: bool = False) -> None:
        with self._guard:
            if gap_before and self._written:
                self._put(t_s[:1], np.full((1, len(self.names)), np.nan, np.float32))
            self._put(t_s, values)

    def _put(self, t_s: NDArray[np.float64], values: NDArray[np.float32]) -> None:
        capacity = len(self._t_s)
        t_s, values = t_s[-capacity:], values[-capacity:]
        places = (self._written + np.arange(len(t_s))) % capacity
        self._t_s[places] = t_s
        self._values[places] = values
        self._written += len(t_s)

    def since(self, cursor: int) -> tuple[int, Rows]:
        """The rows behind a cursor and the cursor for the next call; what the ring no longer holds is left out."""
        with self._guard:
            end = self._written
            first = max(cursor, end - len(self._t_s), 0)
            places = np.arange(first, end) % len(self._t_s)
            return end, Rows(self._t_s[places], self._values[places])

    def last(self, seconds: float) -> Rows:
        """The rows of the last seconds, without lost ones."""
        _, rows = self.since(0)
        if not len(rows):
            return rows
        first = int(np.searchsorted(rows.t_s, rows.t_s[-1] - seconds))
        t_s, values = rows.t_s[first:], rows.values[first:]
        whole = np.isfinite(values).all(axis=1)
        return Rows(t_s[whole], values[whole])


def reduce_rows(rows: Rows, pairs: int) -> Rows:
    """At most so many pairs of rows: minimum and maximum of each signal over equal numbers of rows. No peak is lost."""
    if len(rows) <= 2 * pairs:
        return rows
    edges = np.linspace(0, len(rows), pairs + 1).astype(int)[:-1]
    low = np.fmin.reduceat(rows.values, edges, axis=0)
    high = np.fmax.reduceat(rows.values, edges, axis=0)
    middle = (edges + np.append(edges[1:], len(rows))) // 2
    t_s = np.empty(2 * pairs)
    values = np.empty((2 * pairs, rows.values.shape[1]), np.float32)
    t_s[0::2], t_s[1::2] = rows.t_s[edges], rows.t_s[middle]
    values[0::2], values[1::2] = low, high
    return Rows(t_s, values, reduced=True)
