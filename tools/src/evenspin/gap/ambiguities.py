"""Effects that a set of experiments cannot separate: ambiguities.toml."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evenspin.effects.cogging import slot_order

FILE = Path(__file__).with_name("ambiguities.toml")


@dataclass(frozen=True, slots=True)
class Ambiguity:
    """Effects that a missing experiment leaves inseparable."""

    experiment: str
    effects: tuple[str, ...]
    says: str

    def __str__(self) -> str:
        return f"without {self.experiment}, {' and '.join(self.effects)} cannot be separated: {self.says}"


@functools.cache
def _content() -> Mapping[str, Any]:
    return tomllib.loads(FILE.read_text(encoding="utf-8"))


def ambiguities(experiments: Iterable[str], motor: Mapping[str, Any]) -> list[Ambiguity]:
    """What these experiments cannot separate in this machine."""
    there = set(experiments)
    p, slots = int(motor["pole_pairs"]), int(motor.get("slots", 0) or 0)
    same_order = slots > 0 and slot_order(p, slots) == 6 * p
    return [
        Ambiguity(entry["experiment"], tuple(entry["effects"]), entry["says"])
        for entry in _content()["missing"]
        if entry["experiment"] not in there and (same_order or not entry.get("same_order", False))
    ]
