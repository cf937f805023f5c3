"""docs/api.md, made from the signatures and docstrings of what `import evenspin` offers."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import evenspin.api as api
from evenspin.report.reference import page

TEXT = """\
`import evenspin` takes hundredths of a second; what is used loads when it is used. Arrays are NumPy arrays, names of
signals and parameters carry their unit, words stand wherever a TOML file has them. What cannot be is an `EvenspinError`
of one line: what was given, what is allowed, what was probably meant. The package is typed (`py.typed`).

```python
{example}```

[examples](../examples) has three scripts in cells, which run as they are: what the papers show, an effect hidden in a
log, a motor of one's own. Names of parameters: [parameters.md](parameters.md), of the machine: [model.md](model.md),
of effects: [effects.md](effects.md), of keys of a scenario: [scenario.md](scenario.md)."""
EXAMPLE = """\
import evenspin as es

scenario = es.load("guo2024/third")  # es.list_scenarios() has the others; a file will do
run = scenario.change(method="fal-forc").simulate()
worse = scenario.change({"cogging.amplitude_nm": 0.02, "cogging.order": 12}, method="fal-forc").simulate()

steady = run.between(6.0, 8.0)
print(run["speed_rad_s"].shape, run.units["iq_a"], steady.orders(orders=(4, 8)))
print(run.to_pandas()[["speed_rad_s", "iq_a"]].describe())
print(worse.outcome.word, worse.summary()["segments"][0]["n1_pct"])
run.plot("true_speed_rad_s", "true_iq_a").savefig("run.svg")
worse.save("worse")  # log, truth and report, as `evenspin run` writes them

gap = es.find_gap("worse/guo2024_third.csv", model="guo2024")
print(gap.names, gap.parameters)
"""


def pages() -> dict[str, str]:
    """File name and content."""
    parts = [_entry(name, getattr(api, name)) for name in _ordered()]
    return {"api.md": page("evenspin as a library", TEXT.format(example=EXAMPLE), "\n\n".join(parts))}


def _ordered() -> list[str]:
    """What one begins with comes first."""
    first = ["load", "Scenario", "Run", "find_gap", "Gap", "name_plate", "replay_recording", "Replayed"]
    return [*first, *(name for name in api.__all__ if name not in first)]


def _entry(name: str, what: Any) -> str:
    if not inspect.isclass(what):
        return f"## `{name}{_signature(what)}`\n\n{_text(what)}"
    members = "\n\n".join(_members(name, what)) if what.__module__.startswith("evenspin.api") else ""
    return f"## `{name}`\n\n{_text(what)}\n\n{members}".rstrip()


def _members(name: str, kind: type) -> Iterator[str]:
    """Properties as a table, then each method."""
    found = {key: each for key, each in vars(kind).items() if not key.startswith("_")}
    rows = [
        f"| `{key}` | {_type(inspect.signature(each.fget).return_annotation)} | {_text(each).replace(chr(10), ' ')} |"
        for key, each in found.items()
        if isinstance(each, property) and each.fget is not None
    ]
    if rows:
        yield "\n".join(["| property | type | |", "| --- | --- | --- |", *rows])
    for key, each in found.items():
        if inspect.isfunction(each):
            yield f"### `{name}.{key}{_signature(each)}`\n\n{_text(each)}"


def _signature(function: Any) -> str:
    signature = inspect.signature(function)
    without = [each for each in signature.parameters.values() if each.name != "self"]
    return re.sub(r"(: |-> )'([^']*)'", r"\1\2", str(signature.replace(parameters=without)))


def _type(annotation: Any) -> str:
    return f"`{str(annotation).strip(chr(39))}`".replace("|", "\\|")


def _text(what: Any) -> str:
    """A docstring as Markdown: a section such as `Args:` becomes a list."""
    lines, found = (inspect.getdoc(what) or "").splitlines(), []
    section = False
    for line in lines:
        if re.fullmatch(r"(Args|Raises|Warns|Returns):", line):
            section = True
            found.append(f"{line}\n")
        elif section and (item := re.fullmatch(r"    (\w+): (.*)", line)):
            found.append(f"* `{item[1]}`: {item[2]}")
        elif section and line.startswith("        "):
            found.append(f"  {line.strip()}")
        else:
            section = section and bool(line.strip()) and line.startswith(" ")
            found.append(line)
    return "\n".join(found).strip()
