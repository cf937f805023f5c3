"""`evenspin scenarios`, `evenspin models`: those that come with the package, and copies of them to begin with."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.completion import model_names, scenario_names
from evenspin.cli.options import JsonFlag
from evenspin.cli.output import STDOUT, console, output_file, write_json

Copy = Annotated[
    Path | None, typer.Option("--copy", metavar="FILE.toml", help="Write the file, comments and all, to be edited.")
]


def register(app: typer.Typer) -> None:
    app.command("scenarios")(scenarios)
    app.command("models")(models)


def scenarios(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="Only this one: its file.", autocompletion=scenario_names)
    ] = None,
    copy: Copy = None,
    as_json: JsonFlag = False,
) -> None:
    """Scenarios that come with the package, as `evenspin run` takes them: list them, print one, copy one.

    Example: `evenspin scenarios guo2024/first --copy mine.toml`
    """
    from evenspin.model.scenario import builtin_scenarios

    known = builtin_scenarios()
    keys = ("model", "duration_s", "description")
    _offer("scenarios", known, name, copy, as_json, keys, ("scenario", "model", "s", "what it is"))


def models(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="Only this one: its file.", autocompletion=model_names)
    ] = None,
    copy: Copy = None,
    as_json: JsonFlag = False,
) -> None:
    """Models that come with the package, as `model` of a scenario and `--model` take them: list, print, copy one.

    Example: `evenspin models servo --copy mine.toml`
    """
    from evenspin.model.machine import builtin_models

    keys = ("name", "description")
    _offer("models", builtin_models(), name, copy, as_json, keys, ("model", "name", "what it is"))


def _offer(
    command: str,
    known: Mapping[str, Path],
    name: str | None,
    copy: Path | None,
    as_json: bool,
    keys: tuple[str, ...],
    header: tuple[str, ...],
) -> None:
    from evenspin.errors import MISSING, InputError, did_you_mean
    from evenspin.model.document import read_document
    from evenspin.tableview import TableView, print_table

    if name is not None and name not in known:
        raise InputError(command, "NAME", name, f"one of the {command} of the package", did_you_mean(name, known))
    if name is None and copy is not None:
        raise InputError(command, "NAME", MISSING, "given with --copy", f"`evenspin {command}` lists them")
    chosen = [name] if name is not None else list(known)
    if name is not None and copy is not None:
        output_file(copy, "--copy").write(known[name].read_text(encoding="utf-8"))
    rows = {}
    for each in chosen:
        data = read_document(known[each]).data
        rows[each] = {key: data.get(key, "") for key in keys}
        rows[each]["description"] = rows[each]["description"] or _first_comment(known[each])
    if as_json:
        write_json([{"name": each, "file": str(known[each])} | row for each, row in rows.items()], STDOUT)
    elif copy is not None:
        console().print(str(copy), style="bold")
    elif name is not None:
        console().print(known[name].read_text(encoding="utf-8"), end="", soft_wrap=True)
    else:
        cells = [(each, *(str(value) for value in row.values())) for each, row in rows.items()]
        print_table(TableView(command.capitalize(), "", header, cells, left=len(header)), console())


def _first_comment(path: Path) -> str:
    """The sentences at the top of a file that has no description."""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    return " ".join(lines).partition(". ")[0].rstrip(".")
