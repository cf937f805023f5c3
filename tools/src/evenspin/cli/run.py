"""`evenspin run`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from evenspin.cli.options import JsonFlag, Method, Numeric, NumericOption, OutFolder
from evenspin.cli.output import STDOUT, command_line, console, write_json

if TYPE_CHECKING:
    from evenspin.model import Scenario


def register(app: typer.Typer) -> None:
    app.command("run")(run)


def run(
    scenario: Annotated[str, typer.Argument(metavar="SCENARIO", help="A file .toml, or a built-in scenario.")],
    out: OutFolder,
    method: Annotated[Method | None, typer.Option(help="Instead of the method in the file.")] = None,
    numeric: NumericOption = Numeric.FLOAT,
    seed: Annotated[int | None, typer.Option(min=0, max=2**63 - 1, help="Instead of the seed in the file.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Run a scenario through the firmware: log, truth, summary, pictures.

    The log is in the measured-log format: time in s, speed in rad/s, currents in A, voltages in V, torque in N m.

    Example: `evenspin run guo2024/first --method fal-forc --out out/first`
    """
    from evenspin.errors import NativeError
    from evenspin.log import OutputFolder
    from evenspin.native import tables
    from evenspin.run import run_signals, segment_table, summary_of, write_run
    from evenspin.sim import simulate
    from evenspin.sim.progress import progress_bar
    from evenspin.tableview import print_table

    loaded = _load(scenario)
    drive = {} if method is None else {"method": tables().params["method"].to_number(method.value)}
    setup = loaded.with_changes(drive, seed)
    words = ["run", scenario, *(("--method", method.value) if method else ()), "--numeric", numeric.value]
    command = command_line(*words, "--seed", str(setup.seed), "--out", "DIR")
    output = OutputFolder(out, command)
    try:
        with progress_bar(setup.name, setup.duration_s) as bar:
            record = simulate(setup, run_signals(), numeric.value, bar.update)
    except NativeError as error:
        raise loaded.blame(error) from None
    summary = summary_of(setup, record, numeric.value)
    with output as folder:
        write_run(folder, setup, record, summary, " ".join(command))
    screen = console(STDOUT if as_json else None)
    print_table(segment_table(summary), screen)
    if summary["fault"]:
        fault = summary["fault"]
        screen.print(f"The drive tripped at {fault['t_s']:g} s: {fault['name']}. {fault['cause']}")
        screen.print(f"Check first: {fault['check']}")
    screen.print(f"{out}/report.html", style="bold")
    if as_json:
        write_json(summary, STDOUT)


def _load(name: str) -> Scenario:
    """A file, or else one that comes with the package."""
    from evenspin.model.scenario import builtin_scenario, load_scenario

    if Path(name).exists() or Path(name).suffix:
        return load_scenario(Path(name))
    return builtin_scenario(name)
