"""`evenspin clean`: what killed commands left half-written."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.output import console


def register(app: typer.Typer) -> None:
    app.command("clean")(clean)


def clean(
    folders: Annotated[
        list[Path] | None, typer.Argument(metavar="[DIR]...", help="Where outputs were written; default: here.")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only show what would be removed.")] = False,
) -> None:
    """Remove what commands that were killed left half-written beside their outputs: hidden folders .NAME.evenspin-*.

    What is being written now stays, and so does every recording.

    Example: `evenspin clean out`
    """
    from evenspin.bench.kept import FOLDER, RAW, recordings_in, where_it_is
    from evenspin.errors import CheckFailedError, InputError
    from evenspin.output.staging import leftovers, remove_locks

    screen = console()
    stays = []
    count = 0
    for folder in folders or [Path()]:
        if not folder.is_dir():
            raise InputError("clean", "DIR", str(folder), "an existing folder", "check the name")
        for left in leftovers(folder):
            count += 1
            removable = not left.alive and not left.holds_the_earlier
            done = removable and not dry_run and left.remove()
            screen.print(f"{left}{': removed' if done else ': would be removed' if removable and dry_run else ''}")
            if removable and not dry_run and not done:
                stays.append(str(left.path))
        if not dry_run:
            remove_locks(folder)
        for place in sorted([*folder.glob(f"*{RAW}"), *folder.glob(f"*{FOLDER}/")]):
            if where := where_it_is(recordings_in(place)):
                screen.print(f"{place}: stays; {where}")
    if not count:
        screen.print("nothing was left half-written")
    if stays:
        raise CheckFailedError(f"clean: {', '.join(stays)}: cannot be removed; is it yours to remove?")
