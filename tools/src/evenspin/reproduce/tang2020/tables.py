"""The result as tables: ours, the independent simulation, the paper, and what passed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from evenspin.reproduce.check import Check
from evenspin.reproduce.tang2020.checks import ON, PP, RMS, TIME, TWELFTH
from evenspin.reproduce.tang2020.printed import REFERENCES, Range, Reference
from evenspin.reproduce.tang2020.result import Result
from evenspin.tableview import TableView, number

BANDS = {RMS: "rms", PP: "pp", TWELFTH: "12th", ON: "on", TIME: "90 % in"}
UNITS = {RMS: "", PP: "", TWELFTH: "", ON: " rpm", TIME: " s"}


def tables_of(result: Result) -> list[TableView]:
    """In the order of reading."""
    views = [compared(result), checked(result)]
    return views + ([swept(result)] if result.sweep else [])


def compared(result: Result) -> TableView:
    """Every condition with every method."""
    lines = [_line(row, result) for row in result.rows]
    header = (
        "condition",
        "method",
        "off",
        "on rpm",
        "rms -%",
        "pp -%",
        "12th",
        "independent",
        "paper",
        "band",
        "",
    )
    text = (
        "Speed ripple without (PI) and with observer: rms, its reduction, that of peak to peak, change of the 12th "
        "mechanical order. independent: another simulation, reduction of rms / peak to peak. band: the side that was "
        "asked for, reductions at least, the others at most. aro-k21: equations 19 and 20 with their printed labels, "
        "which must fail."
    )
    return TableView(
        f"Tang et al. 2020, {result.numeric} build", text, header, [cells for cells, _ in lines], [m for _, m in lines]
    )


def checked(result: Result) -> TableView:
    """What failed, and what is not in the table before."""
    shown = [c for c in result.checks if not c.passed or c.required and c.key in ("", ON, TIME)]
    rows = [
        (c.what, number(c.value, 4), f"{number(c.low)} .. {number(c.high)}", _verdict(c), "" if c.required else "ref.")
        for c in shown
    ]
    required = [check for check in result.checks if check.required]
    others = [check for check in result.checks if not check.required]
    text = (
        f"{sum(check.passed for check in required)} of {len(required)} required checks passed, "
        f"{sum(check.passed for check in others)} of {len(others)} comparisons with the independent simulation."
    )
    return TableView("Checks", text, ("check", "value", "band", "verdict", ""), rows, [_mark(c) for c in shown], left=1)


def swept(result: Result) -> TableView:
    rows = [
        (
            f"{point.speed_rpm:.1f}",
            number(sum(point.off_rpm) / 2.0),
            number(point.on_rpm),
            f"{point.reduction_pct:.1f}",
            "pauses" if point.rests else "",
            "ok" if point.on_rpm <= point.allowed_rpm else "FAILED",
        )
        for point in result.sweep
    ]
    marks = ["" if point.on_rpm <= point.allowed_rpm else "bad" for point in result.sweep]
    text = (
        "aro-beyond at any speed. pauses: nothing is learned, because the points cannot tell the encoder's rounding, "
        "which every turn sees alike, from the mean. ok: not more ripple than without, up to what two windows without "
        "it differ."
    )
    return TableView("Sweep", text, ("rpm", "off rpm", "on rpm", "rms -%", "learning", "verdict"), rows, marks, left=0)


def _line(row: Mapping[str, Any], result: Result) -> tuple[tuple[str, ...], str]:
    reference = REFERENCES.get((row["condition"], row["method"]), Reference())
    what = f"{row['method']}, {row['condition']}: "
    checks = [check for check in result.checks if check.required and check.what.startswith(what)]
    cells = (
        row["condition"],
        row["method"],
        number(row["rms_off_rpm"]),
        number(row["rms_on_rpm"]),
        _pct(row["reduction_pct"]),
        _pct(row["pp_reduction_pct"]),
        f"{round(row['orders']['12'])}" if "12" in row["orders"] else "-",
        " / ".join(_range(each) for each in (reference.rms_pct, reference.pp_pct) if each) or "-",
        reference.paper,
        ", ".join(_bands(checks)) or "-",
        ("ok" if all(check.passed for check in checks) else "FAILED") if checks else "",
    )
    mark = ("good" if all(check.passed for check in checks) else "bad") if checks else ""
    return cells, mark


def _bands(checks: list[Check]) -> Iterator[str]:
    """The side of each band that was asked for; the other one is in docs/reference/tang2020.md."""
    for check in checks:
        limit = check.low if check.key in (RMS, PP) and check.low > -1e3 else check.high
        yield f"{BANDS[check.key]} {limit:g}{UNITS[check.key]}"


def _pct(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"


def _range(pair: Range) -> str:
    return f"{pair[0]:g}" if pair[0] == pair[1] else f"{pair[0]:g}-{pair[1]:g}"


def _verdict(check: Check) -> str:
    return "ok" if check.passed else "FAILED"


def _mark(check: Check) -> str:
    return "good" if check.passed else "bad"
