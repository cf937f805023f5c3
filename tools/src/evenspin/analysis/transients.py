"""What happens after a change: overshoot, dip, settling."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def overshoot(value: Array, reference: float) -> float:
    """How far the value went beyond its reference, away from zero; at least 0."""
    return float(max((_direction(reference) * (value - reference)).max(initial=0.0), 0.0))


def dip(value: Array, reference: float) -> float:
    """How far the value fell short of its reference, towards zero; at least 0."""
    return float(max((_direction(reference) * (reference - value)).max(initial=0.0), 0.0))


def settling_time_s(t_s: Array, value: Array, reference: float, band: float) -> float:
    """Time from the first sample until the value stays within reference +- band; nan if it does not."""
    outside = np.flatnonzero(np.abs(value - reference) > band)
    if len(outside) == 0:
        return 0.0
    if outside[-1] + 1 >= len(value):
        return float("nan")
    return float(t_s[outside[-1] + 1] - t_s[0])


def _direction(reference: float) -> float:
    return 1.0 if reference >= 0.0 else -1.0
