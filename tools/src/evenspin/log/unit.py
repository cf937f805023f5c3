"""One machine of a type, as a log of it shows it: its effects, what it is off its data sheet, its noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Effects = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True, slots=True)
class Unit:
    """What it adds to the nominal machine, and the chances of one recording."""

    effects: Effects = field(default_factory=dict)
    factors: Mapping[str, float] = field(default_factory=dict)  # of the numbers of the machine model
    noise_seed: int | None = None  # None: no noise
    count_part: float = 0.5  # true start angle over the encoder's reading, in counts, 0..1
