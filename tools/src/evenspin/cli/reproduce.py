"""`evenspin reproduce`."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from evenspin.cli.options import Force, JsonFile
from evenspin.cli.origin import origin
from evenspin.cli.output import check_json_file, console, write_json

if TYPE_CHECKING:
    from evenspin.reproduce.check import Check


class Paper(StrEnum):
    GUO2024 = "guo2024"
    TANG2020 = "tang2020"
    YEH2024 = "yeh2024"


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
    paper: Annotated[
        Paper,
        typer.Argument(
            help="guo2024: fal-FORC in the speed loop. tang2020: torque observers DOB, RO, ARO. "
            "yeh2024: position control P-PI, SILC, SRC, RDC."
        ),
    ],
    method: Annotated[
        list[str] | None, typer.Option(metavar="METHOD", help="Only these methods of the paper; may be repeated.")
    ] = None,
    set_: Annotated[
        list[Set] | None,
        typer.Option("--set", help="guo2024: only these scenarios, 150-295, 300-488 or 900-1200 rpm; may be repeated."),
    ] = None,
    numeric: Annotated[
        Numerics, typer.Option(help="Build of the firmware; fixed is compared with float, in percentage points.")
    ] = Numerics.FLOAT,
    sweep: Annotated[
        bool, typer.Option("--sweep", help="tang2020: also 50 to 2500 rpm; no speed may be worse than without.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder for report.html, pictures and their numbers."),
    ] = None,
    figure: Annotated[
        list[int] | None,
        typer.Option(metavar="N", help="guo2024: only this figure of the paper, into --out; may be repeated."),
    ] = None,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Run the scenarios of a paper and compare: ours, its simulation, its experiment, the target band.

    Ripple in % of the mean, speeds in rpm. Exit status 1 when a required band is missed.

    Example: `evenspin reproduce guo2024 --json out/guo2024.json`
    """
    check_json_file(json_file)
    builds = ("float", "fixed") if numeric is Numerics.BOTH else (numeric.value,)
    if paper is Paper.TANG2020:
        _refuse(paper, {"--set": ", ".join(set_ or ()), "--figure": figure})
        _tang2020(method, builds, sweep, out, force, json_file)
    elif paper is Paper.YEH2024:
        _refuse(paper, {"--set": ", ".join(set_ or ()), "--sweep": sweep, "--figure": figure})
        _yeh2024(method, builds, out, force, json_file)
    else:
        _refuse(paper, {"--sweep": sweep})
        if figure:
            _guo2024_figures(figure, method, builds[0], out, force)
        else:
            _guo2024(method, set_, builds, out, force, json_file)


def _guo2024_figures(
    numbers: Sequence[int], method: Sequence[str] | None, build: str, out: Path | None, force: bool
) -> None:
    from evenspin.errors import InputError
    from evenspin.output import OutputFolder
    from evenspin.report.page import write_page
    from evenspin.reproduce.guo2024 import METHODS
    from evenspin.reproduce.guo2024.figures import FIGURES, find
    from evenspin.reproduce.guo2024.page import figure_page
    from evenspin.reproduce.guo2024.result import runs_of
    from evenspin.sim.progress import progress_bar

    known = sorted(number for figure in FIGURES for number in figure.numbers)
    chosen = []
    for number in numbers:
        found = find(number)
        if found is None:
            allowed = ", ".join(map(str, known))
            raise InputError("reproduce", "--figure", number, f"one of {allowed}", "the others are diagrams")
        if found not in chosen:
            chosen.append(found)
    if out is None:
        raise InputError("reproduce", "--out", "", "a folder for the figures", "add --out DIR")
    made = origin()
    output = OutputFolder(out, made, force=force)
    sets = list(dict.fromkeys(figure.set_name for figure in chosen if figure.set_name))
    with progress_bar("guo2024", 1.0) as bar:
        runs = runs_of(sets, _chosen(method, METHODS), build, bar.update) if sets else []
    with output as folder:
        write_page(folder, figure_page(chosen, runs, made.command))
    console().print(f"{out}/report.html", style="bold")


