"""`evenspin replay`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.options import Force, JsonFlag
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, write_json


def register(app: typer.Typer) -> None:
    app.command("replay")(replay)


def replay(
    recording: Annotated[
        Path, typer.Argument(metavar="FILE", help="A file .replay from --record of `evenspin run` or `evenspin drive`.")
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder for a report with all signals, and signals.csv."),
    ] = None,
    until: Annotated[
        float | None, typer.Option("--until", metavar="S", min=0.0, help="Stop at this time at the latest, s.")
    ] = None,
    past_fault: Annotated[bool, typer.Option("--past-fault", help="Do not stop at the first fault.")] = False,
    before: Annotated[
        float, typer.Option("--before", metavar="S", min=0.0001, max=10.0, help="Keep so much before the fault, s.")
    ] = 0.05,
    after: Annotated[
        float, typer.Option("--after", metavar="S", min=0.0, max=10.0, help="Go on for so long after it, s.")
    ] = 0.01,
    other_firmware: Annotated[
        bool,
        typer.Option("--other-firmware", help="Replay what another firmware has recorded: up to the first difference."),
    ] = False,
    test: Annotated[
        str | None,
        typer.Option("--test", metavar="NAME", help="Write test_NAME.py and test_NAME.replay here: a regression test."),
    ] = None,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Run the firmware again from a recording, bit for bit, up to its fault; shows every signal there.

    Exit status 1 at a difference: the firmware is another one, or its arithmetic rounds otherwise.

    Example: `evenspin replay out/first.replay --out out/fault`
    """
    from evenspin.errors import InputError
    from evenspin.log.csvfile import write_csv
    from evenspin.output import OutputFile, OutputFolder
    from evenspin.recording import ENDING, RecordingFile
    from evenspin.replay import Window, page_of, tables_of, write_test
    from evenspin.replay import replay as replay_file
    from evenspin.replay.regression import check_name
    from evenspin.replay.report import verdict_of
    from evenspin.report.page import write_page
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    made = origin(recording)
    folder = OutputFolder(out, made, force=force) if out is not None else None
    files = None
    if test is not None:
        paths = [Path(f"test_{check_name(test)}{end}") for end in (ENDING, ".py")]
        files = [OutputFile(path, made, option="--test", force=force) for path in paths]
    length_s = RecordingFile(recording).length_s()
    with progress_bar(recording.name, min(length_s, until if until is not None else length_s)) as bar:
        replayed = replay_file(
            recording, until_s=until, past_fault=past_fault, other_firmware=other_firmware,
            window=Window(before, after), progress=bar.update,
        )  # fmt: skip
    screen = console(STDOUT if as_json else None)
    for view in tables_of(replayed):
        print_table(view, screen)
    if replayed.fault is not None:
        fault = replayed.fault
        text = f"{fault}. {fault.cause} Check first: {fault.check}"
        screen.print(text, style="bold red", soft_wrap=True)
    screen.print(verdict_of(replayed), style="" if replayed.same else "bold red", soft_wrap=True)
    if folder is not None:
        with folder as place:
            write_csv(place / "signals.csv", replayed.record.names, replayed.record.values)
            write_page(place, page_of(replayed, made.command))
        screen.print(f"{out}/report.html", style="bold")
    if files is not None and test is not None:
        if not replayed.same:
            raise InputError("replay", "--test", test, "a replay without a difference", "record it with this firmware")
        with files[0] as cut, files[1] as script:
            write_test(replayed, cut, script, test, made.command)
        screen.print(str(files[1].path), style="bold")
    if as_json:
        write_json(replayed.as_json(), STDOUT)
    if not replayed.same:
        raise typer.Exit(1)
