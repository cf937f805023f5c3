"""The column of time and its unit."""

from __future__ import annotations

import numpy as np

from evenspin.importer import motion
from evenspin.importer.choose import time_by_data
from evenspin.importer.names import words_of
from evenspin.importer.state import State
from evenspin.importer.units import unit_of


def guess_time(state: State) -> None:
    """Choose the column; its unit when it is printed or only one fits. Else angle and speed may decide it later."""
    if "t_s" not in state.chosen:
        found = time_by_data([state.table.columns[i] for i in state.free()])
        if found is not None:
            state.chosen["t_s"] = found
    rate = state.known.rate_hz or state.table.rate_hz
    if "t_s" not in state.chosen:
        state.rate_hz = rate
        if rate is None:
            state.questions.append("t_s: no column is the time: name it, or give rate_hz (rows per second)")
        return
    column = state.chosen["t_s"].column
    printed = column.unit or _unit_in_name(column.name)
    if printed and unit_of(printed) is not None:
        state.units["t_s"] = printed
        return
    step = step_of(state)
    fitting = motion.time_units(step)
    if rate is not None:
        fitting = [(name, si) for name, si in fitting if abs(step * si * rate - 1.0) < 0.05] or fitting
    if len(fitting) == 1:
        state.units["t_s"] = fitting[0][0]
        state.because("t_s", f"{step:.4g} from row to row")


def times(state: State) -> list[tuple[str, float]]:
    """Units in which the time may be."""
    if "t_s" not in state.chosen:
        return [("s", 1.0)]
    if "t_s" in state.units:
        return [(state.units["t_s"], state.unit("t_s").si)]
    return motion.time_units(step_of(state))


def ask_time(state: State) -> None:
    """When angle and speed have not decided it either."""
    if "t_s" in state.chosen and "t_s" not in state.units:
        names = ", ".join(name for name, _ in times(state)) or "none at which a log has 20 to 200000 rows a second"
        state.questions.append(f"t_s: the unit of {state.name('t_s')!r} is not printed ({names}?)")


def step_of(state: State) -> float:
    values = state.values("t_s")
    return float(np.nanmedian(np.diff(values))) if len(values) > 1 else 0.0


def _unit_in_name(name: str) -> str:
    """`ms_today` or `us` as the name of a column of time."""
    first = words_of(name).split()[:1]
    unit = unit_of(first[0]) if first else None
    return first[0] if unit is not None and unit.dimension == "time" and first[0] not in ("t", "min") else ""
