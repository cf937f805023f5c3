"""`evenspin doctor`."""

from __future__ import annotations

from typing import Annotated

import typer

from evenspin.cli.options import JsonFile
from evenspin.cli.output import check_json_file, console, write_json
from evenspin.doctor.finding import Purpose


def register(app: typer.Typer) -> None:
    app.command("doctor")(doctor)


def doctor(
    need: Annotated[
        Purpose,
        typer.Option(
            "--for",
            help="What must be complete for exit status 0: build (building and simulating), test (`make test`, too), "
            "chip (a program for the F28379D).",
        ),
    ] = Purpose.BUILD,
    json_file: JsonFile = None,
) -> None:
    """Check the tool chain: what is there, what is missing or too old, what it is for, and what to do next.

    Example: `evenspin doctor`, `evenspin doctor --for chip --json`
    """
    from evenspin.doctor import State, run_checks
    from evenspin.tableview import TableView, print_table

    check_json_file(json_file)
    findings = run_checks()
    wanted = {Purpose.BUILD, need}
    bad = [finding for finding in findings if not finding.good and finding.purpose in wanted]
    screen = console(json_file)
    marks = {State.OK: "good", State.MISSING: "bad", State.OLD: "bad", State.BROKEN: "bad"}
    rows = [(f.purpose.value, f.name, f.state.value, f.found, f.needed_for, f.next_step) for f in findings]
    view = TableView(
        "tool chain",
        "",
        ("for", "what", "state", "found", "what it does", "next step"),
        rows,
        [marks[f.state] if f.purpose in wanted or f.good else "" for f in findings],
        left=6,
    )
    print_table(view, screen)
    ready = not bad
    if ready:
        screen.print(f"Everything for `{need.value}` is there.")
    else:
        screen.print(f"Not ready for `{need.value}`: {', '.join(f'{f.name} {f.state.value}' for f in bad)}.")
    if json_file is not None:
        document = {"for": need.value, "ready": ready, "findings": [finding.document() for finding in findings]}
        write_json(document, json_file)
    if not ready:
        raise typer.Exit(1)
