"""`evenspin identify`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from evenspin.cli.identify_mechanics import identify_mechanics
from evenspin.cli.options import Force, JsonFile, Numeric, NumericOption
from evenspin.cli.origin import origin
from evenspin.cli.output import ALL_IDENTIFICATIONS, check_json_file, console, write_json

SIMULATED = "sim"
MODEL = "yeh2024"

app = typer.Typer(
    no_args_is_help=True, help="Identify a machine from logs, or from experiments on the simulated drive."
)

Logs = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[LOG...]", help="Case folders or CSV files; with --run sim: a model file or built-in model."
    ),
]
RunOption = Annotated[
    str | None, typer.Option("--run", metavar="sim", help="Perform the experiments on the simulated drive first.")
]
TorqueOption = Annotated[str, typer.Option(help="Torque from the measured current, or from the command a row earlier.")]
TorquePerA = Annotated[
    float | None, typer.Option(help="Torque of an ampere, N m/A.", show_default="1.5 p psi of meta.json")
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Folder for model.toml, drive.toml, report.html, and the logs of --run."),
]
Snap = Annotated[bool, typer.Option("--snap", help="Lines within the resolution of a whole order become that order.")]
NoStribeck = Annotated[bool, typer.Option("--no-stribeck", help="Viscous and Coulomb friction only.")]
Noise = Annotated[float, typer.Option(help="--run: standard deviation of the torque that a row measures, N m.")]
TopSpeed = Annotated[float, typer.Option(help="--run: fastest speed, rad/s.")]
Seed = Annotated[int, typer.Option(min=0, max=2**63 - 1, help="--run: seed of the noise.")]


def register(parent: typer.Typer) -> None:
    app.command("mechanics")(identify_mechanics)
    parent.add_typer(app, name="identify")


@app.callback()
def group() -> None:
    """Identify a machine from logs, or from experiments on the simulated drive."""


@app.command("friction")
def friction(
    logs: Logs = None,
    run: RunOption = None,
    no_stribeck: NoStribeck = False,
    torque: TorqueOption = "measured",
    torque_per_a_nm: TorquePerA = None,
    top_speed: TopSpeed = 12.0,
    noise: Noise = 0.01,
    seed: Seed = 1,
    numeric: NumericOption = Numeric.FLOAT,
    out: Out = None,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Viscous, Coulomb, static friction, Stribeck speed and shape from constant speeds in both directions.

    Each speed is held for at least a turn; a log may step through many.

    Example: `evenspin identify friction --run sim yeh2024`
    """
    settings: dict[str, Any] = {"stribeck": not no_stribeck, "torque": torque, "torque_per_a_nm": torque_per_a_nm}
    settings |= {"top_rad_s": top_speed, "noise_nm": noise, "seed": seed, "numeric": numeric.value}
    _identify(("friction",), logs, run, settings, out, force, json_file)


@app.command("inertia")
def inertia(
    logs: Logs = None,
    run: RunOption = None,
    torque: TorqueOption = "measured",
    torque_per_a_nm: TorquePerA = None,
    top_speed: TopSpeed = 12.0,
    noise: Noise = 0.01,
    seed: Seed = 1,
    numeric: NumericOption = Numeric.FLOAT,
    out: Out = None,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Inertia from a run that speeds up and brakes.

    Example: `evenspin identify inertia --run sim yeh2024`
    """
    settings: dict[str, Any] = {"torque": torque, "torque_per_a_nm": torque_per_a_nm}
    settings |= {"top_rad_s": top_speed, "noise_nm": noise, "seed": seed, "numeric": numeric.value}
    _identify(("inertia",), logs, run, settings, out, force, json_file)


@app.command("cogging")
def cogging(
    logs: Logs = None,
    run: RunOption = None,
    snap: Snap = False,
    torque: TorqueOption = "measured",
    torque_per_a_nm: TorquePerA = None,
    noise: Noise = 0.01,
    seed: Seed = 1,
    numeric: NumericOption = Numeric.FLOAT,
    out: Out = None,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Orders, amplitudes and phases of the torque tied to the angle, from slow turns; the first turn is skipped.

    Example: `evenspin identify cogging --run sim yeh2024 --snap`
    """
    settings: dict[str, Any] = {"snap": snap, "torque": torque, "torque_per_a_nm": torque_per_a_nm}
    settings |= {"noise_nm": noise, "seed": seed, "numeric": numeric.value}
    _identify(("cogging",), logs, run, settings, out, force, json_file)


@app.command(ALL_IDENTIFICATIONS)
def everything(
    logs: Logs = None,
    run: RunOption = None,
    snap: Snap = False,
    no_stribeck: NoStribeck = False,
    torque: TorqueOption = "measured",
    top_speed: TopSpeed = 12.0,
    noise: Noise = 0.01,
    seed: Seed = 1,
    numeric: NumericOption = Numeric.FLOAT,
    out: Out = None,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Friction, inertia and cogging, from experiments on the simulated drive (the same as without `all`).

    Example: `evenspin identify --run sim yeh2024 --out out/identified`
    """
    from evenspin.errors import InputError

    if run is None:
        must = "sim: logs belong to one of friction, inertia, cogging"
        raise InputError("identify", "--run", "(missing)", must, "give --run sim, or name the experiment")
    settings: dict[str, Any] = {"snap": snap, "stribeck": not no_stribeck, "torque": torque}
    settings |= {"top_rad_s": top_speed, "noise_nm": noise, "seed": seed, "numeric": numeric.value}
    _identify(("friction", "inertia", "cogging"), logs, run, settings, out, force, json_file)


def _identify(
    kinds: Sequence[str],
    logs: Sequence[str] | None,
    run: str | None,
    settings: dict[str, Any],
    out: Path | None,
    force: bool,
    json_file: str | None,
) -> None:
    from evenspin.errors import InputError
    from evenspin.identify.command import Choices, from_logs, from_simulation, write
    from evenspin.identify.result import drive_text, tables_of
    from evenspin.identify.source import torque_from
    from evenspin.output import OutputFolder
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    check_json_file(json_file)
    names = list(logs or ())
    if run not in (None, SIMULATED):
        raise InputError("identify", "--run", run, "sim", "leave it out to read logs")
    if run == SIMULATED and len(names) > 1:
        raise InputError("identify", "MODEL", " ".join(names), "one model", "with --run sim no log is read")
    choices = Choices(kinds, **settings)
    made = origin(*names)
    output = OutputFolder(out, made, force=force) if out is not None else None
    if run == SIMULATED:
        with progress_bar("experiments", 1.0) as bar:
            work = from_simulation(names[0] if names else MODEL, choices, bar.update)
    else:
        work = from_logs([Path(name) for name in names], choices)
    screen = console(json_file)
    for view in tables_of(work.found):
        print_table(view, screen)
    screen.print(drive_text(work.found))
    screen.print(torque_from(work.base, choices.torque_per_a_nm), soft_wrap=True)
    if output is not None:
        with output as folder:
            write(folder, work, made.command)
        screen.print(f"{out}/report.html", style="bold")
    if json_file is not None:
        write_json(work.found.as_json(), json_file)
