"""Thin out curves for a picture without losing their peaks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

POINTS = 1600


def envelope(t_s: Array, value: Array, points: int = POINTS) -> tuple[Array, Array]:
    """At most `points` samples: the smallest and the largest of each stretch, in their order."""
    if len(t_s) <= points:
        return t_s, value
    stretches = np.array_split(np.arange(len(t_s)), points // 2)
    kept = sorted({int(s[k]) for s in stretches for k in (np.argmin(value[s]), np.argmax(value[s]))})
    return t_s[kept], value[kept]
