"""A short tour through the reproductions: what `evenspin demo` runs and shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from evenspin.report.page import Page
from evenspin.reproduce import guo2024, tang2020, yeh2024
from evenspin.reproduce.guo2024.page import page_of as guo_page
from evenspin.reproduce.guo2024.tables import tables_of as guo_tables
from evenspin.reproduce.tang2020.page import page_of as tang_page
from evenspin.reproduce.tang2020.tables import tables_of as tang_tables
from evenspin.reproduce.yeh2024.page import page_of as yeh_page
from evenspin.reproduce.yeh2024.tables import tables_of as yeh_tables
from evenspin.sim.many import Progress
from evenspin.tableview import TableView

GUO_SET = "first"
TANG_CONDITIONS = ("100 rpm", "451 rpm", "load step", "speed step")
TANG_METHODS = ("aro", "aro-beyond")


@dataclass(frozen=True, slots=True)
class Part:
    """One paper of the tour. `what`: for the person who waits."""

    name: str
    what: str
    run: Callable[[Progress], Any]
    page: Callable[[Any, str], Page]
    tables: Callable[[Any], Sequence[TableView]]


PARTS = (
    Part(
        "guo2024",
        "repetitive control: 32 s with four methods",
        lambda progress: guo2024.reproduce(sets=(GUO_SET,), progress=progress),
        lambda result, command: guo_page(result, GUO_SET, command),
        guo_tables,
    ),
    Part(
        "tang2020",
        "torque observers: ten minutes of learning",
        lambda progress: tang2020.reproduce(
            methods=TANG_METHODS, conditions=TANG_CONDITIONS, keep_records=True, progress=progress
        ),
        tang_page,
        tang_tables,
    ),
    Part(
        "yeh2024",
        "position control: ten turns with five methods",
        lambda progress: yeh2024.reproduce(progress=progress),
        yeh_page,
        yeh_tables,
    ),
)


def run(part: Part, progress: Progress) -> Any:
    """The result of a part."""
    return part.run(progress)


def page_of(results: Mapping[str, Any], command: str) -> Page:
    """One report of all parts; pictures carry the name of their part."""
    pages = {part.name: part.page(results[part.name], command) for part in PARTS}
    return Page(
        title="evenspin: what each method does",
        summary=" ".join(page.summary for page in pages.values()),
        facts=[(f"{name}, {fact}", value) for name, page in pages.items() for fact, value in page.facts],
        tables=[
            replace(table, title=f"{name}: {table.title}") for name, page in pages.items() for table in page.tables
        ],
        pictures=[
            replace(picture, name=f"{name}_{picture.name}", title=f"{name}: {picture.title}")
            for name, page in pages.items()
            for picture in page.pictures
        ],
        command=command,
    )
