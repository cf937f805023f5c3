"""`evenspin export`: for other simulators."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.options import Force, ScenarioName, SetOption
from evenspin.cli.origin import origin
from evenspin.cli.output import console


class Kind(StrEnum):
    """What the FMU holds."""

    DRIVE = "drive"
    PLANT = "plant"


app = typer.Typer(no_args_is_help=True, help="Export a scenario for other simulators.")


def register(parent: typer.Typer) -> None:
    app.command("fmu")(fmu)
    parent.add_typer(app, name="export")


@app.callback()
def group() -> None:
    """Export a scenario for other simulators."""


def fmu(
    scenario: ScenarioName,
    out: Annotated[Path, typer.Option("--out", metavar="FILE.fmu", help="The FMU to write.")],
    kind: Annotated[
        Kind, typer.Option(help="drive: the firmware on the machine; plant: the machine, driven by phase duties.")
    ] = Kind.DRIVE,
    set_: SetOption = None,
    force: Force = False,
) -> None:
    """A co-simulation unit of FMI 3.0, for Simulink, Dymola, OpenModelica and others: the very firmware on the machine.

    Its inputs begin as the scenario does at time 0; what happens later, whoever runs it gives. Every number of the
    machine, the drive and the effects is a parameter. It runs on the kind of machine that it was made on.

    Example: `evenspin export fmu guo2024/first --set method=fal-forc --out drive.fmu`
    """
    from evenspin.errors import InputError
    from evenspin.export import fmu_bytes
    from evenspin.model.changes import changes_of, parsed_changes
    from evenspin.model.scenario import scenario_document, scenario_from
    from evenspin.output import OutputFile

    if out.suffix != ".fmu":
        raise InputError("export fmu", "--out", out, "a file .fmu", "give it that ending")
    document = scenario_document(scenario)
    loaded = scenario_from(document, changes_of(parsed_changes(set_ or ()), document, "--set"))
    made = origin(document.path, loaded.machine.document.path)
    file = OutputFile(out, made, force=force)
    content = fmu_bytes(loaded.setup, kind.value, made.command)
    with file as place:
        place.write_bytes(content)
    screen = console()
    later = len(loaded.setup.event_times_s) + len(loaded.setup.tunes)
    if later and kind is Kind.DRIVE:
        screen.print(f"Not in it: what changes after time 0 ({later} times); the inputs are given from outside.")
    screen.print(str(out), style="bold")
