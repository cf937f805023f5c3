"""What is varied: names of evenspin.model.changes, each with its values."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from evenspin.errors import InputError
from evenspin.model.changes import parsed_value

Axes = Mapping[str, tuple[Any, ...]]

WHERE = "sweep"
MOST_RUNS = 100_000
FORMS = "NAME=A,B,C or NAME=FIRST:LAST:COUNT or NAME=FIRST:LAST:COUNT:log"


def axes_of(given: Mapping[str, Iterable[Any]]) -> Axes:
    """Each name with at least one value, none of them twice."""
    found: dict[str, tuple[Any, ...]] = {}
    for name, values in given.items():
        if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
            raise InputError(WHERE, str(name), values, "a list of values", f"write [{values!r}]")
        found[str(name)] = tuple(each.item() if hasattr(each, "item") else each for each in values)
        if not found[str(name)]:
            raise InputError(WHERE, str(name), "[]", "at least one value", "give one, or leave the name out")
        if len(set(map(repr, found[str(name)]))) < len(found[str(name)]):
            raise InputError(WHERE, str(name), found[str(name)], "each value once", "remove the others")
    if not found:
        raise InputError(WHERE, "axes", "{}", "at least one name with its values", FORMS)
    count = math.prod(len(values) for values in found.values())
    if count > MOST_RUNS:
        raise InputError(WHERE, "runs", count, f"at most {MOST_RUNS}", "take fewer values")
    return found


def parsed_axes(words: Sequence[str]) -> Axes:
    """From the command line: `rc_gain=0.1:0.5:5`, `method=pi,forc`, `cogging.amplitude_nm=1e-4:1e-1:4:log`."""
    found: dict[str, list[Any]] = {}
    for word in words:
        name, equals, text = word.partition("=")
        if not equals or not name or not text:
            raise InputError(WHERE, "--vary", word, FORMS, "give a name and its values")
        if name in found:
            raise InputError(WHERE, "--vary", name, "given once", "put its values into one list")
        found[name] = _span(name, text) if ":" in text else [parsed_value(each) for each in text.split(",")]
    return axes_of(found)


def combinations(axes: Axes) -> Iterator[dict[str, Any]]:
    """Every combination; the last axis varies fastest."""
    for values in itertools.product(*axes.values()):
        yield dict(zip(axes, values, strict=True))


def _span(name: str, text: str) -> list[float]:
    parts = text.split(":")
    try:
        first, last, count = float(parts[0]), float(parts[1]), int(parts[2])
        logarithmic = len(parts) == 4 and parts[3] == "log"
        good = count >= 2 and len(parts) == 3 + logarithmic and math.isfinite(first) and math.isfinite(last)
        good = good and (not logarithmic or first * last > 0.0) and count <= MOST_RUNS
    except (ValueError, IndexError):
        good = False
    if not good:
        must = f"FIRST:LAST:COUNT with COUNT in 2 .. {MOST_RUNS}, and both of one sign where :log follows"
        raise InputError(WHERE, name, text, must, FORMS)
    share = [index / (count - 1) for index in range(count)]
    if logarithmic:
        values = [first * (last / first) ** each for each in share]
    else:
        values = [first + (last - first) * each for each in share]
    return [float(f"{value:.12g}") for value in values]
