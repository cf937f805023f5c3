"""`evenspin parameters`, `faults`, `version`: what the library knows."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from evenspin.cli.completion import fault_names, parameter_names
from evenspin.cli.options import JsonFlag
from evenspin.cli.output import STDOUT, console, write_json

if TYPE_CHECKING:
    from evenspin.native import Effect, Field


def register(app: typer.Typer) -> None:
    for command in (parameters, faults, version):
        app.command(command.__name__)(command)


def parameters(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]", help="Only this one, or those with this in their name.", autocompletion=parameter_names
        ),
    ] = None,
    as_json: JsonFlag = False,
) -> None:
    """Parameters of the drive: unit, default and range. They go into the table [drive] of a model or scenario file.

    Example: `evenspin parameters rc_`
    """
    from evenspin.native import tables
    from evenspin.tableview import TableView, print_table

    fields = [tables().params[each] for each in _chosen("parameters", "parameter", name, list(tables().params))]
    if as_json:
        write_json([_field_json(field) | {"at_rest": field.at_rest} for field in fields], STDOUT)
        return
    print_table(TableView("Drive parameters", "", FIELD_HEADER, [field_row(f) for f in fields], left=5), console())


def faults(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]", help="Only this one, or those with this in their name.", autocompletion=fault_names
        ),
    ] = None,
    as_json: JsonFlag = False,
) -> None:
    """Reasons for which the drive switches off: cause, and the first thing to check.

    Example: `evenspin faults over_current`
    """
    from evenspin.native import tables
    from evenspin.tableview import TableView, print_table

    known = {fault.name: (number, fault) for number, fault in enumerate(tables().faults) if number > 0}
    numbered = [known[each] for each in _chosen("faults", "fault", name, list(known))]
    if as_json:
        write_json([{"number": n, "name": f.name, "cause": f.cause, "check": f.check} for n, f in numbered], STDOUT)
        return
    rows = [(str(n), f.name, f.cause, f.check) for n, f in numbered]
    print_table(TableView("Faults", "", ("no.", "name", "cause", "check first"), rows, left=4), console())


def _chosen(command: str, what: str, name: str | None, known: list[str]) -> list[str]:
    """All, the one of this name, or those that have it in theirs."""
    from evenspin.errors import InputError, did_you_mean

    if name is None or name in known:
        return known if name is None else [name]
    found = [each for each in known if name in each] if name else []
    if not found:
        raise InputError(command, "NAME", name, f"the name of a {what}, or a part of one", did_you_mean(name, known))
    return found


def version(as_json: JsonFlag = False) -> None:
    """Version of the package, the commit it was made of, and its libraries."""
    from evenspin.build import build
    from evenspin.native import NUMERICS, load

    libraries = {numeric: str(load(numeric).path) for numeric in NUMERICS}
    if as_json:
        write_json({**build().as_json(), "libraries": libraries}, STDOUT)
        return
    screen = console()
    screen.print(str(build()))
    for numeric, path in libraries.items():
        screen.print(f"{numeric}: {path}")


FIELD_HEADER = ("name", "unit", "default", "range", "what it is")


def field_row(field: Field) -> tuple[str, ...]:
    doc = f"{field.doc} Changes at rest only." if field.at_rest else field.doc
    return (field.name, field.unit, field.to_text(field.default), _range(field), doc)


def _range(field: Field) -> str:
    if field.kind == "choice":
        return ", ".join(field.choices)
    return "false, true" if field.kind == "flag" else f"{field.minimum:g} .. {field.maximum:g}"


def _field_json(field: Field) -> dict[str, Any]:
    content: dict[str, Any] = {"name": field.name, "unit": field.unit, "kind": field.kind, "doc": field.doc}
    if field.kind == "choice":
        return content | {"choices": list(field.choices), "default": field.to_text(field.default)}
    limits = {"min": field.minimum, "max": field.maximum, "default": field.default}
    return content | {key: value if math.isfinite(value) else None for key, value in limits.items()}


def effect_json(effect: Effect) -> dict[str, Any]:
    return {
        "name": effect.name,
        "acts_on": effect.acts_on,
        "doc": effect.doc,
        "signature": effect.signature,
        "confused_with": list(effect.confused_with),
        "shown_by": dict(effect.shown_by),
        "told_apart": effect.told_apart,
        "scenario_only": effect.scenario_only,
        "parameters": [
            _field_json(param)
            | {"role": param.role, "example": param.example, "vector": param.vector, "optional": param.optional}
            for param in effect.params.values()
        ],
    }
