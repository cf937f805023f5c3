"""`evenspin demo`."""

from __future__ import annotations

from pathlib import Path

import typer

from evenspin.cli.options import OutFolder
from evenspin.cli.output import command_line, console


def register(app: typer.Typer) -> None:
    app.command("demo")(demo)


def demo(out: OutFolder = Path("out/demo")) -> None:
    """Every method on a published scenario: repetitive control, torque observers, position control. One report.

    Example: `evenspin demo --out out/demo`
    """
    from evenspin.errors import CheckFailedError
    from evenspin.log import OutputFolder
    from evenspin.log.case import write_json
    from evenspin.report.page import write_page
    from evenspin.reproduce.tour import PARTS, page_of, run
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    screen = console()
    command = command_line("demo", "--out", "DIR")
    output = OutputFolder(out, command)
    results = {}
    for part in PARTS:
        screen.print(f"Simulating {part.what}, the firmware in the loop ...")
        with progress_bar("simulating", 1.0, patience_s=0.2) as bar:
            results[part.name] = run(part, bar.update)
    screen.print("Drawing ...")
    with output as folder:
        write_json(folder / "results.json", {name: result.as_json() for name, result in results.items()})
        write_page(folder, page_of(results, " ".join(command)))
    for part in PARTS:
        for view in part.tables(results[part.name]):
            print_table(view, screen)
    screen.print(f"{out}/report.html", style="bold")
    if not all(result.passed for result in results.values()):
        raise CheckFailedError("a required check failed: see the table")
