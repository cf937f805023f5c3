"""`evenspin bench calibrate`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.bench_port import PortOption, connected
from evenspin.cli.options import Force, JsonFile
from evenspin.cli.origin import origin
from evenspin.cli.output import check_json_file, console, write_json


def register(app: typer.Typer) -> None:
    app.command("calibrate")(calibrate)


def calibrate(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="offsets, rl, encoder, mechanics, cogging or learning, in this order."),
    ] = None,
    port: PortOption = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE.toml", help="A new file; default: calibration-NAME.toml, -2, -3 ..."),
    ] = None,
    keep: Annotated[bool, typer.Option("--save", help="Keep the result over a power cycle.")] = False,
    undo: Annotated[
        Path | None, typer.Option("--undo", metavar="FILE.toml", help="Put back what a calibration has changed.")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only say what it is for and what moves.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the motor moves.")] = False,
    force: Force = False,
    known: Annotated[
        list[str] | None,
        typer.Option(metavar="PARAM", help="The default of this parameter is right for this motor; several times."),
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """Measure something of the motor, judge it, and store it in the drive. Exit status 1 when the verdict is not good.

    Example: `evenspin bench calibrate rl --save`
    """
    from evenspin.bench import calibrate as work
    from evenspin.bench.operator import operator_for
    from evenspin.errors import EvenspinError, InputError
    from evenspin.output import OutputFile
    from evenspin.sim.progress import progress_bar

    check_json_file(json_file)
    screen = console(json_file)
    if undo is not None:
        with connected(port) as drive:
            for key, value in work.undo(undo, drive).items():
                screen.print(f"{key} = {value:.6g}")
            if keep:
                drive.save()
        return
    if name is None:
        names = ", ".join(work.PROCEDURES)
        raise InputError("bench calibrate", "NAME", "(missing)", f"one of {names}", "or give --undo FILE")
    procedure = work.procedure(name)
    screen.print(f"{procedure.name}: {procedure.goal}\n{procedure.moves}")
    if dry_run:
        return
    path = out if out is not None else work.free_file(name)
    file = OutputFile(path, origin(), recording=True, force=force)  # restores the values from before
    with connected(port) as drive:
        operator = operator_for(drive.link.transport, lambda request: yes or typer.confirm(request, err=True))
        given = tuple(known or ())
        for number in work.inputs_of(drive, operator, name, given):
            if not number.sure:
                screen.print(f"{number}. The result will not be stored; {number.first}")
        if not operator.has_load_machine and not yes and not typer.confirm("Go on?", err=True):
            raise typer.Exit(1)
        with progress_bar(name, 1.0) as bar:
            done = work.calibrate(drive, operator, name, bar.update, given)
        try:
            file.write(work.calibration_toml(done, drive))
        except EvenspinError as error:  # do not continue without the means to restore
            if done.good:
                drive.set(done.before)
            raise EvenspinError(f"{error}; the drive has the values from before the calibration") from None
        if keep and done.good:
            work.keep(drive, done)
    for line in done.lines:
        screen.print(line)
    if done.found.note:
        screen.print(done.found.note)
    if done.found.parameters:
        stored = "measured now, stored in the drive" if done.good else "not stored"
        screen.print(f"{', '.join(done.found.parameters)}: {stored}")
    screen.print(f"{path}", style="bold")
    if json_file is not None:
        content = {
            "name": name,
            "good": done.good,
            "inputs": [
                {"name": n.name, "value": n.value, "unit": n.unit, "origin": str(n.origin)} for n in done.inputs
            ],
            "verdicts": [
                {"what": v.what, "value": v.value, "unit": v.unit, "low": v.low, "high": v.high, "good": v.good}
                for v in done.found.verdicts
            ],
            "parameters": dict(done.found.parameters),
            "before": dict(done.before),
            "note": done.found.note,
        }
        write_json(content, json_file)
    if not done.good:
        raise typer.Exit(1)
