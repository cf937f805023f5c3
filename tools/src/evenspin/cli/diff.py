"""`evenspin diff`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.options import Force, JsonFlag
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, write_json


def register(app: typer.Typer) -> None:
    app.command("diff")(diff)


def diff(
    one: Annotated[Path, typer.Argument(metavar="RUN_A", help="A folder that `evenspin run` wrote.")],
    other: Annotated[Path, typer.Argument(metavar="RUN_B", help="Another one.")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Folder for a report with the curves over each other.")
    ] = None,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Compare two runs: what was set differently, and every ripple, overshoot, settling and error side by side.

    Example: `evenspin diff out/pi out/forc --out out/diff`
    """
    from evenspin.output import OutputFolder
    from evenspin.report.page import write_page
    from evenspin.run.difference import as_json as difference_json
    from evenspin.run.difference import page_of, read_run, tables_of
    from evenspin.tableview import print_table

    made = origin(one, other)
    output = OutputFolder(out, made, force=force) if out is not None else None
    runs = read_run(one), read_run(other)
    screen = console(STDOUT if as_json else None)
    for view in tables_of(*runs):
        print_table(view, screen)
    if output is not None:
        page = page_of(*runs, made.command)
        with output as folder:
            write_page(folder, page)
        screen.print(f"{out}/report.html", style="bold")
    if as_json:
        write_json(difference_json(*runs), STDOUT)
