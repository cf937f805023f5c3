"""`evenspin gap circle`."""

from __future__ import annotations

from typing import Annotated

import typer

from evenspin.cli.bench_port import connected
from evenspin.cli.options import Force, JsonFlag, OutFolder
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, write_json


def circle(
    port: Annotated[str, typer.Option("--port", metavar="sim:MODEL?EFFECT.PARAM=VALUE", help="A virtual drive.")],
    out: OutFolder,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads of the search; one per core if left out.")] = None,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Cause to correction on a virtual drive: experiments, verdict, correction.toml, before and after.

    The tool gets the model and the log, not what the port hides in the machine. Exit status 1 when nothing was
    corrected. On a real drive these are `evenspin bench run`, `evenspin gap` and `evenspin bench apply`.

    Example: `evenspin gap circle --port "sim:servo?cogging.amplitude_nm=0.05&cogging.order=18" --out out/circle`
    """
    from evenspin.bench.operator import operator_for
    from evenspin.bench.ports import SIM
    from evenspin.bench.transport import LocalTransport
    from evenspin.correct.circle import run_circle
    from evenspin.correct.outcome import trial_json, trial_tables
    from evenspin.correct.report import proposal_tables
    from evenspin.errors import CheckFailedError, InputError
    from evenspin.gap.story import tables_of
    from evenspin.gap.verdict import verdict_json
    from evenspin.output import OutputFolder
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    if not port.startswith(SIM):
        hint = "on a drive: `evenspin bench run`, `evenspin gap`, `evenspin bench apply`"
        raise InputError("gap circle", "--port", port, "sim: and a model", hint)
    made = origin()
    output = OutputFolder(out, made, force=force)
    screen = console(STDOUT if as_json else None)
    with connected(port) as drive:
        transport = drive.link.transport
        assert isinstance(transport, LocalTransport)
        operator = operator_for(transport, lambda request: True)
        with output as folder, progress_bar("experiments", 1.0) as bar:

            def report(what: str, share: float) -> None:
                bar.say(what)
                bar.update(share)

            done = run_circle(
                drive, operator, transport.drive.machine, folder, made.command, report, screen.print, workers
            )
    for view in tables_of(done.result):
        print_table(view, screen)
    for view in trial_tables(done.trial) if done.trial is not None else proposal_tables(done.proposal):
        print_table(view, screen)
    screen.print(done.summary)
    screen.print(f"{out}/report.html", style="bold")
    if as_json:
        applied = trial_json(done.trial, False) if done.trial is not None else None
        left = [{"effect": each.effect, "reason": each.reason} for each in done.proposal.left]
        write_json({"verdict": verdict_json(done.result), "not_corrected": left, "applied": applied}, STDOUT)
    if done.trial is None or not done.trial.kept:
        raise CheckFailedError("gap circle: nothing was corrected; the summary says why")
