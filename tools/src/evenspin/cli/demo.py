"""`evenspin demo`."""

from __future__ import annotations

from pathlib import Path

import typer

from evenspin.cli.options import Force, OutFolder
from evenspin.cli.origin import origin
from evenspin.cli.output import console


def register(app: typer.Typer) -> None:
    app.command("demo")(demo)


def demo(out: OutFolder = Path("out/demo"), force: Force = False) -> None:
    """Every method on a published scenario: repetitive control, torque observers, position control. One report.

    Example: `evenspin demo --out out/demo`
    """
    from evenspin.errors import CheckFailedError
    from evenspin.log.case import write_json
    from evenspin.output import OutputFolder
    from evenspin.report.page import write_page
    from evenspin.reproduce.tour import PARTS, page_of, run
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    screen = console()
    made = origin()
    output = OutputFolder(out, made, force=force)
    results = {}
    for part in PARTS:
        screen.print(f"Simulating {part.what}, the firmware in the loop ...")
        with progress_bar("simulating", 1.0, patience_s=0.2) as bar:
            results[part.name] = run(part, bar.update)
    screen.print("Drawing ...")
    with output as folder:
        write_json(folder / "results.json", {name: result.as_json() for name, result in results.items()})
        write_page(folder, page_of(results, made.command))
    for part in PARTS:
        for view in part.tables(results[part.name]):
            print_table(view, screen)
    screen.print(f"{out}/report.html", style="bold")
    if not all(result.passed for result in results.values()):
        raise CheckFailedError("a required check failed: see the table")
