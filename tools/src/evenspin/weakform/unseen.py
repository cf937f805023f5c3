"""Whether a term lowers what the equations leave on stretches that no fit saw.

What no term describes well is lower wherever something is fitted to it, also by a term that is not there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Parts = Sequence[Sequence[Array]]  # what is left, per log and equation, of all windows in use
Unseen = Sequence[Sequence[Flags]]  # windows that no fit saw, likewise

SHAFT_SEEN = 0.9  # of the rms that a stiff shaft leaves
FOREIGN_SEEN = (
    0.95  # of the rms without it: 0.67 at most in logs with a cause of unknown kind, 0.986 at least in others
)


def shaft_is_seen(unseen: Unseen, twisting: Parts, stiff: Parts, before: Parts) -> bool:
    """Whether a shaft that twists lowers the torque that is left, below that of a stiff one and of nothing named."""
    left, rigid, nothing = (square(unseen, parts, 0) for parts in (twisting, stiff, before))
    return left < SHAFT_SEEN**2 * min(rigid, nothing)


def foreign_is_seen(unseen: Unseen, found: Parts, plain: Parts) -> bool:
    """Whether causes of unknown kind lower what is left in one of the equations. `plain`: the best without them."""
    equations = range(max(len(parts) for parts in found))
    left = [(square(unseen, found, each), square(unseen, plain, each)) for each in equations]
    return any(with_it < FOREIGN_SEEN**2 * without for with_it, without in left) or not any(b > 0.0 for _, b in left)


def square(unseen: Unseen, parts: Parts, equation: int) -> float:
    """Sum of what an equation leaves, squared, over all logs that have it."""
    return sum(
        float(np.sum(left[equation][rows[equation]] ** 2))
        for left, rows in zip(parts, unseen, strict=True)
        if equation < len(left)
    )
