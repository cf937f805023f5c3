"""The result as tables: what was measured, how it compares with the paper, and what passed."""

from __future__ import annotations

from collections.abc import Iterator

from evenspin.reproduce.guo2024.checks import Check
from evenspin.reproduce.guo2024.measure import Row
from evenspin.reproduce.guo2024.printed import printed
from evenspin.reproduce.guo2024.result import Result
from evenspin.tableview import TableView, number

QUANTITIES = {
    "n1_pct": "speed, 1st order [%]",
    "n2_pct": "speed, 2nd order [%]",
    "q1_pct": "q current, 1st order [%]",
    "q2_pct": "q current, 2nd order [%]",
    "distortion_pct": "current distortion [%]",
    "overshoot_start_rpm": "overshoot at the start [rpm]",
    "overshoot_load_rpm": "overshoot at the load step [rpm]",
    "overshoot_step_rpm": "overshoot at the speed step [rpm]",
    "load_dip_rpm": "dip at the load step [rpm]",
    "n1_after_load_pct": "speed, 1st order, after the load step [%]",
    "n2_after_load_pct": "speed, 2nd order, after the load step [%]",
    "q1_after_load_pct": "q current, 1st order, after the load step [%]",
    "q2_after_load_pct": "q current, 2nd order, after the load step [%]",
}
SHORT = (
    "n1 %",
    "n2 %",
    "q1 %",
    "q2 %",
    "D %",
    "start rpm",
    "load rpm",
    "step rpm",
    "dip rpm",
    "n1 load",
    "n2 load",
    "q1 load",
    "q2 load",
)


def tables_of(result: Result) -> list[TableView]:
    """In the order of reading."""
    return [measured(result), compared(result), checked(result)]


def measured(result: Result) -> TableView:
    rows = [
        (f"{row['speed_rpm']:g}", row["method"], *(number(row[key]) for key in QUANTITIES))
        for row in sorted(result.rows, key=lambda row: row["speed_rpm"])
    ]
    text = (
        "n, q: 1st and 2nd order of true speed and q-axis current, % of their mean, before the load step. "
        "D: distortion of the stator current. Then overshoots and the dip."
    )
    return TableView(f"Measured, {result.numeric} build", text, ("rpm", "method", *SHORT), rows)


def compared(result: Result) -> TableView:
    """Everything the paper prints or acceptance bounds."""
    lines = list(_comparisons(result))
    rows = [cells for cells, _ in lines]
    header = ("rpm", "method", "quantity", "ours", "paper sim.", "paper exp.", "band", "verdict")
    text = "The bases of the paper's q-current percentages are not known (docs/reference/guo2024.md)."
    return TableView("Ours and the paper's", text, header, rows, [mark for _, mark in lines], left=3)


def checked(result: Result) -> TableView:
    """What is not a row of the table: ratios, gains, limits; and whatever failed."""
    shown = [check for check in result.checks if check.required and not check.key or not check.passed]
    rows = [
        (check.what, number(check.value, 5), _band(check, 5), _verdict(check), "" if check.required else "reference")
        for check in shown
    ]
    required = [check for check in result.checks if check.required]
    others = [check for check in result.checks if not check.required]
    text = (
        f"{sum(check.passed for check in required)} of {len(required)} required checks passed, "
        f"{sum(check.passed for check in others)} of {len(others)} comparisons with an independent simulation."
    )
    return TableView("Checks", text, ("check", "value", "band", "verdict", ""), rows, [_mark(c) for c in shown], left=1)


def _comparisons(result: Result) -> Iterator[tuple[tuple[str, ...], str]]:
    required = {(c.method, c.speed_rpm, c.key): c for c in result.checks if c.required and c.key}
    for row in sorted(result.rows, key=lambda row: row["speed_rpm"]):
        for key, name in QUANTITIES.items():
            check = required.get((row["method"], row["speed_rpm"], key))
            line = printed(row["method"], row["speed_rpm"], key)
            if _shown_once(row, key) and (check or line):
                simulation, experiment = (line.simulation, line.experiment) if line else (None, None)
                yield (
                    (
                        f"{row['speed_rpm']:g}",
                        row["method"],
                        name,
                        number(row[key]),
                        number(simulation),
                        number(experiment),
                        _band(check) if check else "-",
                        _verdict(check) if check else "",
                    ),
                    _mark(check) if check else "",
                )


def _shown_once(row: Row, key: str) -> bool:
    """The start of a set is in each of its rows; it is shown in the first."""
    return key != "overshoot_start_rpm" or row["overshoot_step_rpm"] is None


def _band(check: Check, digits: int = 3) -> str:
    return f"{number(check.low, digits)} .. {number(check.high, digits)}"


def _verdict(check: Check) -> str:
    return "ok" if check.passed else "FAILED"


def _mark(check: Check) -> str:
    return "good" if check.passed else "bad"
