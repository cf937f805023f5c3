"""`evenspin identify mechanics`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from evenspin.cli.options import Force, JsonFile, Numeric, NumericOption
from evenspin.cli.origin import origin
from evenspin.cli.output import check_json_file, console, output_file, write_json

SIMULATED = "sim"
BITS = 7
Number = float | None


class How(StrEnum):
    PRBS = "prbs"


def _option(text: str, default: str) -> typer.models.OptionInfo:
    return typer.Option(help=text, show_default=default)


def identify_mechanics(
    logs: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[LOG...]", help="Case folders or CSV files; with --run sim: a model file or built-in model."
        ),
    ] = None,
    method: Annotated[How, typer.Option(help="prbs: a pseudo-random sequence of the torque.")] = How.PRBS,
    run: Annotated[
        str | None, typer.Option("--run", metavar="sim", help="Perform the experiment on the simulated drive first.")
    ] = None,
    speed_rpm: Annotated[Number, _option("--run: mean speed, rpm.", "a sixth of what trips the drive")] = None,
    amplitude_a: Annotated[Number, _option("--run: amplitude, A of q current.", "speed swings by 30 %")] = None,
    bit_s: Annotated[Number, _option("--run: time of a bit, s.", "a fifth of J / B, 0.02 to 0.2")] = None,
    bits: Annotated[int, typer.Option(help="--run: 2^bits - 1 bits make the sequence.")] = BITS,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="--run: only show what would be done.")] = False,
    window_s: Annotated[float, typer.Option(help="Window over which torque and motion are weighed, s.")] = 0.2,
    torque_per_a_nm: Annotated[Number, _option("Torque of an ampere, N m/A.", "1.5 p psi of meta.json")] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**63 - 1, help="--run: seed of the noise.")] = 1,
    numeric: NumericOption = Numeric.FLOAT,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Speed, torque, residual: .svg, .png, .pdf.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder for model.toml, report.html, and the log of --run."),
    ] = None,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Inertia J and viscous friction B from a pseudo-random torque, in a log or on the simulated drive.

    Current mode around a mean speed. Refused when the data do not determine J or B to 10 %.

    Example: `evenspin identify mechanics --method prbs --run sim tang2020-rig2`
    """
    from evenspin.errors import InputError
    from evenspin.identify.mechanics_command import draw, from_logs, from_simulation, machine_of, tables_of, write
    from evenspin.identify.prbs import plan
    from evenspin.identify.source import torque_from
    from evenspin.output import OutputFolder
    from evenspin.report.plotfile import check_plot_file, save_figure
    from evenspin.report.style import drawing
    from evenspin.tableview import print_table

    check_json_file(json_file)
    if plot is not None:
        check_plot_file(plot)
    names = list(logs or ())
    settings: dict[str, Any] = {"speed_rpm": speed_rpm, "amplitude_a": amplitude_a, "bit_s": bit_s, "bits": bits}
    screen = console(json_file)
    if run is None:
        others = {"dry_run": dry_run or None, "bits": None if bits == BITS else bits}
        _refuse_with_logs({**settings, **others})
    elif run != SIMULATED:
        raise InputError("identify mechanics", "--run", run, "sim", "leave it out to read logs")
    elif len(names) != 1:
        must = "one model, a file .toml or a built-in one"
        raise InputError("identify mechanics", "MODEL", " ".join(names) or "(missing)", must, "try tang2020-rig2")
    made = origin(*names)
    drawn = output_file(plot, "--plot", *names) if plot is not None else None
    output = OutputFolder(out, made, force=force) if out is not None else None
    if dry_run:
        wanted = plan(*machine_of(names[0]), **settings).as_json()
        screen.print("\n".join(f"{name} = {value:.5g}" for name, value in wanted.items()))
        if json_file is not None:
            write_json(wanted, json_file)
        return
    if run is None:
        work = from_logs([Path(name) for name in names], torque_per_a_nm, window_s)
    else:
        work = from_simulation(names[0], settings, window_s, seed, numeric.value)
    for view in tables_of(work):
        print_table(view, screen)
    screen.print(torque_from(work.base, torque_per_a_nm), soft_wrap=True)
    if drawn is not None:
        with drawing(), drawn as place:
            save_figure(place, draw(work)[0])
        screen.print(str(plot), style="bold")
    if output is not None:
        with output as folder:
            write(folder, work, made.command)
        screen.print(f"{out}/report.html", style="bold")
    if json_file is not None:
        write_json(work.as_json(), json_file)


def _refuse_with_logs(settings: dict[str, object]) -> None:
    from evenspin.errors import InputError

    for name, value in settings.items():
        if value is not None:
            option = f"--{name.replace('_', '-')}"
            raise InputError("identify mechanics", option, value, "left out with logs", "it is for --run sim")
