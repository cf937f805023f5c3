"""How well causes that no table lists are described: by what they depend on, how much of the gap, and beside what."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.blind.foreign_effects import FOREIGN, Expected
from evenspin.blind.log_score import read_result
from evenspin.blind.logs import LogTruth
from evenspin.blind.score import parameter_errors
from evenspin.blind.vocabulary import UNKNOWN

MADE = "<!-- Made by `make foreign-logs`. Do not edit. -->\n\n# Causes that nobody has listed\n\n"
ABOUT = """Logs of other drives as in [blind-logs.md](blind-logs.md), all with voltages, from the referee, with causes
that no table of effects has (`tools/src/evenspin/blind/foreign_effects.py`), a third of them beside a known effect. A
dependence is right when a term of `empirical` depends on the quantity, with the order, frequency or power within 10 %;
it is wrong when there are terms and none of them does. `silent` has no term: a cause of which the log shows no more
than noise is not distinguished from one that was missed. An effect beside it counts as missed all the same.

"""
WITHIN_KNOWN = 0.05  # of a parameter of the known effect
GOALS = {
    "right": (">=", 0.85, "dependence named right"),
    "right_of_said": (">=", math.nan, "the same, of the logs that have a term"),
    "wrong": ("<=", 0.03, "a dependence that is not there"),
    "closed_median": (">=", 0.85, "gap above the floor closed on unseen stretches, median"),
    "closed_p10": (">=", 0.60, "the same, 10th percentile"),
    "beside_name": (">=", 0.90, "known effect beside it: its name"),
    "beside_size": (">=", 0.90, "known effect beside it: its name, and parameters within 5 %"),
    "false_terms": ("<=", 0.02, "a term on a clean unit, or where known effects suffice"),
}


@dataclass(frozen=True, slots=True)
class ForeignScore:
    log: str
    truth: LogTruth
    said: str  # "right", "wrong", "silent", or "refused"
    forms: tuple[str, ...]
    closed: float
    known_name: bool | None  # None: there is no known effect beside a foreign one
    known_size: bool | None


def score_foreign(truths: Mapping[str, LogTruth], results: Path) -> list[ForeignScore]:
    """The logs that have been run."""
    found = []
    for log, truth in truths.items():
        run, verdict = read_result(results, log)
        if run is not None:
            found.append(score_one(log, truth, verdict))
    return found


def score_one(log: str, truth: LogTruth, verdict: Mapping[str, Any] | None) -> ForeignScore:
    if verdict is None:
        return ForeignScore(log, truth, "refused", (), math.nan, None, None)
    terms = verdict.get("empirical") or []
    names = [name for name in verdict.get("verdict") or () if name != UNKNOWN]
    said = "silent"
    cause = next(iter(truth.outside), "")
    if cause:
        expected = FOREIGN[cause].expected
        if any(_is(term, expected, truth.outside[cause]) for term in terms) or set(names) & set(expected.known):
            said = "right"
        elif terms:
            said = "wrong"
    elif terms:
        said = "wrong"
    before, after = verdict.get("gap_before"), verdict.get("gap_after")
    closed = math.nan if before is None or after is None or before <= 1.0 else (before - after) / (before - 1.0)
    known = next(iter(truth.effects), "") if cause else ""
    name_right = known in names if known else None
    size_right = (
        None if not known else name_right and all(error <= WITHIN_KNOWN for _, error in _errors(known, truth, verdict))
    )
    return ForeignScore(
        log, truth, said, tuple(term["form"] for term in terms), min(closed, 1.0), name_right, size_right
    )


def _errors(known: str, truth: LogTruth, verdict: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    yield from parameter_errors(known, truth.effects[known], (verdict.get("parameters") or {}).get(known, {}))


def _is(term: Mapping[str, Any], expected: Expected, values: Mapping[str, float]) -> bool:
    if term["depends_on"][0] not in expected.depends_on:
        return False
    if expected.parity and not term["family"].endswith(expected.parity):
        return False
    found = term["parameters"]
    if expected.power and abs(found.get("exponent", expected.power) / expected.power - 1.0) > expected.within:
        return False
    if expected.key and expected.key in found:
        return abs(found[expected.key] / values[expected.key] - 1.0) <= expected.within
    return True


def summary_of(scores: Sequence[ForeignScore]) -> dict[str, float]:
    own = [s for s in scores if s.truth.outside and s.said != "refused"]
    others = [s for s in scores if not s.truth.outside and s.said != "refused"]
    said = [s for s in own if s.said != "silent"]
    closed = [s.closed for s in own if not math.isnan(s.closed)]
    beside = [s for s in own if s.known_name is not None]

    def share(values: Sequence[bool]) -> float:
        return float(np.mean(values)) if values else math.nan

    return {
        "right": share([s.said == "right" for s in own]),
        "right_of_said": share([s.said == "right" for s in said]),
        "wrong": share([s.said == "wrong" for s in own]),
        "closed_median": float(np.median(closed)) if closed else math.nan,
        "closed_p10": float(np.percentile(closed, 10)) if closed else math.nan,
        "beside_name": share([bool(s.known_name) for s in beside]),
        "beside_size": share([bool(s.known_size) for s in beside]),
        "false_terms": share([s.said == "wrong" for s in others]),
    }


def page(scores: Sequence[ForeignScore], seeds: str) -> str:
    counts = Counter(s.truth.kind for s in scores)
    kinds = ", ".join(f"{counts[kind]} {kind}" for kind in ("foreign", "beside", "none", "single"))
    lines = [f"{len(scores)} logs (seeds {seeds}): {kinds}.", "", "| | found | goal | |", "|---|---|---|---|"]
    for name, value in summary_of(scores).items():
        sense, goal, text = GOALS[name]
        met = not (value < goal if sense == ">=" else value > goal)
        wanted = "" if math.isnan(goal) else f"{sense} {goal:.0%}"
        lines.append(f"| {text} | {_percent(value)} | {wanted} | {'' if met or not wanted else 'missed'} |")
    lines += ["", "| cause | logs | right | wrong | silent |", "|---|---|---|---|---|"]
    for cause in sorted({name for s in scores for name in s.truth.outside}):
        own = [s.said for s in scores if cause in s.truth.outside]
        lines.append(f"| {cause} | {len(own)} | {own.count('right')} | {own.count('wrong')} | {own.count('silent')} |")
    lines += ["", "One by one:", "", "| log | hidden | size | said | closed | terms |", "|---|---|---|---|---|---|"]
    for s in scores:
        hidden = " and ".join((*s.truth.outside, *s.truth.effects)) or "nothing"
        forms = "; ".join(s.forms)
        lines.append(f"| {s.log} | {hidden} | {s.truth.size} | {s.said} | {_percent(s.closed)} | {forms} |")
    return MADE + ABOUT + "\n".join(lines) + "\n"


def _percent(value: float) -> str:
    return "-" if math.isnan(value) else f"{100.0 * value:.0f} %"
