"""`evenspin bench config`: the parameters of the drive as a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from evenspin.cli.bench_port import PortOption, connected
from evenspin.cli.options import JsonFile
from evenspin.cli.origin import origin
from evenspin.cli.output import check_json_file, console, write_json

app = typer.Typer(no_args_is_help=True, help="Parameters of the drive as a file.")


def register(parent: typer.Typer) -> None:
    parent.add_typer(app, name="config")


@app.command()
def pull(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="A new file.")],
    port: PortOption = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that says something else.")] = False,
) -> None:
    """Write all parameters of the drive to a file.

    Example: `evenspin bench config pull drive.toml`
    """
    from evenspin.bench.config import config_toml
    from evenspin.output import OutputFile

    with connected(port) as drive:
        text = config_toml(drive)
    if not (file.is_file() and file.read_bytes() == text.encode()):  # what it says already it may go on saying
        OutputFile(file, origin(), option="config pull", recording=True, force=force).write(text)
    console().print(f"{file}", style="bold")


@app.command()
def push(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml")],
    port: PortOption = None,
    force: Annotated[
        bool, typer.Option("--force", help="Also a file of another firmware, as far as names fit.")
    ] = False,
    keep: Annotated[bool, typer.Option("--save", help="Keep them over a power cycle.")] = False,
    json_file: JsonFile = None,
) -> None:
    """Write a file to the drive, all of it or nothing; only what differs is sent.

    Example: `evenspin bench config push drive.toml --save`
    """
    from evenspin.bench.config import diff_error, differences, read_config, same_schema

    check_json_file(json_file)
    with connected(port) as drive:
        if not force and not same_schema(file, drive):
            raise diff_error(file)
        changes = differences(read_config(file, drive), drive)
        drive.set({change.field.name: change.file for change in changes})
        if keep:
            drive.save()
    _show(changes, json_file)


@app.command()
def diff(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml")], port: PortOption = None, json_file: JsonFile = None
) -> None:
    """What differs between a file and the drive. Exit status 1 when something does.

    Example: `evenspin bench config diff drive.toml`
    """
    from evenspin.bench.config import differences, read_config

    check_json_file(json_file)
    with connected(port) as drive:
        changes = differences(read_config(file, drive), drive)
    _show(changes, json_file)
    if changes:
        raise typer.Exit(1)


def _show(changes: list[Any], json_file: str | None) -> None:
    from evenspin.bench.config import shortest
    from evenspin.tableview import TableView, print_table

    if json_file is not None:
        write_json({c.field.name: {"file": shortest(c.file), "drive": shortest(c.drive)} for c in changes}, json_file)
    screen = console(json_file)
    if not changes:
        screen.print("no difference")
        return
    rows = [(c.field.name, shown_value(c.field, c.file), shown_value(c.field, c.drive), c.field.unit) for c in changes]
    print_table(TableView("Differences", "", ("name", "file", "drive (before)", "unit"), rows, left=4), screen)


def shown_value(field: Any, value: float) -> str:
    from evenspin.bench.config import shortest

    return field.to_text(value) if field.kind in ("choice", "flag") else f"{shortest(value):g}"
