"""What is hidden in the cases of a set: a JSON file apart from the cases, with the keys of the examples' truth.json.

{case: {"effects": [{"name", "parameters"}, ...],     strongest first
        "outside": [the same],                        what no name of the vocabulary explains
        "kind", "size", "inverter", "unit",           how the case was drawn
        "simulator",                                  what made the records: referee or motulator
        "seed",                                       of the set
        "left_open": {parameter: value},              what the vocabulary does not say about the effects
        "gap_alone": {name: gap that it opens},       noise-free, on the validation records
        "gap_nominal", "gap_named", "gap_floor"}}     of the log: to the nominal model, to that with the true effects,
                                                      and to the unit itself without noise, all by the referee
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from evenspin.blind.vocabulary import UNKNOWN
from evenspin.errors import MISSING, InputError, reason
from evenspin.log.case import write_json
from evenspin.native import tables
from evenspin.native.tables import EffectParam

HINT = "`evenspin gap blind make` writes it"


@dataclass(frozen=True, slots=True)
class Truth:
    effects: list[dict[str, Any]]
    outside: list[dict[str, Any]] = field(default_factory=list)
    kind: str = ""
    size: str = ""
    inverter: str = ""
    simulator: str = "referee"
    seed: int | None = None  # of the set
    unit: Mapping[str, float] = field(default_factory=dict)
    left_open: Mapping[str, float] = field(default_factory=dict)
    gap_alone: Mapping[str, float] = field(default_factory=dict)
    gap_nominal: float = float("nan")
    gap_named: float = float("nan")
    gap_floor: float = float("nan")

    @property
    def verdict(self) -> list[str]:
        """The right answer: names, strongest first, and `unknown` for what no name explains."""
        return [effect["name"] for effect in self.effects] + ([UNKNOWN] if self.outside else [])

    @property
    def what(self) -> str:
        """One of the kinds of `cases`, also where the file does not say it."""
        if self.outside:
            return "beside" if self.effects else "outside"
        return ("none", "single", "pair", "triple")[min(len(self.effects), 3)]


def write_truth(path: Path, truths: Mapping[str, Truth]) -> None:
    write_json(path, {case: asdict(truth) for case, truth in truths.items()})


def read_truth(path: Path) -> dict[str, Truth]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(path, "file", MISSING, "an existing file", HINT) from None
    except (OSError, ValueError) as error:
        raise InputError(path, "file", reason(error), "JSON", HINT) from None
    known = Truth.__dataclass_fields__
    try:
        return {
            str(case): Truth(**{key: value for key, value in entry.items() if key in known})
            for case, entry in content.items()
        }
    except (AttributeError, TypeError) as error:
        raise InputError(path, "content", str(error), "{case: {effects: [...]}}", HINT) from None


def fields_of(effect: str) -> Mapping[str, EffectParam]:
    """What the table of effects says about each parameter; nothing where the table does not have the effect."""
    known = tables().effects
    return known[effect].params if effect in known else {}
