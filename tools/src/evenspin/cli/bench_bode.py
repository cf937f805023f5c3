"""`evenspin bench bode`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from evenspin.cli.bench_port import PortOption, connected
from evenspin.cli.options import Force, JsonFile
from evenspin.cli.origin import origin
from evenspin.cli.output import check_json_file, console, write_json

if TYPE_CHECKING:
    from evenspin.bench.response import Response
    from evenspin.tableview import TableView


def register(app: typer.Typer) -> None:
    app.command("bode")(bode)


def bode(
    port: PortOption = None,
    at: Annotated[
        str, typer.Option("--at", metavar="PLACE", help="torque, current or speed: the reference that gets the sine.")
    ] = "torque",
    first: Annotated[float, typer.Option("--from", metavar="HZ", help="Lowest frequency.")] = 2.0,
    last: Annotated[
        float | None, typer.Option("--to", metavar="HZ", help="Default: 0.45 of the sample rate of the loop.")
    ] = None,
    points: Annotated[int, typer.Option("--points", metavar="N", help="Frequencies, evenly over the decades.")] = 24,
    amplitude: Annotated[
        float | None, typer.Option("--amplitude", metavar="A|RAD_S", help="Default: a twentieth of the drive's limit.")
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option("--speed", metavar="RAD_S", help="Turn at this speed; default: a quarter of base speed."),
    ] = None,
    current: Annotated[
        float | None,
        typer.Option("--iq", metavar="A", help="Instead: current mode at this q current, with the shaft locked."),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE.csv", help="A new file for all points.")] = None,
    plot: Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Bode plot: .png, .svg or .pdf.")] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the motor moves.")] = False,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Frequency response of the running drive (FRA, Bode plot).

    At torque: loop gain with its margins, and plant. At current: the closed current loop. At speed: the closed speed
    loop.

    Exit status 1 when no point is good: coherence below 0.95, or a limit has cut the sine.

    Example: `evenspin bench bode --port sim:servo --speed 50`
    """
    from evenspin.bench.numbers import Mode
    from evenspin.bench.operator import operator_for
    from evenspin.bench.response import content_of, lines_of, measure, plan_of, top_speed_rad_s
    from evenspin.errors import InputError
    from evenspin.output import OutputFile
    from evenspin.report.bode import write_bode
    from evenspin.report.plotfile import check_plot_file
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    check_json_file(json_file)
    screen = console(json_file)
    if speed is not None and current is not None:
        raise InputError("bench bode", "--speed, --iq", f"{speed:g}, {current:g}", "one of the two", "leave one out")
    if current is not None and at != "current":
        raise InputError("bench bode", "--at", at, "current with --iq", "current mode controls no speed")
    if plot is not None:
        check_plot_file(plot)
    file = OutputFile(out, origin(), recording=True, force=force) if out is not None else None
    with connected(port) as drive:
        plan = plan_of(drive, at, first, last, points, amplitude)
        wanted = top_speed_rad_s(drive) if speed is None else speed
        what = f"turns at {wanted:.4g} rad/s" if current is None else f"makes {current:.4g} A of q current"
        screen.print(f"The motor {what}; a sine of {plan.amplitude:.4g} {plan.unit} is added to the {at} reference.")
        operator = operator_for(drive.link.transport, lambda request: yes or typer.confirm(request, err=True))
        if not operator.has_load_machine and not yes and not typer.confirm("Go on?", err=True):
            raise typer.Exit(1)
        if current is None:
            drive.setpoint(Mode.SPEED, speed_rad_s=wanted)
        else:
            drive.find_zero()
            operator.lock(True)
            drive.setpoint(Mode.CURRENT, iq_a=current)
        try:
            drive.start()
            with progress_bar("frequency response", 1.0) as bar:
                found = measure(drive, plan, bar.update)
            drive.stop()
        finally:
            if current is not None and not drive.link.lost:
                operator.lock(False)
    if file is not None:
        file.write(_csv(found))
    if plot is not None:
        write_bode(plot, [point.f_hz for point in found.points], _curves(found))
    print_table(_table(found), screen)
    for line in lines_of(found):
        screen.print(line)
    for path in (out, plot):
        if path is not None:
            screen.print(f"{path}", style="bold")
    if json_file is not None:
        write_json(content_of(found), json_file)
    if not any(point.good for point in found.points):
        screen.print(
            "No point is good: raise --amplitude, or stay within the limits of the currents and the bandwidth."
        )
        raise typer.Exit(1)


def _table(found: Response) -> TableView:
    from evenspin.bench.response import decibel
    from evenspin.tableview import TableView

    header = ["f [Hz]"]
    for name in found.names:
        header += [f"{name} [{decibel(name)}]", "phase [deg]", "coherence"]
    rows = []
    for point in found.points:
        cells = [f"{point.f_hz:.4g}"]
        for name in found.names:
            each = point.ratios[name]
            cut = " cut" if point.cut else ""
            cells += [f"{each.gain_db:.2f}", f"{each.phase_deg:.1f}", f"{each.coherence:.3f}{cut}"]
        rows.append(cells)
    marks = ["" if point.good else "bad" for point in found.points]
    return TableView("Frequency response", "", header, rows, marks, left=0)


def _curves(found: Response) -> list[tuple[str, list[complex], list[bool]]]:
    """Name with unit, values, and whether each point is good."""
    from evenspin.bench.response import decibel

    good = [point.good for point in found.points]
    return [
        (f"{name} [{decibel(name)}]", [point.ratios[name].value for point in found.points], good)
        for name in found.names
    ]


def _csv(found: Response) -> str:
    from evenspin.bench.response import table

    columns, rows = table(found)
    lines = [",".join(columns)] + [",".join(f"{value:.9g}" for value in row) for row in rows]
    return "\n".join(lines) + "\n"
