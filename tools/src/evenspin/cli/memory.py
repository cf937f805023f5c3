"""`evenspin memory show|clear|lines|from-lines`: what a drive has learned over the angle, as a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.options import Force, JsonFile
from evenspin.cli.origin import origin
from evenspin.cli.output import check_json_file, console, output_file, write_json

HELP = "What a drive has learned over the angle, as a file: show it, clear it, make lines of rdc of it, and back."

app = typer.Typer(no_args_is_help=True, help=HELP)

TableFile = Annotated[Path, typer.Argument(metavar="FILE", help="A table .csv or .json from `evenspin run`.")]


def register(parent: typer.Typer) -> None:
    parent.add_typer(app, name="memory")


@app.callback()
def group() -> None:
    """What a drive has learned over the angle, as a file: show it, clear it, make lines of rdc of it, and back."""


@app.command("show")
def show(
    file: TableFile,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Over angle and order: .svg, .png, .pdf.")] = None,
    json_file: JsonFile = None,
) -> None:
    """What was learned: size, mean, strongest orders; of aro in amperes of q current, positive drives forward.

    Example: `evenspin memory show learned.csv --plot learned.svg`
    """
    from evenspin.errors import InputError
    from evenspin.memory import is_learned_file, read_table
    from evenspin.report.plotfile import check_plot_file
    from evenspin.tableview import TableView, number, print_table

    check_json_file(json_file)
    if plot is not None:
        check_plot_file(plot)
    if is_learned_file(file):
        if plot is not None:
            raise InputError(
                "memory show",
                "--plot",
                str(plot),
                "left out: pictures are of the table of aro alone",
                "--json FILE has the numbers",
            )
        _show_learned(file, json_file)
        return
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


def _show_learned(file: Path, json_file: str | None) -> None:
    from evenspin.memory import read_learned
    from evenspin.tableview import TableView, number, print_table

    screen = console(json_file)
    found = [table.summary() for table in read_learned(file)]
    for each in found:
        text = (
            f"{each['cells']} cells over the {each['turn']} turn; mean {number(each['mean'])}, rms around it "
            f"{number(each['rms'])}, largest {number(each['largest'])} {each['unit']}."
        )
        rows = [(order, number(size)) for order, size in each["orders"].items()]
        header = (f"{each['turn']} order", each["unit"])
        print_table(TableView(f"{file}: {each['method']}", text, header, rows, left=0), screen)
    if json_file is not None:
        write_json({"tables": found}, json_file)


@app.command("lines")
def lines(
    file: TableFile,
    count: Annotated[int, typer.Option(min=1, max=6, help="How many, the strongest first.")] = 6,
    json_file: JsonFile = None,
) -> None:
    """The strongest orders of what aro has learned as lines for rdc and speed_model_ff: [drive] to paste.

    Example: `evenspin memory lines learned.csv --count 4`
    """
    from evenspin.memory import read_table
    from evenspin.memory.lines import drive_text, lines_of

    check_json_file(json_file)
    found = lines_of(read_table(file), file, count)
    console(json_file).print(drive_text(found), soft_wrap=True, highlight=False, markup=False)
    if json_file is not None:
        write_json(found, json_file)


@app.command("from-lines")
def from_lines(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The table to write, .csv or .json.")],
    model: Annotated[str, typer.Option(help="A model file .toml, or a built-in model: its torque constant and lines.")],
    drive: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Lines in [drive] of this file .toml instead, as `memory lines` prints them."
        ),
    ] = None,
    cells: Annotated[int, typer.Option(min=4, max=2048, help="Memory points per turn, aro_cells of the drive.")] = 200,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """The lines that rdc and speed_model_ff feed forward as a table of aro, which starts with what the model knows.

    Set rdc_lineN_nm = 0 where the table is loaded: with both the lines would act twice until aro has unlearned them.

    Example: `evenspin memory from-lines learned.csv --model tang2020-rig2 --drive lines.toml --cells 720`
    """
    from evenspin.errors import InputError
    from evenspin.memory import check_table_file, write_table
    from evenspin.memory.lines import table_of
    from evenspin.model.machine import drive_numbers, find_model, load_machine
    from evenspin.output import OutputFile

    def refuse(must: str, hint: str) -> InputError:
        return InputError("memory from-lines", "--model", model, must, hint)

    check_json_file(json_file)
    check_table_file(file, "memory from-lines")
    path = find_model(model, Path(), refuse)
    machine = load_machine(path)
    lines = machine.drive if drive is None else drive_numbers(drive)
    table = table_of(lines, path if drive is None else drive, cells, machine.torque_per_a_nm)
    with OutputFile(file, origin(path, drive), option="memory from-lines", force=force) as place:
        write_table(place, table)
    console(json_file).print(f"{file}: {cells} cells, largest {abs(table.disturbance_a).max():.6g} A", soft_wrap=True)
    if json_file is not None:
        write_json(table.summary(), json_file)


@app.command("clear")
def clear(file: TableFile) -> None:
    """Set every cell to zero; number of cells and torque constant stay.

    Example: `evenspin memory clear learned.csv`
    """
    from dataclasses import replace

    import numpy as np

    from evenspin.memory import AngleTable, is_learned_file, read_learned, read_table, write_learned, write_table

    if is_learned_file(file):
        tables = [replace(table, values=np.zeros(len(table.values))) for table in read_learned(file)]
        write_learned(file, tables)
        console().print(f"{file}: {sum(len(table.values) for table in tables)} cells, nothing learned")
        return
    table = read_table(file)
    write_table(file, AngleTable(np.zeros(table.cells), table.torque_per_a_nm))
    console().print(f"{file}: {table.cells} cells, nothing learned")
