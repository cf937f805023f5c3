"""Which column is which quantity: by its name, and where a name says nothing by what the numbers do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from evenspin.importer.motion import CLEAR, is_whole, ratio_of, turn_of, unwrapped, wrap_span
from evenspin.importer.names import QUANTITIES, quantities_of
from evenspin.importer.programs import unit_by_program
from evenspin.importer.table import Array, RawColumn, RawTable
from evenspin.importer.units import unit_of

ALIKE = 0.999  # correlation from which two columns are one signal
ROWS = 20_000  # that are enough to tell what a column is


@dataclass(frozen=True, slots=True)
class Choice:
    """A column for a quantity, and why."""

    column: RawColumn
    reason: str


def by_name(table: RawTable) -> tuple[dict[str, Choice], list[str]]:
    """A column for every quantity that a name stands for, and questions where several may."""
    candidates: dict[str, list[tuple[int, RawColumn]]] = {}
    for column in table.columns:
        for quantity, score in quantities_of(column.name):
            if quantity == "id_a" and _is_a_number_plate(column.values):
                continue
            column = _with_unit(column, table.names)
            unit = unit_of(column.unit)
            if unit is None or unit.dimension in (QUANTITIES[quantity], "share"):
                candidates.setdefault(quantity, []).append((score, column))
    chosen: dict[str, Choice] = {}
    questions: list[str] = []
    for quantity, found in candidates.items():
        best = max(score for score, _ in found)
        columns = [column for score, column in found if score == best]
        moving = [column for column in columns if not _is_constant(column.values)] or columns
        first, others = moving[0], moving[1:]
        if any(not _alike(first, other) for other in others):
            names = ", ".join(repr(column.name) for column in moving)
            questions.append(f"{quantity}: several columns may be it ({names}): keep one")
        reason = "its name" + (f" and unit {first.unit}" if first.unit else "")
        chosen[quantity] = Choice(first, reason)
    return chosen, questions


def _with_unit(column: RawColumn, names: Sequence[str]) -> RawColumn:
    unit = "" if column.unit else unit_by_program(column.name, names)
    return replace(column, unit=unit) if unit else column


def _is_constant(values: Array) -> bool:
    good = values[np.isfinite(values)]
    return len(good) == 0 or float(np.ptp(good)) == 0.0


def _is_a_number_plate(values: Array) -> bool:
    """`motor_id` is the number of a device, and no current along the d axis."""
    good = values[np.isfinite(values)]
    return len(good) > 0 and _is_constant(good) and good[0] != 0.0 and is_whole(good)


def _alike(one: RawColumn, other: RawColumn) -> bool:
    """Whether two columns are the same signal, as a filtered and an unfiltered one are."""
    stride = max(1, len(one.values) // ROWS)
    a, b = one.values[::stride], other.values[::stride]
    good = np.isfinite(a) & np.isfinite(b)
    if np.count_nonzero(good) < 3 or _is_constant(a[good]) or _is_constant(b[good]):
        return True
    return abs(float(np.corrcoef(a[good], b[good])[0, 1])) > ALIKE


def time_by_data(columns: Sequence[RawColumn]) -> Choice | None:
    """The one column that only grows, in even steps."""
    found = []
    for column in columns:
        step = np.diff(column.values)
        if len(step) >= 10 and np.isfinite(step).all() and np.all(step > 0.0):
            middle = float(np.median(step))
            if np.percentile(step, 95) < 1.5 * middle and np.percentile(step, 5) > 0.5 * middle:
                found.append(column)
    return Choice(found[0], "it grows in even steps") if len(found) == 1 else None


def motion_by_data(t: Array, columns: Sequence[RawColumn]) -> tuple[Choice, Choice] | None:
    """Angle and speed: the one pair of columns of which the second is the rate of the first."""
    stride = max(1, len(t) // ROWS)
    found = []
    for angle in columns:
        if not np.isfinite(angle.values).all() or _is_constant(angle.values):
            continue
        span = wrap_span(angle.values)
        turn = turn_of(span, is_whole(angle.values)) if span is not None else None
        if span is not None and turn is None:
            continue
        continuous = unwrapped(angle.values, turn[1] if turn else None)
        for speed in columns:
            if speed is angle or not np.isfinite(speed.values).all() or _is_constant(speed.values):
                continue
            _, like = ratio_of(t[::stride], continuous[::stride], _mean_of(speed.values, stride))
            if abs(like) > CLEAR:
                found.append((abs(like), angle, speed))
    if not found:
        return None
    best = max(found, key=lambda item: item[0])
    others = {speed.name for like, angle, speed in found if angle is best[1] and speed is not best[2]}
    if others or any(angle is not best[1] for _, angle, _ in found):
        return None
    return (
        Choice(best[1], f"{best[2].name!r} is its rate of change"),
        Choice(best[2], f"it is the rate of change of {best[1].name!r}"),
    )


def _mean_of(values: Array, stride: int) -> Array:
    return values[::stride]
