"""`evenspin log`: recordings of other programs and drives."""

from __future__ import annotations

from collections.abc import Mapping as MappingType
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from evenspin.cli.options import Force, JsonFlag
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, write_json

if TYPE_CHECKING:
    from rich.console import Console

    from evenspin.importer import Imported, Known, Mapping
    from evenspin.importer.table import Array, RawTable

    ColumnsBy = MappingType[str, Array]

app = typer.Typer(no_args_is_help=True, help="Read a recording of any drive: which column is what, in which unit.")

File = Annotated[Path, typer.Argument(metavar="FILE", help="CSV, MDF, MCAP, Parquet, TDMS, .mat, .npz or .npy.")]
Map = Annotated[
    Path | None, typer.Option("--map", metavar="MAP.toml", help="How the file is read, instead of a guess.")
]
PolePairs = Annotated[
    int | None, typer.Option("--pole-pairs", min=1, max=200, help="Where the file does not state it.")
]
Counts = Annotated[
    float | None, typer.Option("--counts-per-turn", min=1.0, help="Encoder counts of a mechanical turn.")
]
Rate = Annotated[float | None, typer.Option("--rate-hz", min=0.001, help="Rows per second, of a file without time.")]


def register(parent: typer.Typer) -> None:
    parent.add_typer(app, name="log")


