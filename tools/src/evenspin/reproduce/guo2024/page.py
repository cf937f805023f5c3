"""Reports: of one set for `evenspin demo`, and of all sets with the figures of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from evenspin.report.figures import Curve, Picture, pictures
from evenspin.report.page import Page
from evenspin.reproduce.guo2024.figures import GALLERY
from evenspin.reproduce.guo2024.result import Result, Run
from evenspin.reproduce.guo2024.tables import tables_of
from evenspin.reproduce.paper_page import pictures_of, table_of

SUMMARY = (
    "A 24 V servo drive with faulty current sensors runs through four speeds, with a load step at each. "
    "The drive firmware is the one that runs on the chip; motor, inverter and sensors are simulated. "
    "PI alone leaves a ripple of the first and second electrical order. Repetitive control removes it: "
    "CRC only where the period is a whole number of samples, FORC at every speed, and fal-FORC does so without "
    "the overshoot at the start."
)


def page_of(result: Result, set_name: str, command: str) -> Page:
    runs = [run for run in result.runs if run.set_name == set_name]
    setup = runs[0].setup
    effects = [
        f"{name} ({', '.join(f'{param} = {value:g}' for param, value in params.items())})"
        for name, params in setup.effects.items()
    ]
    facts = (
        ("paper", "Guo et al. 2024, Actuators 13(2), 73, https://doi.org/10.3390/act13020073"),
        ("scenario", f"{setup.name}, {setup.duration_s:g} s"),
        ("methods", ", ".join(run.method for run in runs)),
        ("effects", "; ".join(effects)),
        ("numeric", result.numeric),
        ("verdict", "every required check passed" if result.passed else "a required check FAILED, see below"),
    )
    return Page(
        title="Even running: PI, CRC, FORC and fal-FORC",
        summary=SUMMARY,
        facts=facts,
        tables=tables_of(result),
        pictures=pictures(setup, [Curve(run.method, run.record) for run in runs]),
        command=command,
    )


def whole_page(result: Result, command: str) -> Page:
    """The figures of the paper, then every set that was run with all of its methods."""
    first = page_of(result, result.runs[0].set_name, command)
    tables = [table_of(GALLERY, GALLERY.figures, result.runs), *first.tables]
    return replace(
        first, tables=tables, pictures=[*pictures_of(GALLERY.figures, result.runs), *set_pictures(result.runs)]
    )


def set_pictures(runs: Sequence[Run]) -> list[Picture]:
    """The pictures of each set, under its name."""
    found: list[Picture] = []
    for name in dict.fromkeys(run.set_name for run in runs):
        of_set = [run for run in runs if run.set_name == name]
        for picture in pictures(of_set[0].setup, [Curve(run.method, run.record) for run in of_set]):
            title = f"{picture.title}, {name} set, all methods"
            found.append(replace(picture, name=f"{name}_{picture.name}", title=title))
    return found
