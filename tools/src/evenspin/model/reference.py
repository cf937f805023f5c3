"""docs/scenario.md: the keys of scenario and model files, from the schemas that read them."""

from __future__ import annotations

from typing import Any

from evenspin.model.machine import machine_schema
from evenspin.model.scenario_schema import event_keys, event_schema, scenario_schema
from evenspin.native import tables

EXAMPLE = """\
name = "load step"
model = "guo2024"              # a built-in model (`evenspin models`), or a file relative to this one
duration_s = 4.0

[drive]                        # on top of what the model states
method = "forc"

[effects.current_offset]
offset_a_a = 0.2

[[event]]
at_s = 0.0
speed_rpm = 150.0
load_brake_a = 1.0

[[event]]
at_s = 2.0
load_brake_a = 2.5             # what holds from now on
drive = { rc_gain = 0.5 }
"""
INTRODUCTION = """\
Both are TOML. A key that is not known, a value out of range and a wrong unit are refused with file, line and what is
allowed. `evenspin scenarios` and `evenspin models` list those that come with the package, and copy one to begin with:
`evenspin scenarios guo2024/first --copy mine.toml`."""
EVENTS = """\
`[[event]]`, in the order of time. What an event does not give stays as it was. Loads in A are in units of the torque
constant, 1.5 pole_pairs psi_wb."""
TABLES = {
    "drive": "[parameters.md](parameters.md)",
    "plant": "[model.md](model.md)",
    "effects": "[effects.md](effects.md)",
    "range": "[model.md](model.md)",
}


def pages() -> dict[str, str]:
    """File name and content."""
    parts = [
        f"```toml\n{EXAMPLE}```",
        f"## A scenario\n\n{_table(scenario_schema())}",
        f"## An event\n\n{EVENTS}\n\n{_table(event_schema())}",
        f"## A model\n\n{_table(machine_schema())}",
    ]
    made = "<!-- Made by `evenspin docs` from the readers of these files. Do not edit. -->"
    body = "\n\n".join(parts)
    return {"scenario.md": f"{made}\n\n# Scenario and model files\n\n{INTRODUCTION}\n\n{body}\n"}


def _table(schema: Any) -> str:
    rows = []
    for name, info in schema.model_fields.items():
        needed = "yes" if info.is_required() else ""
        default = "" if info.is_required() or info.default in (None, "", ()) else f"{info.default:g}"
        what = str(info.description)
        if schema is event_schema() and name in event_keys():
            what += f". {tables().inputs[event_keys()[name].input].doc}"
        more = f": {TABLES[name]}" if name in TABLES else ""
        rows.append(f"| `{name}` | {needed} | {default} | {what}{more} |")
    return "\n".join(["| key | needed | default | what it is |", "| --- | --- | --- | --- |", *rows])
