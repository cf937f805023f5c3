"""What the cost table is held against: functions that TI's compiler made, counted from published listings."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from evenspin.cycles.costs import COSTS

LISTINGS = Path("tests/budget/listings.csv")
LARGE_CYC = 140  # from here on a function is long enough to speak for an interrupt
TENTH, NINTH = 0.1, 0.9


@dataclass(frozen=True, slots=True)
class Listed:
    """One function in a listing."""

    repository: str
    name: str
    core: bool  # control, state machines, buffers, links, loops; else it sets up peripherals or fills structures
    cycles: int  # along its longest path, with the waits of the pipeline
    classes: Mapping[str, int]

    @property
    def model(self) -> float:
        return sum(COSTS[name] * count for name, count in self.classes.items())

    @property
    def ratio(self) -> float:
        return self.model / self.cycles


@dataclass(frozen=True, slots=True)
class Band:
    """Model over real: 10th percentile, median, 90th percentile."""

    low: float
    middle: float
    high: float
    functions: int

    @classmethod
    def of(cls, functions: Sequence[Listed]) -> Band:
        ratios = [function.ratio for function in functions]
        low, middle, high = (float(x) for x in np.quantile(ratios, (TENTH, 0.5, NINTH)))
        return cls(low, middle, high, len(ratios))


@cache
def read_listings(root: Path) -> tuple[Listed, ...]:
    with (root / LISTINGS).open(newline="") as file:
        return tuple(
            Listed(row["repository"], row["function"], row["core"] == "1", int(row["cycles_with_waits"]),
                   {name: int(row[name]) for name in COSTS})
            for row in csv.DictReader(file)
        )  # fmt: skip


def block_band(functions: Sequence[Listed]) -> Band:
    """Of one block: the core, whatever the length."""
    return Band.of([function for function in functions if function.core])


def interrupt_band(functions: Sequence[Listed]) -> Band:
    """Of an interrupt: the long ones of the core, in which more of the single errors cancel."""
    return Band.of([function for function in functions if function.core and function.cycles >= LARGE_CYC])
