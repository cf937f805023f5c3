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
    from evenspin.reproduce.combination_options import option_tables, refused_table, trials
    from evenspin.reproduce.combination_options import run as run_options
    from evenspin.reproduce.combinations import page as page_of
    from evenspin.reproduce.combinations import pairs, run, table, verdicts
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    with progress_bar("combinations", 1.0) as bar:
        answers = run(pairs(), bar.update)
    with progress_bar("options", 1.0) as bar:
        found = run_options(trials(), bar.update)
    screen = console()
    options, refused = option_tables(found), refused_table()
    for view in (table(answers, "speed"), table(answers, "position"), *options, refused):
        print_table(view, screen)
    if page is not None:
        page.write_text(page_of(answers, options, refused), encoding="utf-8")
        screen.print(str(page), style="bold")
    failed: list[object] = [answer.pair for answer, _, good in verdicts(answers) if not good]
    failed += [each.trial for each in found if not each.good]
    failed += [f"{row[0]} with {row[1]}" for row, mark in zip(refused.rows, refused.marks, strict=True) if mark]
    if failed:
        raise CheckFailedError(f"{len(failed)} pairs are accepted and should not be, first: {failed[0]}")
