"""`evenspin compare`: a log against the simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.options import JsonFlag
from evenspin.cli.output import STDOUT, console, write_json


def register(app: typer.Typer) -> None:
    app.command("compare")(compare)


def compare(
    case: Annotated[Path, typer.Argument(metavar="CASE_DIR", help="Folder with meta.json and validation records.")],
    effect: Annotated[
        list[str] | None,
        typer.Option("--effect", metavar="NAME.PARAM=VALUE", help="Add to the nominal machine; several times."),
    ] = None,
    as_json: JsonFlag = False,
) -> None:
    """How far a simulation from the references alone is from a log: rms per signal, and the gap (no unit).

    Example: `evenspin compare tests/data/foreign_drive/example_clean`
    """
    from evenspin.compare import case_gap
    from evenspin.log.gap import GAP_SIGNALS, GAP_UNITS
    from evenspin.tableview import TableView, print_table

    result = case_gap(case, parse_effects(effect or []))
    if as_json:
        records = [{"record": r.record, "gap": r.gap, "rms": dict(r.rms)} for r in result.records]
        write_json({"case": result.case, "gap": result.gap, "records": records}, STDOUT)
        return
    header = ("record", *(f"{name} [{unit}]" for name, unit in zip(GAP_SIGNALS, GAP_UNITS, strict=True)), "gap")
    rows = [(r.record, *(f"{r.rms[name]:.4f}" for name in GAP_SIGNALS), f"{r.gap:.4f}") for r in result.records]
    screen = console()
    print_table(TableView(f"{result.case}: rms of simulation less log", "", header, rows, left=1), screen)
    screen.print(f"gap {result.gap:.4f}")
    screen.print("Noise is in it. How much of it is noise, and what is missing: evenspin gap CASE_DIR --out DIR")


def parse_effects(words: list[str]) -> dict[str, dict[str, float]]:
    """`cogging.order=24` as {"cogging": {"order": 24.0}}."""
    from evenspin.errors import InputError, did_you_mean
    from evenspin.native import tables

    known = tables().effects
    effects: dict[str, dict[str, float]] = {}
    for word in words:
        place, _, text = word.partition("=")
        name, _, param = place.partition(".")
        if name not in known:
            raise InputError("--effect", "NAME", name, "the name of an effect", did_you_mean(name, known))
        if param not in known[name].params:
            raise InputError(
                "--effect", "PARAM", param, f"a parameter of {name}", did_you_mean(param, known[name].params)
            )
        try:
            effects.setdefault(name, {})[param] = float(text)
        except ValueError:
            raise InputError("--effect", place, text, "a number", f"write {place}=VALUE") from None
    return effects
