"""The form of a threshold: a number by which something is decided, with its evidence.

`set_on` says which data a value was set on. Those sets are blind no longer; `make blind` with another seed checks a
change. Numbers that only steer how fast a method converges, or how many simulations an estimate is made of, stand with
the method.
"""

from __future__ import annotations

from dataclasses import dataclass, field

EXAMPLES = "the four example cases of tests/data/foreign_drive and simulated healthy units"
FIRST_SET = "development cases, and the misses of the blind set of 50 cases with seed 7"
SECOND_SET = "the misses of the blind set of 80 cases with seed 11 and the development cases before it"
NOT_SET = "an estimate that no case has contradicted yet"
SIMULATORS = "the differences of two simulators of the same machine"
ARITHMETIC = "arithmetic: no data"


@dataclass(frozen=True, slots=True)
class Threshold:
    """One number of the table."""

    name: str
    value: float
    unit: str
    separates: str
    set_on: str
    too_low: str  # what breaks with a smaller value
    too_high: str


@dataclass(slots=True)
class Section:
    """Thresholds that belong together."""

    title: str
    rows: list[Threshold] = field(default_factory=list)

    def add(
        self, name: str, value: float, unit: str, separates: str, *, set_on: str, too_low: str, too_high: str
    ) -> float:
        """The value, once it stands in the table."""
        self.rows.append(Threshold(name, value, unit, separates, set_on, too_low, too_high))
        return value
