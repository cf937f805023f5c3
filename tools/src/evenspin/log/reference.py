"""docs/meta.md: the keys of meta.json, from what writes and what reads them."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from evenspin.errors import InputError
from evenspin.log.case import META
from evenspin.log.experiments import EXPERIMENTS
from evenspin.log.meta import meta_of
from evenspin.log.meta_numbers import MetaNumbers, field_of
from evenspin.log.nominal import Nominal
from evenspin.model.scenario import builtin_scenario

TEXT = """\
`meta.json` stands beside the CSV files of a case ([log-format.md](log-format.md)) and says which drive they are of:
nominal values, what a data sheet says, and how the controller is set. `evenspin run` and `evenspin bench run` write it;
a log of another drive gets it by hand, or none: `evenspin gap LOG.csv --model MODEL` needs no `meta.json`. *Needed* is
what `evenspin compare` does not work without; `evenspin gap CASE_DIR` wants the sampling periods and the ratings of the
motor, too. Gains are those of the loops in SI units, per rad/s and not per unit."""
WORDS = {  # what is no number of the machine or the drive, by its path
    "case": "the name of the case, in quotes",
    "experiments": f"names of the records, one CSV each: {', '.join(EXPERIMENTS)}, or others",
    "current_loop.ts_s": "sampling period of the current loop, s",
    "current_loop.computation_delay_periods": "PWM periods from a sample to the voltage that follows from it: 1",
    "current_loop.v_limit": 'limit of the voltage vector, V, or "dc_link_v/sqrt(3)"',
    "speed_loop.ts_s": "sampling period of the speed loop, s: a whole number of PWM periods",
    "speed_filter.type": 'where the speed comes from: "tracking_pll", "mt" or "fir"',
    "speed_filter.ts_s": "its sampling period, s",
}


def pages() -> dict[str, str]:
    """File name and content."""
    meta = meta_of(builtin_scenario("guo2024/first").setup, "first", ["validation"])
    rows = [f"| `{path}` | {'yes' if _needed(meta, path) else ''} | {_what(path)} |" for path in _paths(meta)]
    table = "\n".join(["| key | needed | what it is |", "| --- | --- | --- |", *rows])
    made = "<!-- Made by `evenspin docs` from the readers and the writer of the file. Do not edit. -->"
    example = f"```json\n{json.dumps(meta, indent=2)}\n```"
    return {"meta.md": f"{made}\n\n# meta.json\n\n{TEXT}\n\n{table}\n\n{example}\n"}


def _paths(meta: Mapping[str, Any], before: str = "") -> Iterator[str]:
    for key, value in meta.items():
        if isinstance(value, Mapping):
            yield from _paths(value, f"{before}{key}.")
        else:
            yield f"{before}{key}"


def _needed(meta: Mapping[str, Any], path: str) -> bool:
    """Whether the reader does without it."""
    if path == "experiments":
        return True
    without: Any = copy.deepcopy(dict(meta))
    inner = without
    *above, key = path.split(".")
    for each in above:
        inner = inner[each]
    del inner[key]
    try:
        Nominal.of(MetaNumbers(Path(META), without))
    except InputError:
        return True
    return False


def _what(path: str) -> str:
    if path in WORDS:
        return WORDS[path]
    field = field_of(tuple(path.split(".")))
    assert field is not None, path
    return f"{field.doc.rstrip('.')}: {field.allowed()}".replace("|", "\\|")
