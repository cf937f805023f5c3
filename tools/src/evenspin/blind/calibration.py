"""Is a confidence of 0.9 right nine times in ten, and do 95 % intervals hold the truth? Seen on blind cases."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evenspin.blind.score import percent, verdict_file
from evenspin.blind.truth import Truth, fields_of
from evenspin.blind.vocabulary import UNKNOWN

EDGES = (0.0, 0.5, 0.8, 0.95, 1.0)  # of confidence
WIDER = (1.0, 2.0)  # multiples of an interval
NO_PHASE_BELOW = 0.1  # a smaller optional amplitude has no phase to speak of


@dataclass(frozen=True, slots=True)
class Level:
    """Names that were given with a confidence from `low` to `high`."""

    low: float
    high: float
    names: int
    said: float  # mean confidence
    right: float  # share


@dataclass(frozen=True, slots=True)
class Calibration:
    levels: tuple[Level, ...]
    intervals: int
    coverage: tuple[float, ...]  # share of intervals, widened as WIDER, that hold the truth; nan: none
    of_parameter: tuple[tuple[str, int, float], ...] = ()  # effect.parameter, intervals, share that holds the truth

    @property
    def error(self) -> float:
        """Expected calibration error: mean distance of what is said from what is right, over the levels."""
        names = sum(level.names for level in self.levels)
        off = sum(level.names * abs(level.said - level.right) for level in self.levels)
        return off / names if names else math.nan


def calibrate(truths: Mapping[str, Truth], results: Path) -> Calibration:
    names: list[tuple[float, bool]] = []
    misses: list[tuple[str, float]] = []
    for case, truth in truths.items():
        verdict = _verdict(results, case)
        if verdict is not None:
            names += _names(verdict, truth)
            misses += _misses(verdict, truth)
    levels = []
    for low, high in zip(EDGES, EDGES[1:], strict=False):
        here = [(said, right) for said, right in names if low <= said < high or said == high == EDGES[-1]]
        if here:
            said, right = (sum(column) / len(here) for column in zip(*here, strict=True))
            levels.append(Level(low, high, len(here), said, right))
    coverage = tuple(_share([miss <= wide for _, miss in misses]) for wide in WIDER)
    of_parameter = []
    for name in dict.fromkeys(name for name, _ in misses):
        mine = [miss <= 1.0 for other, miss in misses if other == name]
        of_parameter.append((name, len(mine), _share(mine)))
    return Calibration(tuple(levels), len(misses), coverage, tuple(of_parameter))


def markdown(found: Calibration) -> str:
    lines = ["", "Confidence against the truth:", "", "| confidence | names | said | right |", "|---|---|---|---|"]
    lines += [
        f"| {level.low:g} to {level.high:g} | {level.names} | {percent(level.said)} | {percent(level.right)} |"
        for level in found.levels
    ]
    held, wider = (percent(share) for share in found.coverage)
    lines += ["", f"Expected calibration error: {percent(found.error)} (goal <= 3 %)."]
    lines += ["", f"{found.intervals} intervals of 95 %: {held} hold the truth, {wider} when they are twice as wide."]
    if found.of_parameter:
        lines += ["", "| parameter | intervals | hold the truth |", "|---|---|---|"]
        lines += [f"| {name} | {n} | {percent(share)} |" for name, n, share in sorted(found.of_parameter)]
    return "\n".join(lines) + "\n"


def _verdict(results: Path, case: str) -> Mapping[str, Any] | None:
    path = verdict_file(results, case)
    content = json.loads(path.read_text(encoding="utf-8")) if path is not None else None
    return content if isinstance(content, dict) else None


def _names(verdict: Mapping[str, Any], truth: Truth) -> Iterator[tuple[float, bool]]:
    """Confidence of each name, and whether it is right; `unknown` is a name."""
    hidden = {entry["name"] for entry in truth.effects} | ({UNKNOWN} if truth.outside else set())
    for name, said in (verdict.get("confidence") or {}).items():
        yield float(said), name in hidden


def _misses(verdict: Mapping[str, Any], truth: Truth) -> Iterator[tuple[str, float]]:
    """effect.parameter, and how far the truth is from the middle of its interval, in half widths."""
    intervals = verdict.get("intervals") or {}
    for entry in truth.effects:
        fields = fields_of(entry["name"])
        optional = [entry["parameters"].get(p.name, 0.0) for p in fields.values() if p.optional and p.role != "phase"]
        for key, interval in intervals.get(entry["name"], {}).items():
            true = entry["parameters"].get(key)
            half = 0.5 * (interval["high"] - interval["low"])
            if true is None or not half > 0.0:  # an order or a sign is chosen, not measured
                continue
            phase = key in fields and fields[key].role == "phase"
            if phase and fields[key].optional and max(optional, default=0.0) < NO_PHASE_BELOW:
                continue
            error = interval["value"] - true
            yield f"{entry['name']}.{key}", abs(math.remainder(error, math.tau) if phase else error) / half


def _share(values: list[bool]) -> float:
    return sum(values) / len(values) if values else math.nan
