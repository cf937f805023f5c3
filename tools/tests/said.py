"""What a command answered."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Said:
    status: int
    out: str
    err: str
