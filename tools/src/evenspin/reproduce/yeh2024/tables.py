"""The result as tables: what was measured, how it compares with the paper, and what passed."""

from __future__ import annotations

from collections.abc import Iterator

from evenspin.reproduce.check import Check
from evenspin.reproduce.yeh2024.measure import Row
from evenspin.reproduce.yeh2024.printed import at_most, independent, paper
from evenspin.reproduce.yeh2024.result import Result
from evenspin.tableview import TableView, number

# key: name, and the factor to the unit shown
QUANTITIES = {
    "turn1_rms": ("rms of turn 1 [mrad]", 1e3),
    "max_turn1": ("MAX of turn 1 [mrad]", 1e3),
    "max_turn1_from_0": ("MAX of turn 1 from the command on [mrad]", 1e3),
    "turn2_reduction_pct": ("reduction, turn 2 [%]", 1.0),
    "turn10_reduction_pct": ("reduction, turn 10 [%]", 1.0),
    "turn10_rms": ("rms of turn 10 [mrad]", 1e3),
    "avg_turn10": ("AVG of turn 10 [mrad]", 1e3),
    "max_turn10": ("MAX of turn 10 [mrad]", 1e3),
    "max_reduction_pct": ("reduction of MAX, turn 1 from the command on to 10 [%]", 1.0),
    "raw_max_turns_1_3": ("raw MAX, turns 1-3 [mrad]", 1e3),
}
SHORT = (
    "rms 1 mrad",
    "MAX 1 mrad",
    "from 0 mrad",
    "red. 2 %",
    "red. 10 %",
    "rms 10 mrad",
    "AVG mrad",
    "MAX 10 mrad",
    "red. MAX %",
    "raw MAX mrad",
)


def tables_of(result: Result) -> list[TableView]:
    """In the order of reading."""
    return [measured(result), compared(result), checked(result)]


def measured(result: Result) -> TableView:
    rows = [
        (
            f"{row['speed_rpm']:g}",
            _name(row),
            *(number(factor * row[key], 4) for key, (_, factor) in QUANTITIES.items()),
        )
        for row in result.rows
    ]
    text = (
        "Position error, command less encoder; rms and MAX of a turn without its mean AVG. Turn 1 counts from 0.1 s; "
        "from 0: from the command on."
    )
    return TableView(f"Measured, {result.numeric} build", text, ("rpm", "method", *SHORT), rows)


def compared(result: Result) -> TableView:
    """Everything the paper or the independent simulation gives, and everything that is bounded."""
    lines = list(_comparisons(result))
    header = ("rpm", "method", "quantity", "ours", "paper", "independent", "band", "verdict")
    text = (
        "Paper: measured on its test bench. Independent: a double-precision simulation that shares no code with this."
    )
    rows, marks = [cells for cells, _ in lines], [mark for _, mark in lines]
    return TableView("Ours, the paper's and an independent simulation's", text, header, rows, marks, left=3)


def checked(result: Result) -> TableView:
    """What is not a row of the table: comparisons of methods, identification; and whatever failed."""
    shown = [check for check in result.checks if check.required and (not check.key or not check.passed)]
    rows = [
        (
            check.what,
            number(check.value, 5),
            f"{number(check.low, 5)} .. {number(check.high, 5)}",
            "ok" if check.passed else "FAILED",
        )
        for check in shown
    ]
    required = [check for check in result.checks if check.required]
    others = [check for check in result.checks if not check.required]
    text = (
        f"{sum(check.passed for check in required)} of {len(required)} required checks passed; "
        f"{sum(check.passed for check in others)} of {len(others)} are within 12 % of the independent simulation."
    )
    return TableView("Checks", text, ("check", "value", "band", "verdict"), rows, [_mark(c) for c in shown], left=1)


def _comparisons(result: Result) -> Iterator[tuple[tuple[str, ...], str]]:
    required = {(c.method, c.speed_rpm, c.key): c for c in result.checks if c.required and c.key}
    for row in result.rows:
        method, rpm, models = row["method"], row["speed_rpm"], row.get("models", "true")
        for key, (name, factor) in QUANTITIES.items():
            check = required.get((_name(row), rpm, key))
            theirs, limit = paper(method, key, rpm), at_most(method, key)
            if models != "true":
                theirs = limit = None
            reference = independent(method, key, rpm, models)
            if check is None and theirs is None and reference is None:
                continue
            shown = number(theirs * factor) if theirs is not None else f"< {number(limit * factor)}" if limit else "-"
            band = f"{number(check.low * factor)} .. {number(check.high * factor)}" if check else "-"
            verdict = ("ok" if check.passed else "FAILED") if check else ""
            other = number(reference * factor) if reference is not None else "-"
            cells = (f"{rpm:g}", _name(row), name, number(factor * row[key], 4), shown, other, band, verdict)
            yield cells, _mark(check) if check else ""


def _name(row: Row) -> str:
    return f"{row['method']}, models all wrong" if row.get("models") == "all wrong" else row["method"]


def _mark(check: Check) -> str:
    return "good" if check.passed else "bad"
