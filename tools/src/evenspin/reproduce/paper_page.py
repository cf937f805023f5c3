"""Reports and pages of the figures of a paper: picture, command, ours, theirs, verdict."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from evenspin.errors import InputError
from evenspin.report.figures import Picture
from evenspin.report.page import Page
from evenspin.reproduce.paper import Figure, Gallery, R
from evenspin.tableview import TableView

HEADER = ("figure", "what", "ours", "paper", "verdict")
RULE = (
    "A number holds when it is within a fifth of the printed one, or between the printed simulation and experiment "
    "(simulation / experiment); a reduction in %, when it is within 5 points."
)
MARK = "<!-- Made by `evenspin reproduce"


def pictures_of(figures: Sequence[Figure[R]], result: R) -> list[Picture]:
    """Those for which there are runs, under their numbers."""
    drawn = [(figure, figure.draw(result)) for figure in figures]
    return [_titled(figure, picture) for figure, picture in drawn if picture is not None]


def _titled(figure: Figure[R], picture: Picture) -> Picture:
    return replace(picture, name=figure.name, title=f"{figure.label}: {picture.title}")


def table_of(gallery: Gallery[R], figures: Sequence[Figure[R]], result: R) -> TableView:
    """What the paper prints or says in these figures, and what is found here."""
    rows: list[tuple[str, ...]] = []
    marks = []
    for figure in figures:
        for each in figure.says(result):
            rows.append((", ".join(figure.numbers), each.what, each.ours, each.theirs, each.verdict))
            marks.append("good" if each.holds else "bad")
    return TableView(f"Figures of {gallery.paper}", RULE, HEADER, rows, marks)


def figure_page(gallery: Gallery[R], figures: Sequence[Figure[R]], result: R, title: str, command: str) -> Page:
    """A report of these figures alone."""
    names = ", ".join(number for figure in figures for number in figure.numbers)
    return Page(
        title=title,
        summary="Ours beside what the paper prints or says in these figures.",
        facts=(("figures", names),),
        tables=[table_of(gallery, figures, result)],
        pictures=pictures_of(figures, result),
        command=command,
    )


def check_markdown(path: Path) -> None:
    """Refuse a place before any work is done: only a new file, or a page that was made like this."""
    if path.suffix != ".md" or path.is_dir() or not path.parent.is_dir():
        raise InputError("reproduce", "--page", str(path), "a file .md in an existing folder", "choose another place")
    if path.exists() and MARK not in path.read_text(encoding="utf-8", errors="replace"):
        raise InputError(
            "reproduce", "--page", str(path), "new, or a page made by this command", "choose another place"
        )


def write_markdown(path: Path, gallery: Gallery[R], result: R, title: str, text: str) -> None:
    """PATH, and its pictures in a folder of the same name beside it."""
    check_markdown(path)
    folder = path.with_suffix("")
    folder.mkdir(exist_ok=True)
    for old in folder.glob("figure_*.svg"):
        old.unlink()
    drawn = {picture.name: picture for picture in pictures_of(gallery.figures, result)}
    for name, picture in drawn.items():
        (folder / f"{name}.svg").write_text(_short(picture.svg), encoding="utf-8")
    path.write_text(_markdown(gallery, result, drawn, folder.name, title, text), encoding="utf-8")


def _markdown(gallery: Gallery[R], result: R, drawn: dict[str, Picture], folder: str, title: str, text: str) -> str:
    paper = gallery.paper
    statements = [each for figure in gallery.figures for each in figure.says(result)]
    held = sum(each.holds for each in statements)
    lines = [
        f"# {title}",
        "",
        f"{MARK} {paper} --page` (`make figures`). Do not edit. -->",
        "",
        f"{text} Every figure that shows data, drawn from the firmware on the simulated machine, with the paper's "
        f"numbers in it. {RULE} Of {len(statements)} {held} hold; what differs has its reason beside it. "
        f"More on each: [{paper}.md]({paper}.md).",
        "",
    ]
    for figure in gallery.figures:
        option = " ".join(f"--figure {number}" for number in figure.numbers[:1])
        lines += [f"## {figure.label}: {figure.title}", ""]
        lines += ["```sh", f"evenspin reproduce {paper} {option} --out out/{figure.name}", "```", ""]
        picture = drawn.get(figure.name)
        if picture is not None:
            lines += [f"![{figure.title}]({folder}/{figure.name}.svg)", "", picture.text, ""]
        found = figure.says(result)
        if found:
            lines += ["| what | ours | paper | verdict |", "|---|---|---|---|"]
            lines += [f"| {_cell(e.what)} | {_cell(e.ours)} | {_cell(e.theirs)} | {_cell(e.verdict)} |" for e in found]
            lines += [""]
    lines += ["## Figures without data", "", "| figure | what it is |", "|---|---|"]
    lines += [f"| {number} | {what} |" for number, what in gallery.no_data.items()]
    return "\n".join([*lines, ""])


def _cell(text: str) -> str:
    """A bar would end the cell."""
    return text.replace("|", "\\|")


def _short(svg: str) -> str:
    """Paths with one decimal, finer than a screen of that width; texts stay as they are."""
    return re.sub(r' d="[^"]*"', lambda path: re.sub(r"(\d\.\d)\d+", r"\1", path[0]), svg)