@app.command("map")
def map_command(
    file: File,
    out: Annotated[Path, typer.Option("--out", metavar="MAP.toml", help="Where the map is written.")],
    pole_pairs: PolePairs = None,
    counts_per_turn: Counts = None,
    rate_hz: Rate = None,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Guess which column is what and why, and write it as MAP.toml, to be corrected and given to `log import` or `gap`.

    What cannot be decided stands in the file as a comment. Exit status 1 when there is something to decide.

    Example: `evenspin log map bench.csv --out MAP.toml`
    """
    from evenspin.errors import CheckFailedError
    from evenspin.importer import Known, write_map
    from evenspin.output import OutputFile

    output = OutputFile(out, origin(file), force=force)
    table, mapping = _guessed(file, Known(pole_pairs, counts_per_turn, rate_hz))
    output.write(write_map(mapping, file))
    if as_json:
        write_json(_content(table, mapping), STDOUT)
    screen = console(STDOUT if as_json else None)
    _show(table, mapping, mapping.notes, screen)
    screen.print(f"{out}", style="bold")
    if mapping.questions:
        raise CheckFailedError(f"log map: {len(mapping.questions)} to decide in {out}: {' | '.join(mapping.questions)}")


@app.command("import")
def import_command(
    file: File,
    out: Annotated[Path, typer.Option("--out", metavar="LOG.csv", help="The log with columns in SI units.")],
    map_file: Map = None,
    pole_pairs: PolePairs = None,
    counts_per_turn: Counts = None,
    rate_hz: Rate = None,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Bring a recording into the columns and units of the log format, with the guess and its reasons printed.

    Nothing is written while something is undecided or contradicts itself.

    Example: `evenspin log import bench.csv --out log.csv`
    """
    from evenspin.importer import Known
    from evenspin.output import OutputFile

    output = OutputFile(out, origin(file, map_file), force=force)
    read = imported_from(file, map_file, Known(pole_pairs, counts_per_turn, rate_hz))
    with output as place:
        write_log(read.columns, place)
        check_log(place, file)
    if as_json:
        write_json(_content(read.table, read.mapping, read.imported), STDOUT)
    screen = console(STDOUT if as_json else None)
    show(read, screen)
    screen.print(f"{out}: {len(read.table)} rows", style="bold")


@dataclass(frozen=True, slots=True)
class Read:
    """A recording of another drive, how it was read, and the result."""

    table: RawTable
    mapping: Mapping
    imported: Imported

    @property
    def columns(self) -> ColumnsBy:
        return self.imported.columns


def imported_from(file: Path, map_file: Path | None, known: Known | None = None) -> Read:
    """Read, guess or take the map, convert. What is undecided is one message with all of it."""
    from evenspin.errors import InputError
    from evenspin.importer import Known, UndecidedError, import_table, read_map

    if map_file is not None and known not in (None, Known()):
        hint = "write them in MAP.toml"
        raise InputError("--map", "value", map_file, "given without --pole-pairs, --counts-per-turn, --rate-hz", hint)
    given = read_map(map_file) if map_file is not None else None
    table, mapping = _guessed(file, known) if given is None else (_table(file), given)
    if mapping.questions:
        raise UndecidedError(file, mapping.questions)
    return Read(table, mapping, import_table(table, mapping))


def known_from(model: str) -> Known:
    """What a model file says that a recording may leave open."""
    from evenspin.balance.nominal_model import read_nominal
    from evenspin.errors import InputError
    from evenspin.importer import Known
    from evenspin.model.machine import TORQUE_ALONE, find_model, load_machine

    def refuse(must: str, hint: str) -> InputError:
        return InputError("gap", "--model", model, must, hint)

    partial = load_machine(find_model(model, Path(), refuse), ("pole_pairs",))
    if any(name not in partial.plant_from for name in TORQUE_ALONE):
        return Known(int(partial.plant["pole_pairs"]), None)
    nominal = read_nominal(model)
    counts = nominal.machine.plant_from.get("counts_per_rev") and float(nominal.machine.plant["counts_per_rev"])
    return Known(nominal.pole_pairs, counts or None)


def keep(read: Read, file: Path, folder: Path, several: bool = False, slow: bool = True) -> Path:
    """Write the log in SI units, and how it was read, into an output folder; `several`: each log has its own map."""
    from evenspin.importer import write_map

    stem = file.name.split(".")[0]
    if (folder / f"{stem}.csv").exists():
        stem = f"{stem}-{sum(1 for _ in folder.glob(f'{stem}*.csv')) + 1}"
    place = folder / f"{stem}.csv"
    write_log(read.columns, place)
    check_log(place, file, slow)
    (folder / (f"{stem}.MAP.toml" if several else "MAP.toml")).write_text(
        write_map(read.mapping, file), encoding="utf-8"
    )
    return place


def is_native(file: Path) -> bool:
    """Whether a file is a log in the columns of the format already."""
    from evenspin.importer.read import read_head

    head = read_head(file)
    names = {name.strip() for name in head.split("\n", 1)[0].split(",")}
    return {"t_s", "iq_a"} <= names and bool({"theta_m_rad", "speed_rad_s"} & names)


def write_log(columns: ColumnsBy, place: Path) -> None:
    import numpy as np

    from evenspin.log import LOG_COLUMNS, write_csv

    names = [name for name in LOG_COLUMNS if name in columns]
    write_csv(place, names, np.column_stack([columns[name] for name in names]))


def check_log(place: Path, file: Path, slow: bool = True) -> None:
    """Report contradictions in the data before anything is kept. `slow`: as the equations of a model take it."""
    import numpy as np

    from evenspin.balance.log_reader import LEAST_RATE_HZ as FOR_THE_BALANCE
    from evenspin.balance.log_reader import read_log
    from evenspin.driven.read import LEAST_RATE_HZ
    from evenspin.errors import InputError
    from evenspin.plausible.finding import Finding
    from evenspin.plausible.torque import current_is_reversed

    try:
        log = read_log(place, LEAST_RATE_HZ if slow else FOR_THE_BALANCE)
    except InputError as error:
        error.where = file
        raise
    speed = log.speed_rad_s
    if speed is None and log.theta_m_rad is not None:
        speed = np.gradient(log.theta_m_rad, log.t_s)
    if speed is not None and current_is_reversed(log.t_s, speed, log.iq_a):
        data = "the shaft speeds up against it and works on the motor on the whole"
        hint = "it looks like the opposite sign of the current, or of angle and speed: scale = -1 in MAP.toml turns it"
        raise Finding("iq_a", data, "positive where it drives in the positive direction", hint).error(file)


def _table(file: Path) -> RawTable:
    from evenspin.importer import read_table
    from evenspin.sim.progress import progress_bar

    size = max(1, file.stat().st_size) if file.is_file() else 1
    with progress_bar(f"reading {file.name}", float(size)) as bar:
        return read_table(file, bar.update)


def _guessed(file: Path, known: Known | None) -> tuple[RawTable, Mapping]:
    from evenspin.importer import guess_map

    table = _table(file)
    return table, guess_map(table, known)


def _content(table: RawTable, mapping: Mapping, imported: Imported | None = None) -> dict[str, Any]:
    return {
        "file": str(table.path),
        "kind": table.kind,
        "rows": len(table),
        "columns": {
            name: {"from": c.source, "unit": c.unit, "scale": c.scale, "offset": c.offset, "reason": c.reason}
            for name, c in mapping.columns.items()
        },
        "pole_pairs": mapping.pole_pairs if imported is None else imported.pole_pairs,
        "ignored": list(mapping.ignored),
        "notes": list(mapping.notes if imported is None else imported.notes),
        "questions": list(mapping.questions),
    }


def show(read: Read, screen: Console) -> None:
    """The table of columns, what was done, what is not used."""
    _show(read.table, read.mapping, read.imported.notes, screen)


def _show(table: RawTable, mapping: Mapping, notes: Sequence[str], screen: Console) -> None:
    from evenspin.tableview import TableView, print_table

    rows = [(name, c.source, c.unit, f"{c.scale:g}", c.reason) for name, c in mapping.columns.items()]
    title = f"{table.path.name}: {table.kind}, {len(table)} rows"
    print_table(TableView(title, "", ("quantity", "column", "unit", "scale", "why"), rows, left=5), screen)
    for note in notes:
        screen.print(note)
    if mapping.ignored:
        screen.print(f"not used: {', '.join(mapping.ignored)}")
