"""What goes with what: every pair of methods, run in the simulator, or refused by the drive with both names.

Speed mode: the machine of Guo et al. 2024 with its sensor errors through four speeds and load steps, with a 17-bit
encoder (an observer of the torque differentiates the angle; on 4000 counts it sees steps). Position mode: the machine
of Yeh and Liu 2024, ten turns at 20 rpm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from evenspin.analysis.segments import SIGNALS as SPEED_SIGNALS
from evenspin.errors import EvenspinError
from evenspin.model import Setup, builtin_scenario
from evenspin.native import tables
from evenspin.reproduce.guo2024.measure import rows_of
from evenspin.reproduce.yeh2024.measure import SIGNALS as POSITION_SIGNALS
from evenspin.reproduce.yeh2024.measure import turn_rms
from evenspin.sim import simulate
from evenspin.sim.many import Progress, run_all
from evenspin.tableview import TableView

ENCODER_COUNTS = 131072.0
OBSERVERS = ("none", "dob", "ro", "aro")
CURRENT = ("pi", "deadbeat")
# Name of what stands in the speed or position loop, and its drive parameters.
IN_SPEED: Mapping[str, Mapping[str, str]] = {
    "pi": {"method": "pi"},
    "crc": {"method": "crc"},
    "forc": {"method": "forc"},
    "fal-forc": {"method": "fal-forc"},
    "crc, angle": {"method": "crc", "rc_memory": "angle"},
    "forc, angle": {"method": "forc", "rc_memory": "angle"},
    "fal-forc, angle": {"method": "fal-forc", "rc_memory": "angle"},
}
IN_POSITION: Mapping[str, Mapping[str, str | float]] = {
    "ppi": {"position_method": "ppi"},
    "silc": {"position_method": "silc"},
    "src": {"position_method": "src"},
    "rdc": {"position_method": "rdc"},
    "rdc, learning": {"position_method": "rdc", "rdc_learn_gain": 0.3},
}
# An observer for a machine with a current loop of 3000 rad/s; ARO as in tang2020/beyond.
OBSERVER: Mapping[str, str | float] = {
    "observer_actuation_samples": 4.8,
    "aro_cells": 720.0,
    "aro_write": "hat",
    "aro_read": "cubic",
}
# Faster learning where ten turns are all there are.
QUICK = {"observer_gain": 0.3}
COARSE_COUNTS = 4000.0  # of the paper's own encoder
# Settings of ARO on a coarse encoder: at 150 rpm two samples fall into each of 200 cells, always at the same angles.
COARSE_ARO: Mapping[str, Mapping[str, str | float]] = {
    "200 cells, write one (as printed)": {"aro_cells": 200.0, "aro_write": "one"},
    "200 cells, write hat (default)": {"aro_cells": 200.0, "aro_write": "hat"},
    "720 cells, write hat": {},
}
DEADBEAT_ACTUATION = 2.0
RO_LEAST_RPM = 98.0  # below it a turn is longer than its memory
ACTS = 1e-6  # relative change of the figure below which a method does nothing
HARM = 1.10  # over the worse of the two alone; figures of neighbouring runs differ by some percent


@dataclass(frozen=True, slots=True)
class Pair:
    """One combination: `loop` of IN_SPEED or IN_POSITION, `observer`, `current`."""

    mode: str  # "speed", "position"
    loop: str
    observer: str
    current: str

    def drive(self) -> dict[str, float]:
        in_position = self.loop in IN_POSITION and self.mode == "position"
        loop: Mapping[str, str | float] = IN_POSITION[self.loop] if in_position else IN_SPEED[self.loop]
        words: dict[str, str | float] = {**OBSERVER, **loop, "disturbance_observer": self.observer}
        words["current_controller"] = self.current
        if self.current == "deadbeat":
            words["observer_actuation_samples"] = DEADBEAT_ACTUATION
        if self.mode == "position":
            words |= QUICK
        params = tables().params
        return {name: params[name].to_number(value) for name, value in words.items()}


@dataclass(frozen=True, slots=True)
class Answer:
    """What a pair did: `figure` is the remaining ripple (speed: % of the mean; position: mrad), nan when refused."""

    pair: Pair
    figure: float
    refusal: str = ""

    @property
    def refused(self) -> bool:
        return bool(self.refusal)


def pairs() -> list[Pair]:
    """Every one."""
    speed = [
        Pair("speed", loop, observer, current) for loop in IN_SPEED for observer in OBSERVERS for current in CURRENT
    ]
    position = [
        Pair("position", loop, observer, current)
        for loop in IN_POSITION
        for observer in OBSERVERS
        for current in CURRENT
    ]
    return [*speed, *position, *(Pair("position", loop, "none", "pi") for loop in ("crc", "forc", "fal-forc"))]


def run(chosen: Sequence[Pair], progress: Progress | None = None) -> list[Answer]:
    """Run them, in this order."""
    return run_all([_later(pair) for pair in chosen], progress)


def _later(pair: Pair) -> Callable[[], Answer]:
    return lambda: _answer(pair)


def _answer(pair: Pair) -> Answer:
    try:
        figure = _speed_figure(pair) if pair.mode == "speed" else _position_figure(pair)
    except EvenspinError as error:
        return Answer(pair, math.nan, str(error))
    return Answer(pair, figure)


def _speed_figure(pair: Pair, counts: float = ENCODER_COUNTS, words: Mapping[str, str | float] | None = None) -> float:
    """Largest ripple of first and second electrical order after the load step, over the four speeds."""
    params = tables().params
    changes = {name: params[name].to_number(value) for name, value in (words or {}).items()}
    setup = builtin_scenario("guo2024/first").with_changes({**pair.drive(), **changes, "encoder_counts": counts})
    setup = replace(setup, plant={**setup.plant, "counts_per_rev": counts})
    record = simulate(setup, (*SPEED_SIGNALS, "fault"), "float")
    need_no_fault(setup, record["fault"].max())
    rows = rows_of(setup, record, "first", pair.loop, "float")
    return max(math.hypot(row["n1_after_load_pct"], row["n2_after_load_pct"]) for row in rows)


def _position_figure(pair: Pair) -> float:
    """Rms of the error in the tenth turn without its mean, mrad."""
    setup = builtin_scenario("yeh2024/rpm20").with_changes(pair.drive())
    record = simulate(setup, POSITION_SIGNALS, "float")
    need_no_fault(setup, record["fault"].max())
    return 1e3 * turn_rms(record)[-1]


def need_no_fault(setup: Setup, fault: float) -> None:
    if fault > 0.0:
        raise RuntimeError(f"{setup.name}: the drive tripped: {tables().faults[int(fault)].name}")


def verdicts(answers: Sequence[Answer]) -> Iterator[tuple[Answer, str, bool]]:
    """Each with its verdict in words, and whether it is good: an accepted pair acts, and is no worse than its parts."""
    figures = {answer.pair: answer.figure for answer in answers}
    for answer in answers:
        pair = answer.pair
        if answer.refused:
            named = " does not go with " in answer.refusal
            yield answer, answer.refusal if named else f"FAILED: {answer.refusal}", named
            continue
        without = figures.get(replace(pair, observer="none"), math.nan)
        alone = figures.get(replace(pair, loop="pi" if pair.mode == "speed" else "ppi"), math.nan)
        if pair.observer == "none":
            yield answer, "alone", True
        elif pair.mode == "position" and pair.observer == "ro":
            yield answer, f"ro rests below {RO_LEAST_RPM:g} rpm", True
        elif abs(answer.figure - without) <= ACTS * without:
            yield answer, "FAILED: does nothing", False
        elif answer.figure > HARM * max(without, alone):
            yield answer, "FAILED: worse than either alone", False
        elif answer.figure <= min(without, alone):
            yield answer, "better than either alone", True
        else:
            better = pair.loop if without < alone else pair.observer
            yield answer, f"works; {better} alone leaves less", True


def table(answers: Sequence[Answer], mode: str) -> TableView:
    """The pairs of one mode as a table."""
    found = [(answer, text, good) for answer, text, good in verdicts(answers) if answer.pair.mode == mode]
    rows = [
        (a.pair.loop, a.pair.observer, a.pair.current, "-" if a.refused else f"{a.figure:.3g}", text)
        for a, text, _ in found
    ]
    what = {
        "speed": "Largest ripple of 1st and 2nd electrical order after a load step, % of the mean speed; "
        "guo2024, 17-bit encoder.",
        "position": "Rms of the position error in turn 10 at 20 rpm, its mean taken off, mrad; yeh2024.",
    }
    header = ("loop", "observer", "current", "%" if mode == "speed" else "mrad", "verdict")
    marks = ["" if good else "bad" for _, _, good in found]
    return TableView(f"What goes with what, {mode} mode", what[mode], header, rows, marks, left=3)


def coarse_table() -> TableView:
    """fal-FORC and an observer beside it on a coarse encoder: here the settings of ARO decide."""
    alone = _speed_figure(Pair("speed", "fal-forc", "none", "pi"), COARSE_COUNTS)
    tried = [("none", "", alone)]
    tried += [(each, "", _speed_figure(Pair("speed", "fal-forc", each, "pi"), COARSE_COUNTS)) for each in ("dob", "ro")]
    aro = Pair("speed", "fal-forc", "aro", "pi")
    tried += [("aro", text, _speed_figure(aro, COARSE_COUNTS, words)) for text, words in COARSE_ARO.items()]
    rows = [
        (
            each,
            text,
            f"{figure:.3g}",
            "HARMS: " + str(round(figure / alone, 1)) + " times" if figure > alone else "good",
        )
        for each, text, figure in tried
    ]
    return TableView(
        "fal-FORC with an observer beside it on a coarse encoder",
        f"The same figure with {COARSE_COUNTS:g} counts, the paper's own encoder. The memory as Tang et al. print it "
        "harms where samples and cells fall into step, which depends on the speed; `aro_write` = hat, the default, "
        "weighs all samples around a cell.",
        ("observer", "memory", "%", ""),
        rows,
        ["bad" if row[3].startswith("HARMS") else "" for row in rows],
        left=2,
    )


def page(answers: Sequence[Answer], more: Sequence[TableView] = (), refused: TableView | None = None) -> str:
    """docs/combinations.md; `more`: options beside the methods."""
    lines = [
        "# What goes with what",
        "",
        "<!-- Made by `make combinations`, which runs every pair in the simulator. Do not edit. -->",
        "",
        "Current control, repetitive control (`method`), observer of the disturbance torque (`disturbance_observer`, "
        "or `method` = dob, ro, aro) and the position loop (`position_method`) are parts that can be combined. What "
        "does not go together is refused with both parameters and what to do (`firmware/app/combinations.def`).",
        "",
    ]
    views = [(f"{mode.capitalize()} mode", table(answers, mode)) for mode in ("speed", "position")]
    coarse = coarse_table()
    views += [(coarse.title, coarse), *((f"`{view.title}`", view) for view in more)]
    views += [(refused.title, refused)] if refused is not None else []
    for title, view in views:
        lines += [f"## {title}", "", view.text, ""]
        lines += [f"| {' | '.join(view.header)} |", f"|{'---|' * len(view.header)}"]
        lines += [f"| {' | '.join(row)} |" for row in view.rows]
        lines += [""]
    return "\n".join(lines)
