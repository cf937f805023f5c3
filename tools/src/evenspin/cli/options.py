"""Options that several commands have."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.completion import change_names, method_names, scenario_names


class Numeric(StrEnum):
    """Which build of the firmware."""

    FLOAT = "float"
    FIXED = "fixed"


# Not an enumeration: the methods stand in the drive's list of parameters, which is read when a command needs it.
MethodOption = Annotated[
    str | None,
    typer.Option(
        "--method",
        metavar="METHOD",
        autocompletion=method_names,
        help="Instead of the method in the file: a choice of the parameter method, see `evenspin parameters`.",
    ),
]
NumericOption = Annotated[Numeric, typer.Option(help="Arithmetic of the firmware: single precision or fixed point.")]
JsonFlag = Annotated[
    bool,
    typer.Option(
        "--json",
        help="Print JSON on stdout, with text for people on stderr; --json FILE.json writes it to a file.",
    ),
]
JsonFile = Annotated[
    str | None,
    typer.Option("--json", metavar="[FILE]", help="Write JSON to FILE, or to stdout when FILE is left out."),
]
OutFolder = Annotated[
    Path,
    typer.Option(
        "--out", metavar="DIR", help="Folder for the output: new, empty, or what this very command made (replaced)."
    ),
]
Force = Annotated[
    bool,
    typer.Option("--force", help="Replace also a recording, what another command made, and what was changed since."),
]
SignalsOption = Annotated[
    list[str] | None,
    typer.Option("--signal", metavar="NAME", help="Several times; default: speed, currents, voltages."),
]
SpeedOption = Annotated[
    float | None,
    typer.Option("--speed", metavar="RAD_S", help="Turn at this speed meanwhile; the motor stops at the end."),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        autocompletion=change_names,
        help="As if it stood in the file: a parameter of the drive, a number of [plant], EFFECT.PARAMETER, or a key of "
        "the scenario; several times.",
    ),
]
ScenarioName = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="A file .toml, or a built-in scenario (`evenspin scenarios`).",
        autocompletion=scenario_names,
    ),
]
