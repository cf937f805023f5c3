"""`evenspin tune`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.options import Force, JsonFlag
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, write_json


def register(app: typer.Typer) -> None:
    app.command("tune")(tune)


def tune(
    model: Annotated[str, typer.Argument(metavar="MODEL", help="A model file .toml, or a built-in model.")],
    goal: Annotated[str, typer.Option(help="stiff, smooth or quiet.")] = "smooth",
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE.toml", help="Write the parameters as a drive file.")
    ] = None,
    current_hz: Annotated[
        float | None,
        typer.Option(min=1.0, max=2000.0, help="Largest bandwidth of the current loop.", show_default="goal"),
    ] = None,
    speed_hz: Annotated[
        float | None,
        typer.Option(min=0.01, max=300.0, help="Largest bandwidth of the speed loop.", show_default="goal"),
    ] = None,
    methods: Annotated[bool, typer.Option(help="Try each method that suppresses ripple, which takes longest.")] = True,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Parameters of current, speed and position loop, observers and ripple suppression, from the numbers of a machine.

    Bandwidths are as large as goal, margins and encoder allow, also in the corners of [range]. The firmware then
    starts, takes a load step, reverses and runs at full speed in simulation, and each method is tried under a torque
    tied to the angle. What does not help here is said, with what would. Exit status 1 when the simulation is not good.

    The file is taken by `drive_file` of a model, `bench config push`, and [drive] of a scenario.

    Example: `evenspin tune servo --goal stiff --out drive.toml`
    """
    from evenspin.errors import InputError
    from evenspin.model.machine import SIMULATED, find_model, load_machine
    from evenspin.output import OutputFile
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table
    from evenspin.tune.result import as_json as tuning_json
    from evenspin.tune.result import drive_text, tables_of
    from evenspin.tune.tuning import tune as work

    def refuse(must: str, hint: str) -> InputError:
        return InputError("tune", "MODEL", model, must, hint)

    machine = load_machine(find_model(model, Path(), refuse), SIMULATED)
    made = origin(machine.document.path)
    file = OutputFile(out, made, force=force) if out is not None else None
    screen = console(STDOUT if as_json else None)
    with progress_bar("tune", STEPS) as bar:
        done = 0

        def step(_: str) -> None:
            nonlocal done
            done += 1
            bar.update(min(done, STEPS))

        found = work(machine, goal, current_hz=current_hz, speed_hz=speed_hz, methods=methods, progress=step)
    for view in tables_of(machine, found):
        print_table(view, screen)
    text = drive_text(machine, found, made.command)
    if file is not None:
        file.write(text)
        screen.print(f"{out}", style="bold")
    elif not as_json:
        screen.print(text)
    if as_json:
        write_json(tuning_json(machine, found), STDOUT)
    if not found.good:
        raise typer.Exit(1)


STEPS = 13  # loops, trial, repetitive control, six methods, four position methods
