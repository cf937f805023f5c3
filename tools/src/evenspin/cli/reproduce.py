"""`evenspin reproduce`."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from evenspin.cli.options import JsonFile, Method
from evenspin.cli.output import check_json_file, console, write_json


class Paper(StrEnum):
    GUO2024 = "guo2024"


class Numerics(StrEnum):
    FLOAT = "float"
    FIXED = "fixed"
    BOTH = "both"


class Set(StrEnum):
    FIRST = "first"
    SECOND = "second"
    THIRD = "third"


def register(app: typer.Typer) -> None:
    app.command("reproduce")(reproduce)


def reproduce(
    paper: Annotated[Paper, typer.Argument(help="Guo et al. 2024: fal-FORC in the speed loop.")],
    method: Annotated[list[Method] | None, typer.Option(help="Only these methods; may be repeated.")] = None,
    set_: Annotated[
        list[Set] | None,
        typer.Option("--set", help="Only these scenarios: 150-295, 300-488 or 900-1200 rpm; may be repeated."),
    ] = None,
    numeric: Annotated[
        Numerics, typer.Option(help="Build of the firmware; fixed is compared with float, in percentage points.")
    ] = Numerics.FLOAT,
    json_file: JsonFile = None,
) -> None:
    """Run the scenarios of a paper and compare: ours, its simulation, its experiment, the target band.

    Ripple in % of the mean, speeds in rpm. Exit status 1 when a required band is missed.

    Example: `evenspin reproduce guo2024 --json out/guo2024.json`
    """
    from evenspin.errors import CheckFailedError
    from evenspin.reproduce.guo2024 import METHODS, SETS
    from evenspin.reproduce.guo2024 import reproduce as run_all
    from evenspin.reproduce.guo2024.tables import tables_of
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    check_json_file(json_file)
    methods = [each for each in METHODS if not method or each in method]
    sets = [each for each in SETS if not set_ or each in set_]
    builds = ("float", "fixed") if numeric is Numerics.BOTH else (numeric.value,)
    results = []
    for build in builds:
        with progress_bar(f"{paper.value}, {build}", 1.0) as bar:
            results.append(run_all(build, methods, sets, bar.update))
    screen = console(json_file)
    for result in results:
        for view in tables_of(result):
            print_table(view, screen)
    if json_file is not None:
        content = results[0].as_json()
        if len(results) > 1:
            content |= {"fixed": results[1].as_json(), "passed": all(result.passed for result in results)}
        write_json(content, json_file)
    failed = [check for result in results for check in result.checks if check.required and not check.passed]
    if failed:
        worst = failed[0]
        raise CheckFailedError(
            f"{len(failed)} required checks failed, first: {worst.what} = {worst.value:.4g}, "
            f"must be in {worst.low:.4g} .. {worst.high:.4g}"
        )
