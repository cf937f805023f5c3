"""What one check found."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any


class Purpose(StrEnum):
    """What something is needed for."""

    BUILD = "build"  # building, simulating, every command: without it there is no evenspin
    TEST = "test"  # `make test`
    CHIP = "chip"  # a program for the F28379D


class State(StrEnum):
    OK = "ok"
    MISSING = "missing"
    OLD = "too old"
    BROKEN = "broken"


@dataclass(frozen=True, slots=True)
class Finding:
    """`found`: version or place; `next_step`: empty when nothing is to be done."""

    name: str
    purpose: Purpose
    state: State
    found: str
    needed_for: str
    next_step: str = ""

    @property
    def good(self) -> bool:
        return self.state is State.OK

    def document(self) -> dict[str, Any]:
        return asdict(self)


def version_in(text: str) -> str:
    """The first word that can be a version; empty when there is none."""
    match = re.search(r"(?<![\w.])[vV]?(\d+(?:\.\d+)+)", text)
    return match[1] if match else ""


def older(version: str, least: str) -> bool:
    """Whether a version is below another; what is not a number is not older."""
    if not version or not least:
        return False
    return numbers(version) < numbers(least)


def numbers(version: str) -> tuple[int, ...]:
    """2.10.1 as (2, 10, 1); trailing zeros do not count, so that 8.0 is 8."""
    parts = [int(part) for part in re.findall(r"\d+", version)]
    while parts and parts[-1] == 0:
        parts.pop()
    return tuple(parts)
