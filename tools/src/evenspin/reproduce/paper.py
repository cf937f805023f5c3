"""Figures of a paper: what it shows or prints in each, what is found here, and the picture of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from evenspin.errors import InputError
from evenspin.report.figures import Picture
from evenspin.tableview import number

R = TypeVar("R")  # the result that the figures of a paper are drawn from

WITHIN = 0.2  # a number holds when it is no farther from the printed one
POINTS = 5.0  # a reduction in %, when it is no farther


@dataclass(frozen=True, slots=True)
class Statement:
    """One thing that the paper shows: `theirs` as printed or said. `holds`: it is found here, too; else `reason`
    says why not."""

    what: str
    ours: str
    theirs: str
    holds: bool
    reason: str = ""

    @property
    def verdict(self) -> str:
        return "holds" if self.holds else f"differs: {self.reason}"


@dataclass(frozen=True, slots=True)
class Figure(Generic[R]):
    """`draw` gives None, and `says` nothing, where the result has no run for it. `needs`: what has to be run for it, in
    the words of its paper; nothing where it is calculated."""

    numbers: tuple[str, ...]
    title: str
    draw: Callable[[R], Picture | None]
    says: Callable[[R], Sequence[Statement]]
    needs: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """figure_17_18_23"""
        return "figure_" + "_".join(self.numbers)

    @property
    def label(self) -> str:
        """Figures 3, 4, 10"""
        return f"Figure{'s' if len(self.numbers) > 1 else ''} {', '.join(self.numbers)}"


@dataclass(frozen=True, slots=True)
class Gallery(Generic[R]):
    """All figures of one paper. `no_data`: its figures that show none, and what they show instead."""

    paper: str
    figures: Sequence[Figure[R]]
    no_data: Mapping[str, str]

    def find(self, number: str) -> list[Figure[R]]:
        """By a number of the paper, with or without the letter of a part; InputError when it has no such figure, or one
        without data."""
        found = [
            f for f in self.figures if any(n == number or (n[-1].isalpha() and n[:-1] == number) for n in f.numbers)
        ]
        if found:
            return found
        shown = ", ".join(sorted((n for f in self.figures for n in f.numbers), key=_in_order))
        without = "; ".join(f"{text}: {', '.join(numbers)}" for text, numbers in self._without().items())
        raise InputError("reproduce", "--figure", number, f"one of {shown}", f"without data are: {without}")

    def _without(self) -> dict[str, list[str]]:
        kinds: dict[str, list[str]] = {}
        for each, text in self.no_data.items():
            kinds.setdefault(text, []).append(each)
        return kinds


def _in_order(number: str) -> tuple[int, str]:
    """9a before 9b before 10."""
    digits = number.rstrip("abcdefghijklmnopqrstuvwxyz")
    return int(digits), number


def printed_number(
    what: str, ours: float, theirs: float | None, other: float | None = None, *, digits: int = 3, reason: str = ""
) -> Statement:
    """Ours against one printed number, or two (simulation, experiment): within a fifth of either, or between them."""
    known = [value for value in (theirs, other) if value is not None]
    low, high = min(x - WITHIN * abs(x) for x in known), max(x + WITHIN * abs(x) for x in known)
    text = " / ".join("-" if value is None else number(value, digits) for value in (theirs, other))
    return Statement(
        what,
        number(ours, digits),
        text if other is not None else number(known[0], digits),
        low <= ours <= high,
        reason,
    )


def printed_reduction(what: str, ours: float, theirs: float, *, reason: str = "") -> Statement:
    """Ours against a printed reduction in %: within 5 points, since what is left is what counts."""
    return Statement(what, number(ours), number(theirs), abs(ours - theirs) <= POINTS, reason)


def at_most(what: str, ours: float, limit: float, *, digits: int = 3, reason: str = "") -> Statement:
    """Ours against a printed limit."""
    return Statement(what, number(ours, digits), f"at most {number(limit, digits)}", ours <= limit, reason)
