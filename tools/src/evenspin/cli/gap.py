"""`evenspin gap`: why the model does not match a log."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from evenspin.cli.gap_blind import app as blind
from evenspin.cli.gap_circle import circle
from evenspin.cli.options import Force, JsonFlag, OutFolder
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, json_text, write_json

if TYPE_CHECKING:
    from evenspin.balance import BalanceResult
    from evenspin.correct.proposal import Proposal
    from evenspin.driven import DrivenResult
    from evenspin.gap.result import CaseResult
    from evenspin.sim.progress import Bar

ONE = "case"  # the command that a path stands for


class PathFirst(TyperGroup):
    """A first word that is no sub-command is a path: `evenspin gap CASE_DIR` is `evenspin gap case CASE_DIR`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if args and args[0] not in self.commands and args[0] not in ("--help", "-h"):
            args = [ONE, *args]
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """A folder that is called like a sub-command is distinguished by the `./` before it."""
        from evenspin.errors import InputError

        try:
            return super().invoke(ctx)
        except typer.BadParameter as error:
            word = ctx.invoked_subcommand
            missing = type(error).__name__ == "MissingParameter"  # typer does not export it
            if not missing or word is None or not Path(word).exists():
                raise
            must = f"given as ./{word} where the folder or file of this name is meant"
            raise InputError(
                "gap", "command", word, must, f"or give what `evenspin gap {word} --help` asks for"
            ) from None


app = typer.Typer(
    cls=PathFirst,
    no_args_is_help=True,
    help="Find what is missing in a model: `evenspin gap CASE_DIR --out DIR`, or `evenspin gap LOG.csv --out DIR`.",
)

Check = Annotated[bool, typer.Option("--check", help="Exit status 1 when something is left or a case failed.")]
Workers = Annotated[
    int | None, typer.Option(min=1, help="Threads, or processes of a batch; one per core when left out.")
]


def register(parent: typer.Typer) -> None:
    app.add_typer(blind, name="blind")
    app.command("circle")(circle)
    parent.add_typer(app, name="gap")


