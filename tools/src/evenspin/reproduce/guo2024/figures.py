"""All figures of the paper: which command draws each, and what it shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from evenspin.report.figures import Picture
from evenspin.report.style import drawing
from evenspin.reproduce.guo2024 import design_figures, run_figures, statements
from evenspin.reproduce.guo2024.result import runs_of
from evenspin.reproduce.guo2024.run_figures import Runs
from evenspin.reproduce.paper import Figure, Gallery
from evenspin.sim.many import Progress

FIRST, SECOND, THIRD = ("first",), ("second",), ("third",)
METHODS = ("pi", "crc", "forc", "fal-forc")  # of the paper; what goes beyond it is in no figure
BLOCKS, BENCH = "block diagram", "photograph"


def _calculated(draw: Callable[[], Picture]) -> Callable[[Runs], Picture]:
    def within(_: Runs) -> Picture:
        with drawing():
            return draw()

    return within


GALLERY: Gallery[Runs] = Gallery(
    "guo2024",
    (
        Figure(("3", "4", "10"), "Gain of CRC and FORC", _calculated(design_figures.combs), statements.combs),
        Figure(("7", "8"), "Fractional delay", _calculated(design_figures.delays), statements.delays),
        Figure(("12", "13", "14"), "fal", _calculated(design_figures.fal_curves), statements.fal_curves),
        Figure(("16",), "z^m M", _calculated(design_figures.phase), statements.phase),
        Figure(
            ("17", "18", "23"),
            "Speed and q current, 150 to 295 rpm",
            lambda runs: run_figures.responses(runs, "first", "figure_17_18_23", "Speed and q current, 150 to 295 rpm"),
            statements.first_set,
            FIRST,
        ),
        Figure(
            ("19", "30"),
            "FORC and fal-FORC, 150 to 295 rpm",
            lambda runs: run_figures.overshoots(
                runs, "first", 150.0, "figure_19_30", "FORC and fal-FORC, 150 to 295 rpm"
            ),
            lambda runs: statements.overshoot(runs, 150.0),
            FIRST,
        ),
        Figure(("21",), "Phase lead at 300 rpm", _calculated(design_figures.leads_picture), statements.lead),
        Figure(("22",), "Learning gain at 300 rpm", _calculated(design_figures.gains_picture), statements.gain),
        Figure(
            ("24", "25", "26", "27"),
            "Spectrum of the speed at 150, 203, 255 and 295 rpm",
            run_figures.spectra,
            statements.spectra,
            FIRST,
        ),
        Figure(
            ("28",),
            "Speed and q current, 300 to 488 rpm",
            lambda runs: run_figures.responses(runs, "second", "figure_28", "Speed and q current, 300 to 488 rpm"),
            statements.second_set,
            SECOND,
        ),
        Figure(("29",), "900 and 1200 rpm", run_figures.fast, statements.third_set, THIRD),
        Figure(
            ("31",),
            "FORC and fal-FORC, 300 to 488 rpm",
            lambda runs: run_figures.overshoots(
                runs, "second", 300.0, "figure_31", "FORC and fal-FORC, 300 to 488 rpm"
            ),
            lambda runs: statements.overshoot(runs, 300.0),
            SECOND,
        ),
    ),
    {**dict.fromkeys(("1", "2", "5", "6", "9", "11", "15"), BLOCKS), "20": BENCH},
)


def gather(figures: Sequence[Figure[Runs]], numeric: str, progress: Progress) -> Runs:
    """The runs that these figures need."""
    sets = list(dict.fromkeys(name for figure in figures for name in figure.needs))
    return runs_of(sets, METHODS, numeric, progress) if sets else []
