"""Stretches that follow nothing that was found, such as a start against a stop: left out of the fit, and reported."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.time_grid import Flags

Array = NDArray[np.float64]

PIECE_S = 0.1  # judged as a whole: one that is off by OUTLIER times the median is left out
OUTLIER = 5.0
MOST_OUTLIERS = 0.15  # of the log


@dataclass(frozen=True, slots=True)
class Outlier:
    """Where the balance is off, and by how much."""

    start_s: float
    end_s: float
    off_a: float  # rms


def without_outliers(
    t_s: Array, left: Array, rows: Flags, good: Flags, current_a: float
) -> tuple[Flags, tuple[Outlier, ...]]:
    """Rows that remain. `left`: what the fit of these rows leaves of all that are `good`, A.

    Where the rotor rests or reverses, dry friction holds anything: there only twice the rms current is an outlier.
    """
    piece = np.floor((t_s - t_s[0]) / PIECE_S).astype(int)
    count = np.bincount(piece[good], minlength=piece[-1] + 1)
    level = np.sqrt(np.bincount(piece[good], left[good] ** 2, minlength=piece[-1] + 1) / np.maximum(count, 1))
    outlier = level > OUTLIER * float(np.median(level[np.unique(piece[rows])]))
    outlier &= (np.bincount(piece[rows], minlength=piece[-1] + 1) > 0.5 * count) | (level > 2.0 * current_a)
    if not np.any(outlier) or np.count_nonzero(outlier) > MOST_OUTLIERS * len(outlier):
        return rows, ()
    edges = np.flatnonzero(np.diff(np.concatenate(([False], outlier, [False])).astype(int)))
    found = tuple(
        Outlier(t_s[0] + PIECE_S * a, t_s[0] + PIECE_S * b, float(np.max(level[a:b])))
        for a, b in zip(edges[::2], edges[1::2], strict=True)
    )
    return rows & ~outlier[piece], found
