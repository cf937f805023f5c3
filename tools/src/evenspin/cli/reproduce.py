"""`evenspin reproduce`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from evenspin.cli.options import Force, JsonFile
from evenspin.cli.origin import origin
from evenspin.cli.output import check_json_file, console, write_json

if TYPE_CHECKING:
    from evenspin.report.page import Page
    from evenspin.reproduce.check import Check
    from evenspin.reproduce.paper import Figure, Gallery
    from evenspin.sim.many import Progress
    from evenspin.tableview import TableView


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
        list[str] | None,
        typer.Option(metavar="N", help="Only this figure of the paper, such as 9 or 9a, into --out; may be repeated."),
    ] = None,
    page: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write every figure with ours, the paper's and the verdict as a page .md; with --sweep all speeds.",
        ),
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
    if paper is not Paper.GUO2024:
        _refuse(paper, {"--set": ", ".join(set_ or ())})
    if paper is not Paper.TANG2020:
        _refuse(paper, {"--sweep": sweep})
    if sweep and page is not None:
        both = "" if numeric is Numerics.FLOAT else numeric.value
        others: dict[str, object] = {
            "--figure": figure,
            "--numeric": both,
            "--json": json_file,
            "--method": method,
            "--out": out,
        }
        _refuse_beside("--sweep --page", others)
        _speeds(page)
        return
    work = _work(paper, method, set_, sweep)
    if figure or page is not None:
        option = "--figure" if figure else "--page"
        both = numeric.value if numeric is Numerics.BOTH else ""
        whole = {
            "--numeric": both,
            "--set": ", ".join(set_ or ()),
            "--sweep": sweep,
            "--json": json_file,
            "--method": method,
        }
        _refuse_beside(option, {**whole, "--page": page if figure else None, "--out": None if figure else out})
        _figures(work, figure, builds[0], out, force, page)
    else:
        _whole(work, builds, out, force, json_file)


@dataclass(frozen=True, slots=True)
class _Work:
    """One paper. `run`: everything for a build (with records when asked for); `gather`: what these figures need."""

    paper: Paper
    title: str
    text: str
    run: Callable[[str, bool, Progress], Any]
    tables: Callable[[Any], Sequence[TableView]]
    page: Callable[[Any, str], Page]
    gallery: Gallery[Any]
    gather: Callable[[Sequence[Figure[Any]], str, Progress], Any]


def _work(paper: Paper, method: Sequence[str] | None, set_: Sequence[Set] | None, sweep: bool) -> _Work:
    if paper is Paper.GUO2024:
        from evenspin.reproduce import guo2024
        from evenspin.reproduce.guo2024 import figures as guo_figures
        from evenspin.reproduce.guo2024.page import whole_page
        from evenspin.reproduce.guo2024.tables import tables_of as guo_tables

        methods = _chosen(method, guo2024.METHODS)
        sets = [each for each in guo2024.SETS if not set_ or each in set_]
        return _Work(
            paper,
            "Guo et al. 2024, figure by figure",
            "fal-FORC against speed ripple.",
            lambda build, _, progress: guo2024.reproduce(build, methods, sets, progress),
            guo_tables,
            whole_page,
            guo_figures.GALLERY,
            guo_figures.gather,
        )
    if paper is Paper.TANG2020:
        from evenspin.reproduce import tang2020
        from evenspin.reproduce.tang2020 import figures as tang_figures
        from evenspin.reproduce.tang2020.page import whole_page as tang_page
        from evenspin.reproduce.tang2020.tables import tables_of as tang_tables

        methods = _chosen(method, tang2020.METHODS)
        return _Work(
            paper,
            "Tang et al. 2020, figure by figure",
            "Observers of the torque ripple.",
            lambda build, keep, progress: tang2020.reproduce(
                build, methods, sweep=sweep, keep_records=keep, progress=progress
            ),
            tang_tables,
            tang_page,
            tang_figures.GALLERY,
            tang_figures.gather,
        )
    from evenspin.reproduce import yeh2024
    from evenspin.reproduce.yeh2024 import figures as yeh_figures
    from evenspin.reproduce.yeh2024.page import whole_page as yeh_page
    from evenspin.reproduce.yeh2024.tables import tables_of as yeh_tables

    methods = _chosen(method, yeh2024.METHODS)
    return _Work(
        paper,
        "Yeh and Liu 2024, figure by figure",
        "Robust driving control of a position drive.",
        lambda build, _, progress: yeh2024.reproduce(build, methods, progress),
        yeh_tables,
        yeh_page,
        yeh_figures.GALLERY,
        yeh_figures.gather,
    )


def _figures(
    work: _Work, numbers: Sequence[str] | None, build: str, out: Path | None, force: bool, page: Path | None
) -> None:
    """These figures as a report, or all of them as a page."""
    from evenspin.errors import InputError
    from evenspin.output import OutputFolder
    from evenspin.report.page import write_page
    from evenspin.reproduce.paper_page import check_markdown, figure_page, write_markdown
    from evenspin.sim.progress import progress_bar

    gallery = work.gallery
    chosen = [figure for number in numbers or () for figure in gallery.find(number)]
    chosen = [figure for figure in gallery.figures if figure in chosen or not numbers]
    made, output = origin(), None
    if page is not None:
        check_markdown(page)
    elif out is None:
        raise InputError("reproduce", "--out", "", "a folder for the figures", "add --out DIR")
    else:
        output = OutputFolder(out, made, force=force)
    with progress_bar(work.paper.value, 1.0) as bar:
        result = work.gather(chosen, build, bar.update)
    if page is not None:
        write_markdown(page, gallery, result, work.title, work.text)
    elif output is not None:
        with output as folder:
            write_page(folder, figure_page(gallery, chosen, result, work.title, made.command))
    console().print(str(page) if page is not None else f"{out}/report.html", style="bold")


def _speeds(page: Path) -> None:
    """tang2020: the page of all speeds, in both builds."""
    from evenspin.reproduce.paper_page import check_markdown
    from evenspin.reproduce.tang2020.speeds import speeds_page
    from evenspin.sim.progress import progress_bar

    check_markdown(page)
    with progress_bar("tang2020, speeds", 1.0) as bar:
        speeds_page(page, bar.update)
    console().print(str(page), style="bold")


def _whole(work: _Work, builds: Sequence[str], out: Path | None, force: bool, json_file: str | None) -> None:
    """Tables, and the report of all that was run."""
    from evenspin.log.case import write_json as write_file
    from evenspin.output import OutputFolder
    from evenspin.report.page import write_page
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    made = origin()
    output = OutputFolder(out, made, force=force) if out is not None else None
    results: list[Any] = []
    for build in builds:
        with progress_bar(f"{work.paper.value}, {build}", 1.0) as bar:
            results.append(work.run(build, output is not None and not results, bar.update))
    screen = console(json_file)
    for result in results:
        for view in work.tables(result):
            print_table(view, screen)
    if output is not None:
        with output as folder:
            write_file(folder / "results.json", results[0].as_json())
            write_page(folder, work.page(results[0], made.command))
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


def _refuse_beside(option: str, others: dict[str, object]) -> None:
    """What belongs to a run of the whole paper has no effect on its figures."""
    from evenspin.errors import InputError

    for name, value in others.items():
        if value:
            shown = ", ".join(value) if isinstance(value, list) else value
            raise InputError("reproduce", name, shown, f"left out with {option}", "the figures choose what they need")


def _judge(checks: Sequence[Check]) -> None:
    from evenspin.errors import CheckFailedError

    failed = [check for check in checks if check.required and not check.passed]
    if failed:
        worst = failed[0]
        raise CheckFailedError(
            f"{len(failed)} required checks failed, first: {worst.what} = {worst.value:.4g}, "
            f"must be in {worst.low:.4g} .. {worst.high:.4g}"
        )
