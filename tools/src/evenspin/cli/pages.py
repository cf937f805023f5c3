"""`evenspin docs`: the reference pages that come from the tables."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.output import console


def register(app: typer.Typer) -> None:
    app.command("docs")(docs)


def docs(
    folder: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where to write the pages.")] = Path("docs"),
    check: Annotated[bool, typer.Option(help="Write nothing; exit status 1 when a page is not current.")] = False,
) -> None:
    """Write the pages of docs made from code: parameters, effects, faults, model, scenario, api, gap-thresholds.

    Example: `evenspin docs --check`
    """
    from evenspin.api.reference import pages as api_pages
    from evenspin.errors import CheckFailedError, InputError
    from evenspin.gap.reference import pages as gap_pages
    from evenspin.model.reference import pages as file_pages
    from evenspin.report.reference import pages as table_pages

    if not folder.is_dir():
        raise InputError("--out", "folder", str(folder), "an existing folder", "run it in the checkout")
    stale = []
    for name, text in (table_pages() | file_pages() | api_pages() | gap_pages()).items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            stale.append(name)
            if not check:
                path.write_text(text, encoding="utf-8")
    console().print(f"{', '.join(stale) or 'nothing'} {'to write' if check else 'written'}")
    if check and stale:
        raise CheckFailedError(f"{folder}: {', '.join(stale)}: not current, run evenspin docs")
