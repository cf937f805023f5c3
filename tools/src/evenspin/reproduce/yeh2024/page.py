"""The report of `evenspin reproduce yeh2024 --out`."""

from __future__ import annotations

from dataclasses import replace

from evenspin.report.page import Page
from evenspin.reproduce.paper_page import pictures_of, table_of
from evenspin.reproduce.yeh2024.figures import GALLERY
from evenspin.reproduce.yeh2024.pictures import NAMES, pictures
from evenspin.reproduce.yeh2024.result import Result
from evenspin.reproduce.yeh2024.tables import tables_of

SUMMARY = (
    "A rotary axis with friction and a torque tied to its angle turns ten times. P-PI alone lags behind its command "
    "and ripples; spatial learning (SILC, SRC) removes the ripple, not the lag. Robust driving control (RDC) feeds the "
    "whole machine forward and removes both from the first turn on. The drive firmware is the one that runs on the "
    "chip; motor, friction, encoder and disturbance are simulated."
)


def whole_page(result: Result, command: str) -> Page:
    """Every method, with what the paper shows in its figures; those of the identification."""
    page = page_of(result, command)
    identified = pictures_of(GALLERY.figures[:1], result)
    return replace(
        page,
        tables=[table_of(GALLERY, GALLERY.figures, result), *page.tables],
        pictures=[*page.pictures, *identified],
    )


def page_of(result: Result, command: str) -> Page:
    methods = [name for method, name in NAMES.items() if any(run.method == method for run in result.runs)]
    effects = [
        f"{name} ({', '.join(f'{param} = {value:g}' for param, value in params.items())})"
        for name, params in result.runs[0].setup.effects.items()
    ]
    facts = (
        ("paper", "Yeh and Liu 2024, Machines 12(11), 771, https://doi.org/10.3390/machines12110771"),
        ("motion", "10 turns from rest at 10, 15 and 20 rpm, then hold"),
        ("methods", ", ".join(methods)),
        ("effects", "; ".join(effects)),
        ("numeric", result.numeric),
        ("verdict", "every required check passed" if result.passed else "a required check FAILED, see below"),
    )
    return Page(
        title="Precise positions: P-PI, SILC, SRC and RDC",
        summary=SUMMARY,
        facts=facts,
        tables=tables_of(result),
        pictures=pictures(result),
        command=command,
    )
