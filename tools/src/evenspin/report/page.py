"""One HTML page with everything in it, and beside it every picture and its numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evenspin.log.csvfile import write_csv
from evenspin.report.figures import Picture
from evenspin.tableview import TableView

HERE = Path(__file__).parent
TEMPLATE = HERE / "page.html.j2"
UPLOT = HERE.parent / "scope" / "static" / "vendor"  # the one copy of it, with its licence


@dataclass(frozen=True, slots=True)
class Script:
    """What draws the pictures of a page again so that they can be zoomed. It goes into the page, which needs nothing
    from elsewhere."""

    style: str
    library: str
    charts: str

    @classmethod
    def read(cls) -> Script:
        licence = (UPLOT / "LICENSE-uPlot").read_text(encoding="utf-8")
        library = (UPLOT / "uPlot.iife.min.js").read_text(encoding="utf-8")
        style = (UPLOT / "uPlot.min.css").read_text(encoding="utf-8")
        return cls(style, f"/*\n{licence}*/\n{library}", (HERE / "chart.js").read_text(encoding="utf-8"))


def anchor(title: str) -> str:
    """A title as the name of a place on the page."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") or "part"


@dataclass(frozen=True, slots=True)
class Chapter:
    """A part of a report that is read as a story: tables and pictures in this order."""

    title: str
    text: str
    parts: Sequence[TableView | Picture] = ()

    def blocks(self) -> list[tuple[str, TableView | Picture]]:
        """Each part with what it is, for the template."""
        return [("picture" if isinstance(part, Picture) else "table", part) for part in self.parts]


@dataclass(frozen=True, slots=True)
class Page:
    """What a report says."""

    title: str
    summary: str
    facts: Sequence[tuple[str, str]]
    tables: Sequence[TableView]
    pictures: Sequence[Picture]
    command: str
    chapters: Sequence[Chapter] = ()

    def all_pictures(self) -> list[Picture]:
        in_chapters = [part for chapter in self.chapters for part in chapter.parts if isinstance(part, Picture)]
        return [*self.pictures, *in_chapters]

    def contents(self) -> list[tuple[str, str, bool]]:
        """What can be jumped to, in the order of the page: place, title, and whether it is a chapter."""
        parts: list[TableView | Picture] = [*self.pictures, *self.tables]
        found = [_place(part) for part in parts]
        for chapter in self.chapters:
            found += [_place(chapter), *(_place(part) for part in chapter.parts if isinstance(part, Picture))]
        return found


def _place(part: TableView | Picture | Chapter) -> tuple[str, str, bool]:
    place = part.name if isinstance(part, Picture) else anchor(part.title)
    return place, part.title, isinstance(part, Chapter)


def write_page(folder: Path, page: Page) -> None:
    """report.html, figures/NAME.svg and figures/NAME.csv."""
    from jinja2 import Environment

    figures = folder / "figures"
    figures.mkdir()
    for picture in page.all_pictures():
        (figures / f"{picture.name}.svg").write_text(_stand_alone(picture.svg), encoding="utf-8")
        _write_columns(figures / f"{picture.name}.csv", picture)
    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters["anchor"] = lambda part: anchor(part.title)
    template = environment.from_string(TEMPLATE.read_text())
    script = Script.read() if any(picture.chart for picture in page.all_pictures()) else None
    text = template.render(page=page, contents=page.contents(), script=script)
    (folder / "report.html").write_text(text, encoding="utf-8")


def _stand_alone(svg: str) -> str:
    return f'<?xml version="1.0" encoding="utf-8"?>\n{svg}'


def _write_columns(path: Path, picture: Picture) -> None:
    columns = [np.asarray(column, dtype=float) for column in picture.data.values()]
    table = np.full((max(map(len, columns)), len(columns)), np.nan)
    for index, column in enumerate(columns):
        table[: len(column), index] = column
    write_csv(path, list(picture.data), table)
