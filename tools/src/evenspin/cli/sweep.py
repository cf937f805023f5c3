"""`evenspin sweep`."""

from __future__ import annotations

from typing import Annotated

import typer

from evenspin.cli.completion import change_names
from evenspin.cli.options import Force, JsonFlag, Numeric, NumericOption, OutFolder, ScenarioName, SetOption
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, write_json


def register(app: typer.Typer) -> None:
    app.command("sweep")(sweep)


def sweep(
    scenario: ScenarioName,
    vary: Annotated[
        list[str],
        typer.Option(
            "--vary",
            metavar="NAME=VALUES",
            autocompletion=change_names,
            help="A,B,C or FIRST:LAST:COUNT or FIRST:LAST:COUNT:log; several times: every combination.",
        ),
    ],
    out: OutFolder,
    set_: SetOption = None,
    parquet: Annotated[bool, typer.Option("--parquet", help="Write sweep.parquet, too. Needs pyarrow.")] = False,
    workers: Annotated[int | None, typer.Option(min=1, help="Runs at a time; one per core when left out.")] = None,
    numeric: NumericOption = Numeric.FLOAT,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Run a scenario over a grid of its parameters, on all cores: one table of every number, with pictures.

    DIR gets sweep.csv, a row for each run and each of its steady states or motions, and report.html. NAME is a
    parameter of the drive, a number of [plant], EFFECT.PARAMETER, seed, duration_s, or a key of an event. A combination
    that is refused or trips is a row that says so; exit status 1 when no run got to its end.

    Example: `evenspin sweep guo2024/third --vary method=crc,forc --vary rc_gain=0.1:0.6:6 --out out/sweep`
    """
    from evenspin.errors import CheckFailedError
    from evenspin.grid import parsed_axes, run_grid
    from evenspin.grid.pictures import page_of
    from evenspin.grid.result import csv_text, need_parquet, table_of, write_parquet
    from evenspin.model.changes import parsed_changes
    from evenspin.model.scenario import scenario_document
    from evenspin.output import OutputFolder
    from evenspin.report.page import write_page
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    document = scenario_document(scenario)
    axes, fixed = parsed_axes(vary), parsed_changes(set_ or ())
    if parquet:
        need_parquet()
    made = origin(document.path)
    output = OutputFolder(out, made, force=force)
    total = 1
    for values in axes.values():
        total *= len(values)
    with progress_bar(f"{total} runs", total) as bar:
        grid = run_grid(document, axes, fixed, numeric=numeric.value, workers=workers, progress=bar.update)
    screen = console(STDOUT if as_json else None)
    print_table(table_of(grid), screen)
    with output as folder:
        (folder / "sweep.csv").write_text(csv_text(grid), encoding="utf-8")
        if parquet:
            write_parquet(folder / "sweep.parquet", grid)
        write_page(folder, page_of(grid, made.command))
    screen.print(f"{out}/report.html", style="bold")
    if as_json:
        write_json({"scenario": grid.scenario, "axes": grid.axes, "set": grid.fixed, "rows": grid.rows}, STDOUT)
    if not grid.ran:
        raise CheckFailedError(f"sweep: no run got to its end; the first: {grid.rows[0]['why']}")
