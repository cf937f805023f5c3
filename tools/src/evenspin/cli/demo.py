"""`evenspin demo`."""

from __future__ import annotations

from pathlib import Path

import typer

from evenspin.cli.options import OutFolder
from evenspin.cli.output import command_line, console

SET = "first"


def register(app: typer.Typer) -> None:
    app.command("demo")(demo)


def demo(out: OutFolder = Path("out/demo")) -> None:
    """PI, CRC, FORC and fal-FORC on a published scenario: table, pictures, report.html.

    Example: `evenspin demo --out out/demo`
    """
    from evenspin.errors import CheckFailedError
    from evenspin.log import OutputFolder
    from evenspin.log.case import write_json
    from evenspin.report.page import write_page
    from evenspin.reproduce.guo2024 import reproduce
    from evenspin.reproduce.guo2024.page import page_of
    from evenspin.reproduce.guo2024.tables import tables_of
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    screen = console()
    command = command_line("demo", "--out", "DIR")
    output = OutputFolder(out, command)
    screen.print("Simulating 32 s with four methods, the firmware in the loop ...")
    with progress_bar("simulating", 1.0, patience_s=0.2) as bar:
        result = reproduce(sets=(SET,), progress=bar.update)
    screen.print("Drawing ...")
    with output as folder:
        write_json(folder / "results.json", result.as_json())
        write_page(folder, page_of(result, SET, " ".join(command)))
    for view in tables_of(result):
        print_table(view, screen)
    screen.print(f"{out}/report.html", style="bold")
    if not result.passed:
        raise CheckFailedError("a required check failed: see the table")
