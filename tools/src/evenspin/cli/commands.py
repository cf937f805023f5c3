"""The commands by name: where each is written, and its line in the list. A command is loaded when it is called."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, MutableMapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup


@dataclass(frozen=True, slots=True)
class Entry:
    """`summary` is the first sentence of the command's help, so that the list needs none of the modules."""

    module: str
    summary: str


COMMANDS = {
    "run": Entry("run", "Run a scenario through the firmware: log, truth, summary, pictures."),
    "replay": Entry(
        "replay", "Run the firmware again from a recording, bit for bit, up to its fault; shows every signal there."
    ),
    "diff": Entry(
        "diff",
        "Compare two runs: what was set differently, and every ripple, overshoot, settling and error side by side.",
    ),
    "sweep": Entry(
        "sweep",
        "Run a scenario over a grid of its parameters, on all cores: one table of every number, with pictures.",
    ),
    "reproduce": Entry(
        "reproduce",
        "Run the scenarios of a paper and compare: ours, its simulation, its experiment, the target band.",
    ),
    "combinations": Entry(
        "combinations",
        "What goes with what: run every pair of methods in the simulator, or show why it is refused.",
    ),
    "design": Entry("design", "Design of controllers: margins and bounds before anything turns."),
    "identify": Entry("identify", "Identify a machine from logs, or from experiments on the simulated drive."),
    "compare": Entry(
        "compare",
        "How far a simulation from the references alone is from a log: rms per signal, and the gap (no unit).",
    ),
    "gap": Entry(
        "gap",
        "Find what is missing in a model: evenspin gap CASE_DIR --out DIR, or evenspin gap LOG.csv --out DIR.",
    ),
    "log": Entry("log", "Read a recording of any drive: which column is what, in which unit."),
    "memory": Entry(
        "memory",
        "What a drive has learned over the angle, as a file: show it, clear it, make lines of rdc of it, and back.",
    ),
    "motor": Entry("motor", "A motor of your own: from a name plate to a model and a drive."),
    "tune": Entry(
        "tune",
        "Parameters of current, speed and position loop, observers and ripple suppression, from the numbers of a "
        "machine.",
    ),
    "commission": Entry("commission", "Measure a motor of which only the limits are known, and tune its drive."),
    "drive": Entry(
        "drive", "Run the firmware on the simulated machine behind the link that a board has. Ends with Ctrl-C."
    ),
    "bench": Entry("bench", "Watch a drive, tune it, record it: a board, or a virtual drive."),
    "scope": Entry(
        "scope", "Live plots, full-rate captures, spectrum and tuning of a drive, on a page in the browser."
    ),
    "scenarios": Entry(
        "catalogue",
        "Scenarios that come with the package, as evenspin run takes them: list them, print one, copy one.",
    ),
    "models": Entry(
        "catalogue",
        "Models that come with the package, as model of a scenario and --model take them: list, print, copy one.",
    ),
    "export": Entry("export", "Export a scenario for other simulators."),
    "effects": Entry(
        "effects",
        "Non-ideal effects of the simulated machine: list them, explain one, or draft a new one from a verdict.",
    ),
    "parameters": Entry(
        "lists",
        "Parameters of the drive: unit, default and range. They go into the table [drive] of a model or scenario file.",
    ),
    "faults": Entry("lists", "Reasons for which the drive switches off: cause, and the first thing to check."),
    "version": Entry("lists", "Version of the package, the commit it was made of, and its libraries."),
    "demo": Entry(
        "demo",
        "Every method on a published scenario: repetitive control, torque observers, position control. One report.",
    ),
    "benchmark": Entry(
        "benchmark",
        "How fast it simulates: simulated seconds per second on one core, paper's scenario, fal-FORC.",
    ),
    "cycles": Entry(
        "cycles",
        "Estimated C28x cycles of every block and both interrupts, worst call of the driving inputs; needs the "
        "checkout.",
    ),
    "doctor": Entry(
        "doctor",
        "Check the tool chain: what is there, what is missing or too old, what it is for, and what to do next.",
    ),
    "clean": Entry(
        "clean",
        "Remove what commands that were killed left half-written beside their outputs: hidden folders "
        ".NAME.evenspin-*.",
    ),
    "docs": Entry(
        "pages",
        "Write the pages of docs made from code: parameters, effects, faults, model, scenario, meta, api, "
        "gap-thresholds.",
    ),
}


class Commands(TyperGroup):
    """The top group. Its commands are those of COMMANDS, in that order."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands = LoadedWhenCalled()

    def list_commands(self, ctx: Any) -> list[str]:
        return list(self.commands)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        loaded, self.commands = (
            self.commands,
            {name: TyperCommand(name, help=entry.summary) for name, entry in COMMANDS.items()},
        )
        try:
            super().format_help(ctx, formatter)
        finally:
            self.commands = loaded


class LoadedWhenCalled(MutableMapping[str, Any]):
    """The commands by name; the first access to one imports its module."""

    def __init__(self) -> None:
        self._loaded: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        if name not in self._loaded:
            self._loaded |= load(COMMANDS[name].module)
        return self._loaded[name]

    def __contains__(self, name: object) -> bool:
        return name in COMMANDS

    def __iter__(self) -> Iterator[str]:
        return iter(COMMANDS)

    def __len__(self) -> int:
        return len(COMMANDS)

    def __setitem__(self, name: str, command: Any) -> None:
        self._loaded[name] = command

    def __delitem__(self, name: str) -> None:
        raise TypeError(f"{name}: the list of commands is fixed")


@cache
def load(module: str) -> dict[str, Any]:
    """The commands that a module of this package registers. Once: a module adds to its own group when it registers."""
    holder = typer.Typer(no_args_is_help=True, rich_markup_mode="markdown", context_settings=CONTEXT)
    holder.callback()(_nothing)  # a group, even of one command
    importlib.import_module(f"evenspin.cli.{module}").register(holder)
    return dict(typer.main.get_group(holder).commands)


def _nothing() -> None:
    pass


CONTEXT = {"help_option_names": ["-h", "--help"]}
