"""Tables on terminals of any width: nothing is cut, nothing is lost, nothing is wider than the window."""

from __future__ import annotations

import io
import re

import pytest
from evenspin.native import tables
from evenspin.tableview import TableView, number, print_table
from rich.console import Console

WIDTHS = (150, 100, 80, 60, 40)

FIGURES = TableView(
    "Measured",
    "",
    ("rpm", "method", "mean rpm", "1st order", "2nd order", "thd %", "rise s", "overshoot %", "dip rpm", "settled s"),
    [(f"{150 * k}", name, f"{15.7079 * k:.4f}", f"{k / 7:.6f}", f"{k / 11:.6f}", f"{8.5 * k:.2f}", f"{k / 3:.4f}",
      f"{k * 1234.5678:.4f}", f"-{k}.5", "-") for k in range(1, 6) for name in ("pi", "fal-forc")],
)  # fmt: skip
WORDS = TableView(
    "Faults",
    "",
    ("no.", "name", "cause", "check first"),
    [(str(n), f.name, f.cause, f.check) for n, f in enumerate(tables().faults) if n],
    left=4,
)
PARAMETERS = TableView(
    "Drive parameters",
    "A note below the table, longer than a narrow terminal is wide, so that it has to be wrapped as well.",
    ("name", "unit", "default", "range", "what it is"),
    [
        (f.name, f.unit, f.to_text(f.default), f"{f.minimum:g} .. {f.maximum:g}", f.doc)
        for f in tables().params.values()
    ],
    left=5,
)
MARKED = TableView(
    "Checks", "", ("check", "value", "verdict"), [("a", "1", "ok"), ("b", "2", "not ok")], ("good", "bad")
)
LAST = "a remark of some length, so that the table is wider than most terminals are"
HOLES = TableView("Holes", "", ("check", "", "verdict", "remark"), [("a", "", "ok", ""), ("b", "", "not ok", LAST)])
EMPTY = TableView("Nothing", "", ("name", "value"), [])


def printed(view: TableView, width: int, *, terminal: bool = True) -> str:
    console = Console(file=io.StringIO(), force_terminal=terminal, width=width, color_system=None, markup=False)
    print_table(view, console)
    return console.file.getvalue()


def squeezed(text: str) -> str:
    return re.sub(r"\s+", "", text)


@pytest.mark.parametrize("digits", [2, 3, 4, 5])
@pytest.mark.parametrize("value", [3.62e-5, -6.012e-9, 1e-12, 9.9996e-5, 2.5e-4, 0.0141, 0.5])
def test_a_small_number_keeps_its_digits_and_the_width_of_its_column(value: float, digits: int) -> None:
    text = number(value, digits)

    assert float(text) == pytest.approx(value, rel=0.5000001 * 10.0 ** (1 - digits))  # half of the last digit
    assert len(text.lstrip("-")) <= digits + 5  # 0. and five or more decimals, or digits, point and e-05


@pytest.mark.parametrize(
    ("value", "text"), [(3.62e-5, "3.62e-05"), (0.000362, "0.000362"), (0.0, "0"), (None, "-"), (1234.5, "1234")]
)
def test_powers_of_ten_only_where_decimals_are_no_shorter(value: float | None, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("view", [FIGURES, WORDS, PARAMETERS, MARKED, HOLES, EMPTY], ids=lambda view: view.title)
def test_no_line_is_wider_than_the_terminal_and_no_heading_or_number_is_cut(view: TableView, width: int) -> None:
    text = printed(view, width)
    assert max(len(line.rstrip()) for line in text.splitlines()) <= width
    assert "…" not in text
    words = text.split()
    for row in view.rows:
        for cell in row:
            for word in cell.split():
                if len(word) <= width // 2 and "-" not in word:
                    assert word in words, word
    if view.rows and view is FIGURES:
        for name in view.header:
            assert name in text, name


@pytest.mark.parametrize("width", WIDTHS)
def test_a_continued_table_says_again_which_row_it_is(width: int) -> None:
    lines = printed(FIGURES, width).splitlines()
    rows = [line.split() for line in lines if re.match(r"\s*\d", line)]
    assert all(row[1] in ("pi", "fal-forc") for row in rows)
    assert len(rows) % len(FIGURES.rows) == 0
    parts = len(rows) // len(FIGURES.rows)
    assert sum("(continued)" in line for line in lines) == parts - 1
    cells = [[cell for part in range(parts) for cell in rows[part * len(FIGURES.rows) + k][2:]] for k in range(10)]
    assert cells == [list(row[2:]) for row in FIGURES.rows]


def test_what_fits_stays_one_table() -> None:
    assert "(continued)" not in printed(FIGURES, 150)
    assert printed(MARKED, 40).count("check") == 1


def test_output_into_a_file_or_a_pipe_does_not_depend_on_the_terminal() -> None:
    """As wide as `cli.output.console` makes it when nobody can tell: headings stand in one line, once."""
    text = printed(FIGURES, 150, terminal=False)
    assert text.count("method") == 1
    assert squeezed("".join(FIGURES.rows[0])) in squeezed(text)


@pytest.mark.parametrize("width", [150, 60])
def test_a_wide_table_in_a_pipe_is_not_cut_to_the_width_of_a_console(width: int) -> None:
    columns = tuple(f"quantity {k}" for k in range(20))
    cells = [(f"{k}.0000362", *(["7"] * 19)) for k in range(3)]
    text = printed(TableView("T", "", columns, cells), width, terminal=False)
    assert "…" not in text
    assert all(row[0] in text for row in cells)


def test_a_text_of_one_long_word_is_folded_not_cut() -> None:
    word = "0123456789" * 12
    text = printed(TableView("T", "", ("name", "what it is"), [("a", word)]), 40)
    assert word in squeezed(text)
    assert max(len(line) for line in text.splitlines()) <= 40
