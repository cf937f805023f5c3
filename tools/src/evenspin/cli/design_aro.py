"""`evenspin design aro`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.options import JsonFile
from evenspin.cli.output import check_json_file, console, output_file, write_json

Number = float | None


def _option(text: str, default: str = "from the model") -> typer.models.OptionInfo:
    return typer.Option(help=text, show_default=default)


def design_aro(
    model: Annotated[str, typer.Option(help="A model file .toml, or a built-in model.")] = "tang2020-rig2",
    cells: Annotated[int | None, _option("N, memory points per turn.")] = None,
    gain: Annotated[Number, _option("Learning gain a23 L_N, no unit.")] = None,
    pole: Annotated[Number, _option("Instead of the gain: |lambda|, where the poles lie.", "from the gain")] = None,
    turns: Annotated[Number, _option("Instead of the gain: time constant, mechanical turns.", "from the gain")] = None,
    forgetting: Annotated[Number, _option("Forgetting factor Q, no unit.")] = None,
    pi_hz: Annotated[float, typer.Option(help="Double pole of the speed loop, Hz.")] = 16.0,
    inertia_kgm2: Annotated[Number, _option("Total inertia, kg m^2.")] = None,
    viscous_nms: Annotated[Number, _option("Viscous friction, N m s/rad.")] = None,
    order: Annotated[int, typer.Option(min=1, max=1000, help="Mechanical order whose residue is printed.")] = 12,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Convergence, poles, filters: FILE.svg or FILE.png.")
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """Pole placement of the angle-based repetitive observer and of the speed controller beside it.

    lambda^N = Q - a23 L_N, 0 < L_N < 2 / a23. Exit status 1 when a pole is not inside the unit circle.

    Example: `evenspin design aro --turns 20 --pi-hz 16`
    """
    from evenspin.design.aro import as_json
    from evenspin.design.aro_command import Choices, prepare, tables_of
    from evenspin.design.aro_separation import separation_error
    from evenspin.design.source import calculated_with
    from evenspin.errors import CheckFailedError
    from evenspin.report.plotfile import check_plot_file
    from evenspin.tableview import number, print_table

    check_json_file(json_file)
    if plot is not None:
        check_plot_file(plot)
    drawn = output_file(plot, "--plot", model) if plot is not None else None
    choices = Choices(cells, gain, pole, turns, forgetting, pi_hz, inertia_kgm2, viscous_nms, order)
    found = prepare(model, choices)
    screen = console(json_file)
    for view in tables_of(found, order):
        print_table(view, screen)
    names = ("inertia_kgm2", "viscous_nms", "pole_pairs", "psi_wb", "observer_actuation_samples")
    given = {"inertia_kgm2": inertia_kgm2, "viscous_nms": viscous_nms}
    screen.print(calculated_with(model, names, given), soft_wrap=True)
    if drawn is not None:
        from evenspin.design.aro_plots import write_design

        with drawn as place:
            write_design(place, found)
        screen.print(str(plot), style="bold")
    if json_file is not None:
        separation = separation_error(found.mechanics, found.memory, found.speed)
        write_json(as_json(found) | {"separation_error": separation}, json_file)
    if not found.memory.stable:
        ln, bound = found.memory.observer_gain, found.memory.bound
        raise CheckFailedError(f"L_N = {number(ln, 4)}: must be above 0 and below {number(bound, 4)} (2 / a23)")
    if not found.speed.stable:
        raise CheckFailedError(f"--pi-hz = {pi_hz:g}: with the delays of the drive the speed loop is not stable")
