"""`evenspin run`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.options import (
    Force,
    JsonFlag,
    MethodOption,
    Numeric,
    NumericOption,
    OutFolder,
    ScenarioName,
    SetOption,
)
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, write_json
from evenspin.cli.recording import RecordOption, check_record, recorder_to


def register(app: typer.Typer) -> None:
    app.command("run")(run)


def run(
    scenario: ScenarioName,
    out: OutFolder,
    method: MethodOption = None,
    set_: SetOption = None,
    numeric: NumericOption = Numeric.FLOAT,
    seed: Annotated[int | None, typer.Option(min=0, max=2**63 - 1, help="Instead of the seed in the file.")] = None,
    memory: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="What it has learned over the angle before, a table .csv or .json."),
    ] = None,
    save_memory: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write what it has learned over the angle: .json, or .csv of aro alone."),
    ] = None,
    freeze_learning: Annotated[
        bool, typer.Option("--freeze-learning", help="Learn nothing; what is known goes on acting.")
    ] = False,
    record: RecordOption = None,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Run a scenario through the firmware: log, truth, summary, pictures.

    Exit status 1 when the drive never ran, tripped, or oscillates.

    The log is in the measured-log format: time in s, speed in rad/s, currents in A, voltages in V, torque in N m.

    Example: `evenspin run guo2024/first --method fal-forc --out out/first`
    """
    from evenspin.errors import InputError, NativeError
    from evenspin.model.changes import changes_of, parsed_changes
    from evenspin.model.methods import drive_of_word
    from evenspin.model.scenario import scenario_document, scenario_from
    from evenspin.output import OutputFile, OutputFolder
    from evenspin.run import assumed, run_signals, run_tables, summary_of, write_run
    from evenspin.run.learned import check_saving, learned_tables, save_learned, table_for
    from evenspin.sim import complete, prepare
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    check_record(record)
    document = scenario_document(scenario)
    given = parsed_changes(set_ or ())
    for option, name, value in (("--method", "method", method), ("--seed", "seed", seed)):
        if value is not None and name in given:
            raise InputError("run", option, value, f"given without --set {name}={given[name]}", "keep one of the two")
    loaded = scenario_from(document, changes_of(given, document, "--set"))
    drive = {} if method is None else drive_of_word(method)
    drive |= {"observer_hold": 1.0} if freeze_learning else {}
    setup = loaded.with_changes(drive, seed)
    known = table_for(setup, memory) if memory is not None else None
    made = origin(loaded.document.path, loaded.machine.document.path, memory)
    saved = None
    if save_memory is not None:
        check_saving(setup, save_memory)
        saved = OutputFile(save_memory, made, option="--save-memory", force=force)
    output = OutputFolder(out, made, force=force)
    recorded = recorder_to(record, made, force, numeric.value, setup.name, setup.seed, setup.pwm_hz)
    try:
        with recorded as recorder, progress_bar(setup.name, setup.duration_s) as bar:
            simulation = prepare(setup, run_signals(), numeric.value, known, recorder)
            log = complete(simulation, setup, run_signals(), bar.update, recorder)
    except NativeError as error:
        raise loaded.locate(error) from None
    learned = learned_tables(setup, simulation)
    summary = summary_of(setup, log, numeric.value, learned)
    screen = console(STDOUT if as_json else None)
    for view in run_tables(summary):
        print_table(view, screen)
    outcome = summary["outcome"]
    if outcome["text"]:
        screen.print(outcome["text"], style="bold red", soft_wrap=True)
    for line in (summary["notice"], assumed(summary)):
        if line:
            screen.print(line, soft_wrap=True)
    if summary["base"]:
        screen.print(f"Motor: what [plant] does not state is that of {summary['base']}")
    if summary["observer_innovation"] is not None:
        screen.print(f"Still new to the observer: {100.0 * summary['observer_innovation']:.1f} % of what it sees")
    with output as folder:
        write_run(folder, setup, log, summary, made.command, learned)
    if saved is not None and learned is not None:
        with saved as place:
            save_learned(place, learned)
    for path in (save_memory, record):
        if path is not None:
            screen.print(str(path), style="bold")
    screen.print(f"{out}/report.html", style="bold")
    if as_json:
        write_json(summary, STDOUT)
    if outcome["result"] != "ran":
        raise typer.Exit(1)
