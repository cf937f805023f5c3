"""`evenspin bench apply`."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from evenspin.cli.bench_port import PortOption, connected
from evenspin.cli.options import Force, JsonFile, OutFolder
from evenspin.cli.origin import origin
from evenspin.cli.output import check_json_file, console, write_json

if TYPE_CHECKING:
    from evenspin.bench.experiments import ExperimentList
    from evenspin.output import OutputFolder

RUNS = ("before", "after", "after-2", "after-3")


def register(app: typer.Typer) -> None:
    app.command("apply")(apply)


def apply(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="What `evenspin gap` has written.")],
    out: OutFolder,
    port: PortOption = None,
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="NAME", help="Only this correction; several times.")
    ] = None,
    keep: Annotated[bool, typer.Option("--save", help="Keep what helped over a power cycle.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what would be set and done; nothing moves.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the motor moves.")] = False,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Try the corrections of correction.toml on a drive: before, predicted, measured after.

    The experiments that show what the effects spoil are performed without and with the corrections. What does not
    help is taken back. A trip or Ctrl-C leaves the drive with the parameters from before; a lost link says which ones
    it has. Nothing is saved without --save. Exit status 1 when no correction helped.

    Example: `evenspin bench apply out/gap --port sim:servo --out out/applied`
    """
    from evenspin.bench.experiments import read_experiments
    from evenspin.bench.operator import operator_for
    from evenspin.correct.changes import composed
    from evenspin.correct.file import CORRECTION, EXPERIMENTS, read_correction
    from evenspin.correct.fitting import check_fitting
    from evenspin.correct.outcome import trial_json, trial_summary, trial_tables, write_trial
    from evenspin.correct.report import proposal_tables
    from evenspin.correct.trial import only as only_these
    from evenspin.correct.trial import run_trial, shown
    from evenspin.errors import CheckFailedError, InputError, did_you_mean
    from evenspin.output import OutputFolder
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    check_json_file(json_file)
    proposal = read_correction(folder)
    names = [correction.name for correction in proposal.corrections]
    screen = console(json_file)
    if not names:
        for view in proposal_tables(proposal):
            print_table(view, screen)
        raise CheckFailedError(f"bench apply: {folder / CORRECTION} proposes no correction")
    for name in only or []:
        if name not in names:
            raise InputError("bench apply", "--only", name, "a correction of DIR", did_you_mean(name, names))
    if only:
        proposal = only_these(proposal, only)
    what = read_experiments(folder / EXPERIMENTS)
    wanted = {name for correction in proposal.corrections for name in correction.spoils.records}
    what = _only_experiments(what, wanted)
    made = origin(folder)
    output = OutputFolder(out, made, recording=True, force=force)
    raw = _Raw(out, force)
    with raw.kept(), connected(port) as drive:
        operator = operator_for(drive.link.transport, lambda request: yes or typer.confirm(request, err=True))
        for view in proposal_tables(proposal):
            print_table(view, screen)
        if dry_run:
            held = drive.get()
            check_fitting(proposal.corrections, held, drive.parameters)
            values = composed({c.name: c.changes for c in proposal.corrections}, held)
            for name, value in values.items():
                field = drive.parameters[name]
                screen.print(f"{name} = {shown(field, held[name])} -> {shown(field, value)} {field.unit}".rstrip())
            for experiment in what.experiments:
                screen.print(f"{experiment.name:18} {experiment.duration_s:6.2f} s, before and after")
            return
        question = "Parameters are going to change, and the motor is going to turn in both directions. Go on?"
        if not operator.has_load_machine and not yes and not typer.confirm(question, err=True):
            raise typer.Exit(1)
        total_s = 2.0 * sum(experiment.duration_s for experiment in what.experiments)
        with progress_bar("before and after", total_s) as bar:
            trial = run_trial(
                drive, operator, proposal, what, lambda name, seconds: bar.update(seconds), screen.print, raw.place
            )
        saved = keep and bool(trial.kept)
        if saved:
            drive.save()
    with raw.kept(), output as place:
        write_trial(place, trial, proposal, made.command, saved)
        raw.bring(output)
    raw.clear()
    for view in trial_tables(trial):
        print_table(view, screen)
    screen.print(trial_summary(trial, saved))
    screen.print(f"{out}/report.html", style="bold")
    if json_file is not None:
        write_json(trial_json(trial, saved), json_file)
    if not trial.kept:
        raise CheckFailedError("bench apply: no correction helped; the drive has the parameters from before")


def _only_experiments(what: ExperimentList, wanted: set[str]) -> ExperimentList:
    from dataclasses import replace

    return replace(what, experiments=tuple(e for e in what.experiments if e.name in wanted))


class _Raw:
    """Recordings of several runs, which grow beside the output and are brought into it at the end."""

    def __init__(self, out: Path, force: bool) -> None:
        from evenspin.bench.kept import FOLDER, beside, refuse_rescued

        self._places = {run: beside(out, f".{run}{FOLDER}") for run in RUNS}
        for place in self._places.values():
            refuse_rescued(place, force)

    def place(self, run: str) -> Path:
        return self._places[run]

    @contextlib.contextmanager
    def kept(self) -> Iterator[None]:
        """An error in this block says where the recordings are."""
        from evenspin.bench.kept import keeping

        with contextlib.ExitStack() as stack:
            for place in self._places.values():
                stack.enter_context(keeping(place))
            yield

    def bring(self, output: OutputFolder) -> None:
        from evenspin.bench.kept import recordings_in

        for run, place in self._places.items():
            for path in recordings_in(place):
                output.bring(path, f"raw/{run}/{path.name}")

    def clear(self) -> None:
        for place in self._places.values():
            with contextlib.suppress(OSError):
                place.rmdir()
