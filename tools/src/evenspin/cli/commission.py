"""`evenspin commission`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from evenspin.cli.bench_port import PortOption, connected
from evenspin.cli.options import Force, JsonFlag
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, write_json

if TYPE_CHECKING:
    from evenspin.commission.work import Commissioned


def register(app: typer.Typer) -> None:
    app.command("commission")(commission)


def commission(
    port: PortOption = None,
    max_current: Annotated[
        float | None, typer.Option("--max-current", metavar="A", help="Largest phase current of motor and board, peak.")
    ] = None,
    max_speed: Annotated[
        float, typer.Option("--max-speed", metavar="RAD_S", help="Fastest that the motor may turn; 0: not said.")
    ] = 0.0,
    max_voltage: Annotated[
        float, typer.Option("--max-voltage", metavar="V", help="Largest dc-link voltage; 0: 1.25 of the supply.")
    ] = 0.0,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder for the files: new, or empty.", show_default=False),
    ] = None,
    goal: Annotated[str, typer.Option(help="stiff, smooth or quiet.")] = "smooth",
    methods: Annotated[bool, typer.Option(help="Try each method in simulation, which takes longest.")] = True,
    keep: Annotated[bool, typer.Option("--save", help="Keep the result over a power cycle.")] = False,
    undo: Annotated[
        Path | None,
        typer.Option("--undo", metavar="DIR", help="Put back what the drive held before that commissioning."),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the motor moves.")] = False,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Measure a motor of which only the limits are known, and tune its drive.

    Exit status 0 only when every step is good.

    Offsets, resistance, inductances, pole pairs, direction, electrical zero, flux, inertia and friction, then gains,
    then a proof that the tuned drive turns the motor both ways. The shaft must be free. Nothing that the drive held of
    another motor is used. DIR/model.toml, DIR/drive.toml, DIR/report.md to sign, and DIR/before.toml
    with what the drive held before. When a step is not good the drive gets those values back.

    Example: `evenspin commission --port /dev/ttyUSB0 --max-current 12 --max-speed 400 --yes --out mine`
    """
    from evenspin.bench.config import config_toml
    from evenspin.commission.limits import Bounds
    from evenspin.commission.report import write_files
    from evenspin.commission.work import commission as work
    from evenspin.errors import InputError
    from evenspin.output import OutputFolder
    from evenspin.sim.progress import progress_bar
    from evenspin.tune.goals import GOALS

    screen = console(STDOUT if as_json else None)
    if undo is not None:
        _undo(port, undo, screen)
        return
    for name, given in (("--max-current", max_current), ("--out", out)):
        if given is None:
            raise InputError("commission", name, "(missing)", "given", "`evenspin commission --help` has an example")
    assert max_current is not None and out is not None
    if goal not in GOALS:
        raise InputError("commission", "--goal", goal, f"one of {', '.join(GOALS)}", "smooth is the default")
    bounds = Bounds(max_current, max_speed, max_voltage)
    made = origin()
    output = OutputFolder(out, made, recording=True, force=force)
    with connected(fresh(port)) as drive:
        question = (
            f"The motor is going to turn both ways, with up to {max_current:g} A. Is the shaft free, the brake off?"
        )
        if not drive.link.transport.lockstep and not yes and not typer.confirm(question, err=True):
            raise typer.Exit(1)
        before = config_toml(drive)
        with progress_bar("commission", 1.0) as bar:
            done = work(drive, bounds, goal, methods=methods, progress=bar.update, say=screen.print)
        with output as folder:
            write_files(folder, done, drive, before, made.command)
        if keep and done.good:
            drive.save()
        content = _content(done, out)
    screen.print(f"{out}/report.md", style="bold")
    if done.error:
        screen.print(f"NOT GOOD: {done.error}. The drive has the values from before.", style="bold red", soft_wrap=True)
    if as_json:
        write_json(content, STDOUT)
    if not done.good:
        raise typer.Exit(1)


def fresh(port: str | None) -> str | None:
    """A virtual drive inside of the command starts as a board that was just flashed: it knows nothing of its motor."""
    if port is None or not port.startswith("sim:") or "fresh=" in port:
        return port
    return f"{port}{'&' if '?' in port else '?'}fresh=1"


def _undo(port: str | None, folder: Path, screen: Any) -> None:
    from evenspin.bench.config import differences, read_config
    from evenspin.commission.report import BEFORE

    with connected(port) as drive:
        drive.stop()
        changes = differences(read_config(folder / BEFORE, drive), drive)
        drive.set({change.field.name: change.file for change in changes})
    for change in changes:
        screen.print(f"{change.field.name} = {change.file:.6g}")
    screen.print(f"{len(changes)} parameters put back")


def _content(done: Commissioned, out: Path) -> dict[str, Any]:
    known = done.known

    def pair(estimate: Any) -> dict[str, float | None]:
        half = estimate.half if estimate.half < 1e300 else None
        return {"value": estimate.value, "half": half}

    return {
        "good": done.good,
        "error": done.error,
        "seconds": done.seconds,
        "folder": str(out),
        "pole_pairs": known.pole_pairs,
        "encoder_reversed": known.reversed,
        "encoder_counts": known.counts,
        "encoder_offset_rad": known.offset_rad,
        "resistance_ohm": pair(known.resistance),
        "ld_h": pair(known.ld),
        "lq_h": pair(known.lq),
        "psi_wb": pair(known.psi),
        "inertia_kgm2": pair(known.inertia),
        "viscous_nms": pair(known.viscous),
        "coulomb_nm": pair(known.coulomb),
        "steps": [
            {
                "name": step.name,
                "good": step.good,
                "seconds": step.seconds,
                "notes": list(step.notes),
                "qualities": [
                    {"what": q.what, "value": q.value, "unit": q.unit, "good": q.good} for q in step.qualities
                ],
            }
            for step in done.steps
        ],
    }