@app.command(ONE)
def case(
    paths: Annotated[
        list[Path],
        typer.Argument(metavar="CASE_DIR|LOG...", help="Folder with meta.json, or logs of one machine on any drive."),
    ],
    out: OutFolder,
    model: Annotated[
        str | None, typer.Option(metavar="M", help="LOG only: a model file or built-in model it is held against.")
    ] = None,
    map_file: Annotated[
        Path | None, typer.Option("--map", metavar="MAP.toml", help="LOG only: how its columns are read.")
    ] = None,
    tolerances: Annotated[
        str | None,
        typer.Option(metavar="SET", help="LOG with --model: what a healthy unit may differ by, bench or laboratory."),
    ] = None,
    workers: Workers = None,
    check: Check = False,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Where a log and the model disagree, which effect is missing, how far the gap closes with it, what is left.

    DIR gets verdict.json, model.toml, correction.toml (parameters of the drive that counteract what is named, for
    `evenspin bench apply`), scenario.toml, report.html and the traces before and after. A file instead of a folder is
    a log of any drive. With a model it is held against the equations of the machine (without voltages: that of the
    torque), several logs of one machine together; else against a torque balance in ampere equivalents. Columns are
    found by names and data, as `evenspin log map` does; MAP.toml in DIR says how.

    Example: `evenspin gap tests/data/foreign_drive/example_cogging --out out/gap`
    """
    from evenspin.log.case import recording_in

    for each in paths:
        _must_exist(each)
    paths = [recording_in(each) or each for each in paths]
    if all(each.is_file() for each in paths):
        _logs(paths, _LogOptions(model, map_file, tolerances), out, as_json, check, force)
        return
    path = _one_folder(paths)
    _refuse("--model", model)
    _refuse("--map", map_file)
    _refuse("--tolerances", tolerances)
    result, proposal = _investigated(path, out, force, workers, steps=False)
    _tell(result, proposal, out, as_json)
    _check(check, result.finding.unknown, result.name)


@app.command("loop")
def loop(
    path: Annotated[Path, typer.Argument(metavar="CASE_DIR", help="Folder with meta.json.")],
    out: OutFolder,
    workers: Workers = None,
    check: Check = False,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Find, name, add, and again until nothing significant is left: one folder step_N per effect.

    Each step has the model with one effect more, its own gap before and after, and its traces.

    Example: `evenspin gap loop tests/data/foreign_drive/example_coulomb_and_inertia --out out/loop`
    """
    result, proposal = _investigated(path, out, force, workers, steps=True)
    screen = console(STDOUT if as_json else None)
    gap = result.before.gap
    for number, step in enumerate(result.steps[1:], 1):
        screen.print(f"step {number}: {' + '.join(step.names)}: gap {gap:.4f} -> {step.outcome.gap:.4f}")
        gap = step.outcome.gap
    _tell(result, proposal, out, as_json)
    _check(check, result.finding.unknown, result.name)


@app.command("batch")
def batch(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR...", help="Cases, or folders of cases.")],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="One folder per case, and summary.json.")],
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="dask scheduler whose workers see the same folders.")
    ] = None,
    workers: Workers = None,
    check: Check = False,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Many cases, on all cores or on a dask cluster. A case that fails is reported and does not end the others.

    Each case is written when it is done, completely or not at all, so that an interrupted batch keeps what it has.

    Example: `evenspin gap batch tests/data/foreign_drive --out out/batch`
    """
    from evenspin.errors import CheckFailedError
    from evenspin.gap import batch as work
    from evenspin.output import OutputFile
    from evenspin.output.origin import absolute
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    made = origin(*folders)
    made.keep_apart("--out", out, folder=True)
    jobs = work.jobs_of(folders, out, force)
    work.check_places(jobs)
    out.mkdir(parents=True, exist_ok=True)
    summary = OutputFile(out / work.SUMMARY, made, force=force, notes=absolute(out).parent)
    screen = console(STDOUT if as_json else None)
    screen.print(f"{len(jobs)} cases with {work.how(scheduler)}")
    with progress_bar("cases", len(jobs), patience_s=0.2) as bar:
        lines = work.run_batch(jobs, scheduler, workers, bar.update)
    summary.write(json_text(lines))
    print_table(work.summary_table(lines), screen)
    screen.print(f"{out}/{work.SUMMARY}", style="bold")
    if as_json:
        write_json(lines, STDOUT)
    failed = [line["case"] for line in lines if "error" in line]
    if failed:
        raise CheckFailedError(f"gap batch: no verdict on {', '.join(failed)}: see the table")
    unknown = [line["case"] for line in lines if "unknown" in line["verdict"]]
    _check(check, bool(unknown), ", ".join(unknown))


@app.command("plan")
def plan(
    model: Annotated[str, typer.Option(metavar="M", help="A model file or a built-in model.")],
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Perform the plan: a case folder.")] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**63 - 1, help="Of the random records and of the noise.")] = 1,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """The experiments that make every effect identifiable, sized for this machine; with --out on the virtual drive.

    What it writes is a case that `evenspin gap DIR` reads: with the model's own effects hidden in it.

    Example: `evenspin gap plan --model guo2024 --out out/plan`
    """
    from evenspin.gap import plan as planning
    from evenspin.log import write_case
    from evenspin.log.case import write_json as write_file
    from evenspin.model.machine import find_model, load_machine
    from evenspin.output import OutputFolder
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import TableView, print_table

    output = OutputFolder(out, origin(model), force=force) if out is not None else None
    machine = load_machine(find_model(model, Path(), _no_model(model)))
    experiments = planning.plan(machine, seed)
    changed = planning.changed_model(machine)
    screen = console(STDOUT if as_json else None)
    rows = [(e.name, f"{e.setup.duration_s:g}", e.what, ", ".join(e.serves) or "the gap") for e in experiments]
    view = TableView("Experiments", "In this order, at rest in between.", ("name", "s", "what", "serves"), rows, left=4)
    print_table(view, screen)
    if changed:
        changes = ", ".join(f"{name} {words}" for name, words in changed.items())
        screen.print(f"The drive runs and measures as the log format describes it: {changes}.")
    content = {
        "model": machine.name,
        "changed": changed,
        "experiments": [
            {"name": e.name, "duration_s": e.setup.duration_s, "what": e.what, "serves": list(e.serves)}
            for e in experiments
        ],
    }
    if output is not None:
        total = sum(e.setup.duration_s for e in experiments)
        records, before = {}, 0.0
        with progress_bar("performing the plan", total) as bar:
            for e in experiments:

                def advance(t_s: float, start_s: float = before) -> None:
                    bar.update(start_s + t_s)

                records[e.name] = planning.perform(e, advance)
                before += e.setup.duration_s
        with output as folder:
            write_case(folder, planning.meta(experiments, f"{machine.name}-plan"), records)
            write_file(folder / "plan.json", content)
        screen.print(f"{out}", style="bold")
    if as_json:
        write_json(content, STDOUT)


def _investigated(path: Path, out: Path, force: bool, workers: int | None, steps: bool) -> tuple[CaseResult, Proposal]:
    from evenspin.gap.check import checked_case
    from evenspin.output import OutputFolder

    made = origin(path)
    output = OutputFolder(out, made, force=force)
    loaded, messages = checked_case(path)
    from evenspin.correct.file import write_correction
    from evenspin.correct.proposal import proposal_of
    from evenspin.correct.report import proposal_chapter
    from evenspin.gap.folder import write_result, write_steps  # they take a second to load
    from evenspin.gap.result import investigate
    from evenspin.sim.progress import progress_bar

    with progress_bar("reading", 1.0, patience_s=1.0) as bar:

        def report(what: str, share: float) -> None:
            bar.say(what)
            bar.update(share)

        result = investigate(loaded, workers, report, messages)
        report("simulating corrections", 0.95)
        proposal = proposal_of(result)
        report("drawing", 0.97)
        with output as folder:
            write_result(folder, result, made.command, [proposal_chapter(proposal)])
            write_correction(folder, proposal, result.case, result.nominal)
            if steps:
                write_steps(folder, result)
    return result, proposal


def _tell(result: CaseResult, proposal: Proposal, out: Path, as_json: bool) -> None:
    from evenspin.correct.report import proposal_tables, summary
    from evenspin.gap.headline import summary_of
    from evenspin.gap.story import tables_of
    from evenspin.gap.verdict import verdict_json
    from evenspin.tableview import print_table

    screen = console(STDOUT if as_json else None)
    for view in (*tables_of(result), *(proposal_tables(proposal) if result.finding.named else ())):
        print_table(view, screen)
    for sentence in (*summary_of(result), summary(proposal)):
        screen.print(sentence)
    screen.print(f"{out}/report.html", style="bold")
    if as_json:
        write_json(verdict_json(result), STDOUT)


@dataclass(frozen=True, slots=True)
class _LogOptions:
    model: str | None
    map_file: Path | None
    tolerances: str | None


def _logs(paths: list[Path], options: _LogOptions, out: Path, as_json: bool, check: bool, force: bool) -> None:
    """Logs of one machine: read all of them, then choose by what was recorded."""
    from evenspin.cli.log import imported_from, is_native, keep, known_from, show
    from evenspin.correct.report import proposal_tables, summary
    from evenspin.driven import serves
    from evenspin.output import OutputFolder
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    made = origin(*paths, options.model, options.map_file)
    output = OutputFolder(out, made, force=force)
    screen = console(STDOUT if as_json else None)
    map_file = options.map_file
    known = known_from(options.model) if map_file is None and options.model is not None else None
    imported = [
        None if map_file is None and is_native(path) else imported_from(path, map_file, known) for path in paths
    ]
    with output as folder, progress_bar("balancing torque", 1.0) as bar:
        several = len(paths) > 1
        places = [
            path if read is None else keep(read, path, folder, several, options.model is not None)
            for path, read in zip(paths, imported, strict=True)
        ]
        driven = options.model is not None and serves(places, options.model)
        result = (
            _driven(places, options, folder, bar, made.command)
            if driven
            else _balance(places, options, folder, bar, made.command)
        )
        proposal, why_none = _corrections(folder, result.verdict, options.model) if driven else (None, "")
    for read in imported:
        if read is not None:
            show(read, screen)
    for view in result.tables:
        print_table(view, screen)
    if proposal is not None:
        for view in proposal_tables(proposal):
            print_table(view, screen)
    for sentence in (*result.summary, why_none or (summary(proposal) if proposal is not None else "")):
        screen.print(sentence)
    screen.print(f"{out}/report.html", style="bold")
    if as_json:
        write_json(result.verdict, STDOUT)
    names = ", ".join(path.name for path in paths)
    _check(check, not result.verdict["clear"], names, "something is left unexplained")


def _corrections(folder: Path, verdict: Mapping[str, Any], model: str | None) -> tuple[Proposal | None, str]:
    from evenspin.correct.anylog import write_for_log

    assert model is not None
    return write_for_log(folder, verdict, model)


def _driven(places: list[Path], options: _LogOptions, folder: Path, bar: Bar, command: str) -> DrivenResult:
    from evenspin.driven import run_driven

    assert options.model is not None
    return run_driven(places, options.model, options.tolerances or "bench", folder, bar, command)


def _balance(places: list[Path], options: _LogOptions, folder: Path, bar: Bar, command: str) -> BalanceResult:
    from evenspin.balance import run_balance
    from evenspin.errors import InputError

    needs = "given with --model M that states psi_wb, inertia_kgm2 and viscous_nms, or voltages in the log"
    if options.tolerances is not None:
        raise InputError("gap", "--tolerances", options.tolerances, needs, "a torque balance has its own thresholds")
    if len(places) > 1:
        raise InputError("gap", "LOG...", f"{len(places)} logs", needs, "give one log at a time")
    return run_balance(places[0], options.model, folder, bar, command)


def _one_folder(paths: list[Path]) -> Path:
    from evenspin.errors import InputError

    if len(paths) > 1:
        hint = "`evenspin gap batch` takes several case folders"
        raise InputError("gap", "CASE_DIR|LOG", f"{len(paths)} of both kinds", "one case folder, or logs alone", hint)
    return paths[0]


def _must_exist(path: Path) -> None:
    from evenspin.errors import InputError, did_you_mean

    if not path.exists():
        words = [command.name or "" for command in app.registered_commands if command.name != ONE]
        close = did_you_mean(str(path), words) if str(path).isidentifier() else ""
        hint = close if close.startswith("did you mean") else f"sub-commands are {', '.join(words)}, blind"
        raise InputError("gap", "CASE_DIR|LOG", str(path), "an existing folder or file", hint)


def _refuse(option: str, value: object) -> None:
    from evenspin.errors import InputError

    if value is not None:
        raise InputError("gap", option, value, "left out for a case folder", "its meta.json says it")


def _no_model(model: str) -> Any:
    from evenspin.errors import InputError

    return lambda must, hint: InputError("gap plan", "--model", model, must, hint)


def _check(check: bool, unknown: bool, name: str, what: str = "unknown") -> None:
    from evenspin.errors import CheckFailedError

    if check and unknown:
        raise CheckFailedError(f"gap: {what}: {name}: see report.html")
