"""A short tour through the reproductions: what `evenspin demo` runs and shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from evenspin.report.figures import Picture
from evenspin.report.page import Chapter, Page
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
    """One paper of the tour. `what`: for the person who waits; `title`: what one learns."""

    name: str
    title: str
    first: str  # the picture that says most
    what: str
    run: Callable[[Progress], Any]
    page: Callable[[Any, str], Page]
    tables: Callable[[Any], Sequence[TableView]]


PARTS = (
    Part(
        "guo2024",
        "Faulty current sensors, and repetitive control that removes their ripple",
        "orders",
        "repetitive control: 32 s with four methods",
        lambda progress: guo2024.reproduce(sets=(GUO_SET,), progress=progress),
        lambda result, command: guo_page(result, GUO_SET, command),
        guo_tables,
    ),
    Part(
        "tang2020",
        "Torque tied to the angle, and an observer that learns it once for all speeds",
        "spectrum",
        "torque observers: ten minutes of learning",
        lambda progress: tang2020.reproduce(
            methods=TANG_METHODS, conditions=TANG_CONDITIONS, keep_records=True, progress=progress
        ),
        tang_page,
        tang_tables,
    ),
    Part(
        "yeh2024",
        "A position drive that feeds the whole machine forward",
        "rms",
        "position control: ten turns with five methods",
        lambda progress: yeh2024.reproduce(progress=progress),
        yeh_page,
        yeh_tables,
    ),
)


def run(part: Part, progress: Progress) -> Any:
    """The result of a part."""
    return part.run(progress)


SUMMARY = (
    "The drive firmware is the one that runs on the chip; motor, inverter and sensors are simulated. One chapter for "
    "each paper: what it is about, its most telling picture first, then the others, and all numbers in tables. What is "
    "called beyond goes further than the paper does."
)


def page_of(results: Mapping[str, Any], command: str) -> Page:
    """One report, a chapter for each part; pictures carry the name of their part."""
    pages = {part: part.page(results[part.name], command) for part in PARTS}
    return Page(
        title="evenspin: what each method does",
        summary=SUMMARY,
        facts=[(part.title, _verdict(results[part.name])) for part in PARTS],
        tables=(),
        pictures=(),
        command=command,
        chapters=[Chapter(part.title, page.summary, _parts(part, page)) for part, page in pages.items()],
    )


def _parts(part: Part, page: Page) -> list[TableView | Picture]:
    """Pictures, the most telling one first, then what was run and the tables."""
    drawn = sorted(page.pictures, key=lambda picture: picture.name != part.first)
    named: list[TableView | Picture] = [replace(picture, name=f"{part.name}_{picture.name}") for picture in drawn]
    facts = TableView(f"{part.name}: what was run", "", ("", ""), [tuple(fact) for fact in page.facts])
    return [*named, facts, *(replace(table, title=f"{part.name}: {table.title}") for table in page.tables)]


def _verdict(result: Any) -> str:
    return "every required check passed" if result.passed else "a required check FAILED, see its table"
