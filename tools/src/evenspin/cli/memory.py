"""`evenspin memory show|clear`: what the angle observer has learned, as a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.options import JsonFile
from evenspin.cli.output import check_json_file, console, output_file, write_json

HELP = "The learned memory of the angle observer (ARO), as a file: show it, clear it."

app = typer.Typer(no_args_is_help=True, help=HELP)

TableFile = Annotated[Path, typer.Argument(metavar="FILE", help="A table .csv or .json from `evenspin run`.")]


def register(parent: typer.Typer) -> None:
    parent.add_typer(app, name="memory")


@app.callback()
def group() -> None:
    """The learned memory of the angle observer (ARO), as a file: show it, clear it."""


@app.command("show")
def show(
    file: TableFile,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Over angle and order: .svg, .png, .pdf.")] = None,
    json_file: JsonFile = None,
) -> None:
    """What was learned: size, mean, strongest mechanical orders; amperes of q current, positive drives forward.

    Example: `evenspin memory show learned.csv --plot learned.svg`
    """
    from evenspin.memory import read_table
    from evenspin.report.plotfile import check_plot_file
    from evenspin.tableview import TableView, number, print_table

    check_json_file(json_file)
    if plot is not None:
        check_plot_file(plot)
    drawn = output_file(plot, "--plot", file) if plot is not None else None
    table = read_table(file)
    summary = table.summary()
    screen = console(json_file)
    torque = summary.get("orders_nm", {})
    rows = [
        (order, number(amplitude_a), number(1e3 * torque[order]) if order in torque else "-")
        for order, amplitude_a in summary["orders_a"].items()
    ]
    text = (
        f"{table.cells} cells; mean {number(summary['mean_a'])} A, rms around it {number(summary['rms_a'])} A, "
        f"{number(summary['min_a'])} to {number(summary['max_a'])} A."
    )
    if table.empty:
        screen.print(f"{file}: {table.cells} cells, nothing learned")
    else:
        print_table(TableView(str(file), text, ("mechanical order", "A", "mN m"), rows, left=0), screen)
    if drawn is not None:
        from evenspin.memory.picture import write_plot

        with drawn as place:
            write_plot(place, table)
        screen.print(str(plot), style="bold")
    if json_file is not None:
        write_json(summary, json_file)


@app.command("clear")
def clear(file: TableFile) -> None:
    """Set every cell to zero; number of cells and torque constant stay.

    Example: `evenspin memory clear learned.csv`
    """
    import numpy as np

    from evenspin.memory import AngleTable, read_table, write_table

    table = read_table(file)
    write_table(file, AngleTable(np.zeros(table.cells), table.torque_per_a_nm))
    console().print(f"{file}: {table.cells} cells, nothing learned")
