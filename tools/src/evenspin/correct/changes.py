"""How a correction changes parameters of a drive, and how several go together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from evenspin.errors import InputError
from evenspin.native import tables

SET, ADD, TIMES = "set", "add", "times"
HOWS = (SET, ADD, TIMES)
SAME = 1e-6  # relative: two corrections that set a parameter to this are one


@dataclass(frozen=True, slots=True)
class Change:
    """Of one parameter. `low` and `high`: the 95 % interval of `value`."""

    parameter: str
    how: str
    value: float
    low: float
    high: float

    def of(self, before: float) -> float:
        """The value that it makes of `before`."""
        return {SET: self.value, ADD: before + self.value, TIMES: before * self.value}[self.how]

    @property
    def text(self) -> str:
        """As a person writes it: `= 0.05 N m`, `+ 0.1 rad`, `x 1.2`."""
        field = tables().params[self.parameter]
        sign = {SET: "=", ADD: "+", TIMES: "x"}[self.how]
        if field.kind in ("choice", "flag"):
            return f"{sign} {field.to_text(self.value)}"
        unit = f" {field.unit}" if field.unit and self.how != TIMES else ""
        half = 0.5 * (self.high - self.low)
        return f"{sign} {self.value:.4g}{f' +- {half:.2g}' if half > 0.0 else ''}{unit}"


def known(parameter: str, value: float | str, half: float = 0.0) -> Change:
    """Set to a value with half of its interval, or to a word."""
    field = tables().params[parameter]
    number = field.to_number(value)
    return Change(parameter, SET, number, max(number - half, field.minimum), min(number + half, field.maximum))


def moved(parameter: str, value: float, half: float) -> Change:
    return Change(parameter, ADD, value, value - half, value + half)


def scaled(parameter: str, factor: float, half: float) -> Change:
    return Change(parameter, TIMES, factor, factor - half, factor + half)


def composed(corrections: Mapping[str, Iterable[Change]], before: Mapping[str, float]) -> dict[str, float]:
    """Values of all changed parameters. Factors and sums go together, two values for one parameter do not.

    Args:
        corrections: changes by the name of the correction that they belong to.
        before: the parameters as they are.
    """
    values: dict[str, float] = {}
    owner: dict[str, tuple[str, Change]] = {}
    for name, changes in corrections.items():
        for change in changes:
            first = owner.setdefault(change.parameter, (name, change))
            if first[1] is not change and not _together(first[1], change):
                must = f"{first[1].text}, as the correction of {first[0]} has it"
                raise InputError(
                    f"correction of {name}", change.parameter, change.text, must,
                    f"leave out one of the two: --only {name} or --only {first[0]}",
                )  # fmt: skip
            values[change.parameter] = change.of(values.get(change.parameter, before[change.parameter]))
    return values


def _together(one: Change, other: Change) -> bool:
    if one.how != other.how:
        return False
    return one.how != SET or math.isclose(one.value, other.value, rel_tol=SAME, abs_tol=1e-12)
