"""One number and where it has to be. Bands have two sides: suddenly much better needs a check, too."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Check:
    """`required`: the exit status depends on it; else a comparison with a reference."""

    what: str
    key: str
    value: float
    low: float
    high: float
    required: bool
    method: str = ""
    speed_rpm: float | None = None

    @property
    def passed(self) -> bool:
        return self.low <= self.value <= self.high

    def as_json(self) -> dict[str, Any]:
        return {
            "what": self.what,
            "value": self.value,
            "low": self.low,
            "high": self.high,
            "required": self.required,
            "passed": self.passed,
        }
