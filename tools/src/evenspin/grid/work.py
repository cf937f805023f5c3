"""The runs of a grid, side by side: the library releases the interpreter while it computes."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from evenspin.errors import EvenspinError, InputError
from evenspin.grid.axes import Axes, combinations
from evenspin.grid.result import Grid
from evenspin.model.changes import changes_of
from evenspin.model.document import Document
from evenspin.model.scenario import scenario_from
from evenspin.run.measures import POSITION_SIGNALS, SIGNALS, controls_position, position_pieces, speed_pieces
from evenspin.run.outcome import outcome_of
from evenspin.sim import simulate
from evenspin.sim.many import plain

Progress = Callable[[float], None]  # runs that are done

NEEDED = tuple(dict.fromkeys((*SIGNALS, *POSITION_SIGNALS)))
REFUSED = "refused"


def run_grid(
    document: Document,
    axes: Axes,
    fixed: Mapping[str, Any],
    *,
    numeric: str = "float",
    workers: int | None = None,
    progress: Progress | None = None,
) -> Grid:
    """Every combination. One that the drive or the files refuse is a row that says why, and does not end the others.

    Args:
        document: the scenario.
        axes: what is varied.
        fixed: other changes, the same in every run.
        workers: runs at a time; one per core when left out.
    """
    for name, values in axes.items():  # a name that is none ends it at once, and so does a value of the wrong kind
        if name in fixed:
            raise InputError("sweep", name, fixed[name], "either varied or set", "keep one of the two")
        for value in values:
            changes_of({name: value}, document)
    scenario = scenario_from(document, changes_of(fixed, document))
    cases = list(combinations(axes))

    def work(case: Mapping[str, Any]) -> dict[str, Any]:
        return _run(document, {**fixed, **case}, numeric)

    rows: list[dict[str, Any]] = []
    with ThreadPoolExecutor(max_workers=workers or os.cpu_count()) as pool:
        for number, (case, found) in enumerate(zip(cases, pool.map(work, cases), strict=True), start=1):
            rows += [{**case, **piece} for piece in found.pop("pieces") or [{}] for piece in [{**found, **piece}]]
            if progress is not None:
                progress(number)
    return Grid(scenario.setup.name, dict(axes), dict(fixed), rows)


def _run(document: Document, changes: Mapping[str, Any], numeric: str) -> dict[str, Any]:
    """Outcome, and the numbers of each steady state or motion."""
    try:
        setup = scenario_from(document, changes_of(changes, document)).setup
        record = simulate(setup, NEEDED, numeric)
    except EvenspinError as error:
        return {"outcome": REFUSED, "why": str(error), "pieces": []}
    outcome = outcome_of(setup, record)
    pieces = position_pieces(setup, record) if controls_position(setup) else speed_pieces(setup, record)
    numbers = [_numbers(piece) for piece in pieces if piece]
    return {"outcome": outcome.word, "why": outcome.text, "pieces": numbers}


def _numbers(piece: Mapping[str, Any]) -> dict[str, Any]:
    """A piece without its lists; of the orders the largest."""
    found = {name: value for name, value in piece.items() if not isinstance(value, list)}
    if piece.get("orders"):
        found["order_per_turn"], found["order_rpm"] = piece["orders"][0]["per_turn"], piece["orders"][0]["rpm"]
    return plain(found)
