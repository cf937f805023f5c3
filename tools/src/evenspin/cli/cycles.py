"""`evenspin cycles`."""

from __future__ import annotations

from typing import Annotated

import typer

from evenspin.cli.options import JsonFile
from evenspin.cli.output import check_json_file, console, write_json


def register(app: typer.Typer) -> None:
    app.command("cycles")(cycles)


def cycles(
    check: Annotated[bool, typer.Option("--check", help="Exit status 1 when a budget is exceeded or missed.")] = False,
    record: Annotated[bool, typer.Option("--record", help="Write the figures down as those to compare with.")] = False,
    json_file: JsonFile = None,
) -> None:
    """Estimated C28x cycles of every block and both interrupts, worst call of the driving inputs; needs the checkout.

    Example: `evenspin cycles --check`
    """
    from rich.table import Table

    from evenspin.cycles.measure import BUDGETS, measure, read_budgets, source_root, violations, write_recorded

    check_json_file(json_file)
    root = source_root()
    result = measure(root)
    budgets, recorded, known = read_budgets(root / BUDGETS)
    screen = console(json_file)
    table = Table("kind", "name", box=None)
    for title in ("mean", "worst", "budget", ""):
        table.add_column(title, justify="right")
    for row in result.rows:
        over = row.budget is not None and row.cycles_worst > row.budget
        numbers = (str(row.cycles_est), str(row.cycles_worst), str(row.budget or ""))
        table.add_row(row.kind, row.name, *numbers, "OVER" if over else "")
    screen.print(table)
    low, high = result.band
    screen.print(
        f"An estimate: against {len(result.checks)} figures published by TI the model is {100 * low:+.0f} % .. "
        f"{100 * high:+.0f} % off. HAL functions are guesses."
    )
    if json_file is not None:
        write_json(result.document(), json_file)
    if record:
        write_recorded(root / BUDGETS, result.rows)
        return
    found = violations(result.rows, budgets, recorded, known)
    for line in found:
        screen.print(line)
    if check and found:
        raise typer.Exit(1)
