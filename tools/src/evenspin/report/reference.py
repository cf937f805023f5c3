"""Reference pages made from the tables of the library, so that they cannot disagree with it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from evenspin.model.machine import SIMULATED, UNKNOWN
from evenspin.native import Field, tables

MADE = "<!-- Made by `evenspin docs` from the tables of the library. Do not edit. -->"


def pages() -> dict[str, str]:
    """File name and content."""
    return {
        "parameters.md": _parameters(),
        "model.md": _model(),
        "effects.md": _effects(),
        "faults.md": _faults(),
    }


def _parameters() -> str:
    text = (
        "Every parameter of the drive. In a model or scenario file they go into the table `[drive]`; the choices are "
        "given as their word, the switches as `true` or `false`.\n\n"
        "*At rest*: only changes while the bridge is off. That is what the electrical angle stands on, what protects, "
        "and what decides over the kind or the size of a memory or a filter. All others are taken over between two "
        "samples while the drive runs. No limit goes beyond the maximum of the board, whatever its range here."
    )
    return page("Drive parameters", text, _parameter_table(tables().params.values()))


def _model() -> str:
    text = (
        "Every number of the simulated machine. In a model file they go into the table `[plant]`. The numbers of a "
        'motor have no default: a model without them is an error that lists them, unless `base = "guo2024"` at the '
        "top of the file (any built-in model) states whose `[plant]` gives the others. The drive gets the motor data "
        "of `[plant]` (`motor_*`, `observer_*`, `rdc_*` of inertia and viscous friction, `pole_pairs`, "
        "`encoder_counts`) unless `[drive]` states them: what it assumes may differ from what the machine is."
    )
    words = dict.fromkeys(SIMULATED, "to be given") | dict.fromkeys(UNKNOWN, "not known")
    return page("Plant model", text, _field_table(tables().model.values(), words))


def _effects() -> str:
    text = "Non-ideal effects of the simulated machine. In a model or scenario file each has a table `[effects.NAME]`."
    parts = []
    for effect in tables().effects.values():
        about = f"Acts on: {effect.acts_on}. {escape(effect.doc)}\n\nShows as: {escape(effect.signature)}"
        parts.append(f"## {effect.name}\n\n{about}\n\n{_field_table(effect.params.values())}")
    return page("Effects", text, "\n\n".join(parts))


def _faults() -> str:
    text = (
        "The first fault wins: it switches the bridge off and stays until it is cleared. "
        "The number is what the signal `fault` shows."
    )
    rows = [
        f"| {number} | `{fault.name}` | {escape(fault.cause)} | {escape(fault.check)} |"
        for number, fault in enumerate(tables().faults)
        if number > 0
    ]
    table = "\n".join(["| no. | name | cause | check first |", "| --- | --- | --- | --- |", *rows])
    return page("Faults", text, table)


def page(title: str, text: str, body: str) -> str:
    """A page of the manual that a command makes."""
    return f"{MADE}\n\n# {title}\n\n{text}\n\n{body}\n"


def _field_table(fields: Iterable[Field], words: Mapping[str, str] = MappingProxyType({})) -> str:
    """`words`: in place of a default."""
    rows = []
    for f in fields:
        default = words.get(f.name, f.to_text(f.default))
        rows.append(f"| `{f.name}` | {escape(f.unit)} | {default} | {_range(f)} | {escape(f.doc)} |")
    return "\n".join(["| name | unit | default | range | |", "| --- | --- | --- | --- | --- |", *rows])


def _parameter_table(fields: Iterable[Field]) -> str:
    rows = [
        f"| `{f.name}` | {escape(f.unit)} | {f.to_text(f.default)} | {_range(f)} | {'at rest' if f.at_rest else ''} | "
        f"{escape(f.doc)} |"
        for f in fields
    ]
    return "\n".join(["| name | unit | default | range | changes | |", "| --- | --- | --- | --- | --- | --- |", *rows])


def _range(field: Field) -> str:
    if field.kind == "choice":
        return ", ".join(f"`{word}`" for word in field.choices)
    return "" if field.kind == "flag" else f"{field.minimum:g} .. {field.maximum:g}"


def escape(text: str) -> str:
    """Text for a cell of a table."""
    return text.replace("|", "\\|")
