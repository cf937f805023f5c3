"""Round numbers along an axis."""

from __future__ import annotations

import math
from collections.abc import Sequence

STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)


def linear_ticks(low: float, high: float, most: int) -> list[float]:
    """At most `most` multiples of a round step within low .. high."""
    if not high > low:
        return [low]
    rough = (high - low) / max(1, most)
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(factor * power for factor in STEPS if factor * power >= rough * (1.0 - 1e-9))
    first, last = math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6)
    return [index * step for index in range(first, last + 1)]


def decade_ticks(low: float, high: float) -> list[float]:
    """The powers of ten within low .. high."""
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    return [10.0**power for power in range(first, last + 1)]


def tick_texts(ticks: Sequence[float]) -> list[str]:
    """As many digits as it takes to tell them apart."""
    steps = [abs(b - a) for a, b in zip(ticks[:-1], ticks[1:], strict=True)]
    least = 1e-6 * min(steps, default=1.0)
    return [f"{0.0 if abs(tick) < least else tick:.6g}".replace("-", "\u2212") for tick in ticks]


def padded(low: float, high: float, share: float = 0.05) -> tuple[float, float]:
    """A range with room at both ends, never empty."""
    room = share * (high - low) if high > low else 0.5 * abs(low) or 1.0
    return low - room, high + room
