"""`evenspin combinations`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.output import console


def register(app: typer.Typer) -> None:
    app.command("combinations")(combinations)


def combinations(
    page: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the tables as a page, docs/combinations.md.")
    ] = None,
) -> None:
    """What goes with what: run every pair of methods in the simulator, or show why it is refused.

    About a minute. Exit status 1 when an accepted pair does nothing, or more harm than either of its parts.

    Example: `evenspin combinations --page docs/combinations.md`
    """
    from evenspin.errors import CheckFailedError
    from evenspin.reproduce.combinations import page as page_of
    from evenspin.reproduce.combinations import pairs, run, table, verdicts
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    with progress_bar("combinations", 1.0) as bar:
        answers = run(pairs(), bar.update)
    screen = console()
    for mode in ("speed", "position"):
        print_table(table(answers, mode), screen)
    if page is not None:
        page.write_text(page_of(answers), encoding="utf-8")
        screen.print(str(page), style="bold")
    failed = [answer for answer, _, good in verdicts(answers) if not good]
    if failed:
        raise CheckFailedError(f"{len(failed)} pairs are accepted and should not be, first: {failed[0].pair}")
