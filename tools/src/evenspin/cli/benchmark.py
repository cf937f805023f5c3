"""`evenspin benchmark sim`."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from evenspin.cli.options import JsonFile, Numeric, NumericOption
from evenspin.cli.output import check_json_file, console, write_json


class What(StrEnum):
    SIM = "sim"


def register(app: typer.Typer) -> None:
    app.command("benchmark")(benchmark)


def benchmark(
    what: Annotated[What, typer.Argument(help="sim: the simulator with the firmware in the loop.")] = What.SIM,
    runs: Annotated[int, typer.Option(min=1, max=1000, help="How many runs; the median counts.")] = 7,
    numeric: NumericOption = Numeric.FLOAT,
    json_file: JsonFile = None,
) -> None:
    """How fast it simulates: simulated seconds per second on one core, paper's scenario, fal-FORC.

    Example: `evenspin benchmark sim --json out/bench.json`
    """
    from evenspin.sim.benchmark import measure
    from evenspin.sim.progress import progress_bar

    check_json_file(json_file)
    with progress_bar(f"benchmark {what.value}", runs) as bar:
        result = measure(runs, numeric.value, bar.update)
    screen = console(json_file)
    screen.print(
        f"{result['sim_seconds_per_second']:.0f} simulated seconds per second "
        f"(median of {runs}; {result['slowest']:.0f} .. {result['fastest']:.0f}; {numeric.value}, one core)"
    )
    if json_file is not None:
        write_json(result, json_file)
