"""The report of `evenspin reproduce tang2020 --out DIR`."""

from __future__ import annotations

from dataclasses import replace

from evenspin.native import tables
from evenspin.report.page import Page
from evenspin.reproduce.paper_page import pictures_of as pictures_of_paper
from evenspin.reproduce.paper_page import table_of
from evenspin.reproduce.tang2020.conditions import beyond_drive
from evenspin.reproduce.tang2020.figures import GALLERY
from evenspin.reproduce.tang2020.pictures import pictures_of
from evenspin.reproduce.tang2020.result import Result
from evenspin.reproduce.tang2020.tables import tables_of

SUMMARY = (
    "A 1.5 kW servo drive with cogging, inverter harmonics, a misaligned coupling or faulty current sensors. "
    "An observer measures the disturbance torque from the 17-bit encoder, remembers it over the rotor angle and "
    "subtracts it (ARO). The drive firmware is the one that runs on the chip; motor, inverter and sensors are "
    "simulated. Off is the same drive with its speed controller alone."
)


def whole_page(result: Result, command: str) -> Page:
    """The figures of the paper, then every method."""
    page = page_of(result, command)
    figures = pictures_of_paper(GALLERY.figures, result)
    return replace(
        page,
        tables=[table_of(GALLERY, GALLERY.figures, result), *page.tables],
        pictures=[*figures, *page.pictures],
    )


def page_of(result: Result, command: str) -> Page:
    params = tables().params
    beyond = ", ".join(f"{name} = {params[name].to_text(value)}" for name, value in beyond_drive().items())
    facts = (
        ("paper", "Tang et al. 2020, IEEE Transactions on Industrial Electronics 67"),
        ("numbers", "docs/reference/tang2020.md"),
        ("ARO, beyond", beyond),
        ("numeric", result.numeric),
        ("verdict", "every required check passed" if result.passed else "a required check FAILED, see below"),
    )
    return Page(
        title="Torque-ripple observers: DOB, RO, ARO",
        summary=SUMMARY,
        facts=facts,
        tables=tables_of(result),
        pictures=pictures_of(result),
        command=command,
    )
