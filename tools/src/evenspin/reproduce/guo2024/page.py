"""The report of `evenspin demo`: pictures of one set with all methods, and the tables."""

from __future__ import annotations

from evenspin.report.figures import Curve, pictures
from evenspin.report.page import Page
from evenspin.reproduce.guo2024.result import Result
from evenspin.reproduce.guo2024.tables import tables_of

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
