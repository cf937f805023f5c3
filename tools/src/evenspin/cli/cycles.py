"""`evenspin cycles`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from evenspin.cli.options import JsonFile
from evenspin.cli.output import check_json_file, console, write_json

if TYPE_CHECKING:
    from collections.abc import Mapping

    from evenspin.cycles.measure import Result
    from evenspin.tableview import TableView


def register(app: typer.Typer) -> None:
    app.command("cycles")(cycles)


def cycles(
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help="Exit status 1 when a budget is exceeded or missed; with --compare, when an "
            "interrupt took longer than the estimate and its error band allow.",
        ),
    ] = False,
    record: Annotated[bool, typer.Option("--record", help="Write the figures down as those to compare with.")] = False,
    log: Annotated[
        Path | None,
        typer.Option(
            "--compare",
            metavar="LOG",
            help="A log with the durations that the drive measured (a folder or a "
            "CSV file): put them beside the estimate.",
        ),
    ] = None,
    variant: Annotated[
        str | None,
        typer.Option(
            help="With --compare: what ran, named as in the table ('aro deadbeat', 'position rdc'); without it, "
            "what the summary beside the log says.",
        ),
    ] = None,
    no_m4: Annotated[
        bool,
        typer.Option(
            "--no-m4", help="Leave out the instructions of a Cortex-M4F, which no budget holds: half of the time."
        ),
    ] = False,
    json_file: JsonFile = None,
) -> None:
    """Estimated C28x cycles of every block and both interrupts, worst call of the driving inputs; needs the checkout.

    Example: `evenspin cycles --check`, `evenspin cycles --compare out/first`
    """
    from evenspin.cycles.measure import measure, source_root
    from evenspin.errors import InputError

    check_json_file(json_file)
    if log is None:
        if variant is not None:
            raise InputError("cycles", "--variant", variant, "given together with --compare", "add --compare LOG")
        _estimate(measure(source_root(), with_m4=not no_m4), check, record, json_file)
    else:
        if record:
            raise InputError("cycles", "--record", True, "given without --compare", "leave one of them out")
        if no_m4:
            raise InputError("cycles", "--no-m4", True, "given without --compare", "a comparison counts none")
        _compare(log, variant, check, json_file)


def _estimate(result: Result, check: bool, record: bool, json_file: str | None) -> None:
    from rich.table import Table

    from evenspin.cycles.evidence import LARGE_CYC
    from evenspin.cycles.measure import source_root
    from evenspin.cycles.rows import BUDGETS, CPU_MHZ, read_budgets, violations, write_recorded

    budget_file = source_root() / BUDGETS
    budgets, recorded, known = read_budgets(budget_file)
    screen = console(json_file)
    table = Table("kind", "name", box=None)
    for title in ("mean", "worst", "with band", "budget", "", "us", "published", "us", "Cortex-M4F"):
        table.add_column(title, justify="right")
    for row in result.rows:
        over = row.budget is not None and row.cycles_held > row.budget
        published = ("", "")
        if row.published_us is not None:
            published = (str(row.published_cycles), f"{row.published_us:.2f}")
        numbers = (str(row.cycles_est), str(row.cycles_worst), str(row.cycles_held), str(row.budget or ""))
        instructions = "" if row.m4_instructions is None else str(row.m4_instructions)
        time = f"{row.cycles_worst / CPU_MHZ:.2f}"
        table.add_row(row.kind, row.name, *numbers, "OVER" if over else "", time, *published, instructions)
    screen.print(table)
    block, interrupt = result.block, result.interrupt
    screen.print(
        f"An estimate. Held against {len(result.listed)} functions that TI's compiler made, model over real is "
        f"{block.low:.2f} .. {block.high:.2f} for a block (10th to 90th percentile of {block.functions}), "
        f"{interrupt.low:.2f} .. {interrupt.high:.2f} from {LARGE_CYC} cycles on, as an interrupt "
        f"({interrupt.functions}). 'with band' is the worst call over the lower end, which a budget holds. 'published' "
        f"is what the papers state in microseconds for their hardware, as cycles of {CPU_MHZ:.0f} MHz. No chip has "
        "confirmed a number."
    )
    if result.m4_note:
        screen.print(result.m4_note)
    if json_file is not None:
        write_json(result.document(), json_file)
    if record:
        write_recorded(budget_file, result.rows)
        return
    found = [*result.contradictions, *violations(result.rows, budgets, recorded, known)]
    for line in found:
        screen.print(line)
    if check and found:
        raise typer.Exit(1)


def _compare(log: Path, variant: str | None, check: bool, json_file: str | None) -> None:
    from evenspin.cycles.compare import BIN_CYC, FRAME_CYC, compare, log_file, read_measured, variant_beside
    from evenspin.cycles.measure import measure, source_root
    from evenspin.errors import MISSING, InputError
    from evenspin.tableview import TableView, print_table

    file = log_file(log)
    measured = read_measured(file)
    name = variant or variant_beside(log)
    if name is None:
        hint = "there is no summary.json beside this log: name what ran, such as --variant 'fal-forc'"
        raise InputError("cycles", "--variant", MISSING, "given", hint)
    result = measure(source_root(), with_m4=False)
    rows = compare(measured, result, name)
    low, high = result.band
    view = TableView(
        "interrupts, cycles without entry and exit",
        f"{file}. Expected: where a measurement may lie when the estimate's worst call is {100 * low:+.0f} % .. "
        f"{100 * high:+.0f} % off. Entry and exit, {FRAME_CYC} cycles in the estimate, come on top.",
        ("name", "measured min", "last", "max", "estimated mean", "worst", "difference %", "expected", ""),
        [
            (
                row.name,
                "-" if row.measured_min is None else str(row.measured_min),
                *(str(value) for value in (row.measured_last, row.measured_max)),
                *(str(value) for value in (row.estimated_mean, row.estimated_worst)),
                f"{row.difference_pct:+.0f}",
                f"{row.expected[0]} .. {row.expected[1]}",
                row.verdict,
            )
            for row in rows
        ],
        ["good" if row.verdict == "inside" else "bad" for row in rows],
        left=1,
    )
    screen = console(json_file)
    print_table(view, screen)
    bins = {interrupt: seen.bins for interrupt, seen in measured.items() if seen.bins is not None}
    if bins:
        print_table(_histogram(bins), screen)
    if json_file is not None:
        document = {
            "log": str(file),
            "variant": name,
            "error_band": [low, high],
            "rows": [row.document() for row in rows],
            "histogram": {"bin_cycles": BIN_CYC, **{interrupt: list(b) for interrupt, b in bins.items()}},
        }
        write_json(document, json_file)
    if check and any(row.verdict == "above" for row in rows):
        raise typer.Exit(1)


def _histogram(bins: Mapping[str, tuple[int, ...]]) -> TableView:
    """How often how long, without the bins in which nothing is."""
    from evenspin.cycles.compare import BIN_CYC, BINS
    from evenspin.tableview import TableView

    rows = [
        (f"{k * BIN_CYC}{'' if k < BINS - 1 else ' and more'}", *(str(counts[k]) for counts in bins.values()))
        for k in range(BINS)
        if any(counts[k] for counts in bins.values())
    ]
    return TableView("how often how long", "", ("cycles from", *bins), rows, left=0)