def _guo2024(
    method: Sequence[str] | None,
    set_: Sequence[Set] | None,
    builds: Sequence[str],
    out: Path | None,
    force: bool,
    json_file: str | None,
) -> None:
    from evenspin.log.case import write_json as write_file
    from evenspin.output import OutputFolder
    from evenspin.report.page import write_page
    from evenspin.reproduce.guo2024 import METHODS, SETS
    from evenspin.reproduce.guo2024 import reproduce as run_all
    from evenspin.reproduce.guo2024.page import whole_page
    from evenspin.reproduce.guo2024.tables import tables_of
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    methods = _chosen(method, METHODS)
    sets = [each for each in SETS if not set_ or each in set_]
    made = origin()
    output = OutputFolder(out, made, force=force) if out is not None else None
    results = []
    for build in builds:
        with progress_bar(f"guo2024, {build}", 1.0) as bar:
            results.append(run_all(build, methods, sets, bar.update))
    screen = console(json_file)
    for result in results:
        for view in tables_of(result):
            print_table(view, screen)
    if output is not None:
        with output as folder:
            write_file(folder / "results.json", results[0].as_json())
            write_page(folder, whole_page(results[0], made.command))
        screen.print(f"{out}/report.html", style="bold")
    if json_file is not None:
        content = results[0].as_json()
        if len(results) > 1:
            content |= {"fixed": results[1].as_json(), "passed": all(result.passed for result in results)}
        write_json(content, json_file)
    _judge([check for result in results for check in result.checks])


def _tang2020(
    method: Sequence[str] | None,
    builds: Sequence[str],
    sweep: bool,
    out: Path | None,
    force: bool,
    json_file: str | None,
) -> None:
    from evenspin.log.case import write_json as write_file
    from evenspin.output import OutputFolder
    from evenspin.report.page import write_page
    from evenspin.reproduce.tang2020 import METHODS, Result
    from evenspin.reproduce.tang2020 import reproduce as run_all
    from evenspin.reproduce.tang2020.page import page_of
    from evenspin.reproduce.tang2020.tables import tables_of
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    methods = _chosen(method, METHODS)
    made = origin()
    output = OutputFolder(out, made, force=force) if out is not None else None
    results: list[Result] = []
    for build in builds:
        with progress_bar(f"tang2020, {build}", 1.0) as bar:
            keep = output is not None and not results
            results.append(run_all(build, methods, sweep=sweep, keep_records=keep, progress=bar.update))
    screen = console(json_file)
    for result in results:
        for view in tables_of(result):
            print_table(view, screen)
    if output is not None:
        with output as folder:
            write_file(folder / "results.json", results[0].as_json())
            write_page(folder, page_of(results[0], made.command))
        screen.print(f"{out}/report.html", style="bold")
    if json_file is not None:
        content = results[0].as_json()
        if len(results) > 1:
            content |= {"fixed": results[1].as_json(), "passed": all(result.passed for result in results)}
        write_json(content, json_file)
    _judge([check for result in results for check in result.checks])


def _yeh2024(
    method: Sequence[str] | None, builds: Sequence[str], out: Path | None, force: bool, json_file: str | None
) -> None:
    from evenspin.log.case import write_json as write_file
    from evenspin.output import OutputFolder
    from evenspin.report.page import write_page
    from evenspin.reproduce.yeh2024 import METHODS
    from evenspin.reproduce.yeh2024 import reproduce as run_all
    from evenspin.reproduce.yeh2024.page import page_of
    from evenspin.reproduce.yeh2024.tables import tables_of
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    methods = _chosen(method, METHODS)
    made = origin()
    output = OutputFolder(out, made, force=force) if out is not None else None
    results = []
    for build in builds:
        with progress_bar(f"yeh2024, {build}", 1.0) as bar:
            results.append(run_all(build, methods, bar.update))
    screen = console(json_file)
    for result in results:
        for view in tables_of(result):
            print_table(view, screen)
    if output is not None:
        with output as folder:
            write_file(folder / "results.json", results[0].as_json())
            write_page(folder, page_of(results[0], made.command))
        screen.print(f"{out}/report.html", style="bold")
    if json_file is not None:
        content = results[0].as_json()
        if len(results) > 1:
            content |= {"fixed": results[1].as_json(), "passed": all(result.passed for result in results)}
        write_json(content, json_file)
    _judge([check for result in results for check in result.checks])


def _chosen(given: Sequence[str] | None, known: Sequence[str]) -> list[str]:
    """The methods of this paper that were asked for, in its order."""
    from evenspin.errors import InputError, did_you_mean

    for each in given or ():
        if each not in known:
            raise InputError("reproduce", "--method", each, "a method of this paper", did_you_mean(each, known))
    return [each for each in known if not given or each in given]


def _refuse(paper: Paper, options: dict[str, object]) -> None:
    from evenspin.errors import InputError

    for name, value in options.items():
        if value:
            raise InputError("reproduce", name, value, f"left out with {paper.value}", "it is for another paper")


def _judge(checks: Sequence[Check]) -> None:
    from evenspin.errors import CheckFailedError

    failed = [check for check in checks if check.required and not check.passed]
    if failed:
        worst = failed[0]
        raise CheckFailedError(
            f"{len(failed)} required checks failed, first: {worst.what} = {worst.value:.4g}, "
            f"must be in {worst.low:.4g} .. {worst.high:.4g}"
        )
