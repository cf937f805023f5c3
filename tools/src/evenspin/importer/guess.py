"""From a table to a map: names first, then what the data decide, and one list of what a person has to decide."""

from __future__ import annotations

from evenspin.importer.choose import by_name
from evenspin.importer.guess_current import guess_current, guess_others
from evenspin.importer.guess_motion import guess_motion
from evenspin.importer.guess_time import ask_time, guess_time
from evenspin.importer.mapping import ColumnMap, Mapping
from evenspin.importer.names import QUANTITIES
from evenspin.importer.state import Known, State
from evenspin.importer.table import RawTable

__all__ = ["Known", "guess_map"]


def guess_map(table: RawTable, known: Known | None = None) -> Mapping:
    """How the table is to be read. What the data cannot decide is in `questions` of the result."""
    known = known or Known()
    chosen, questions = by_name(table)
    state = State(table, known, chosen, questions, pole_pairs=known.pole_pairs, counts=known.counts_per_turn)
    guess_time(state)
    guess_motion(state)
    ask_time(state)
    guess_others(state)
    guess_current(state)
    order = list(QUANTITIES)
    columns = {
        quantity: ColumnMap(
            choice.column.name, state.units.get(quantity, ""), state.scale.get(quantity, 1.0), 0.0, choice.reason
        )
        for quantity, choice in sorted(state.chosen.items(), key=lambda item: order.index(item[0]))
    }
    used = {column.source for column in columns.values()}
    ignored = tuple(name for name in table.names if name not in used)
    return Mapping(
        columns,
        state.rate_hz,
        state.pole_pairs,
        state.counts,
        None,
        False,
        ignored,
        tuple(state.notes),
        tuple(state.questions),
    )
