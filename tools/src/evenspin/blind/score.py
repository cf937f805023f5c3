"""How good the verdicts on a blind set are. Every number here is a share or a ratio."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.blind.truth import Truth, fields_of
from evenspin.blind.vocabulary import EFFECTS, KINDS, SIZES, UNKNOWN
from evenspin.errors import MISSING, InputError

NONE = "none"
MISSED = "(no result)"
HINT = "one verdict.json per case, as docs/log-format.md says"
LEAST_OPEN_GAP = 0.02  # a gap that was hardly open says nothing about how far it was closed
HARD_TO_SEE = ("damping_ratio",)  # in the list of parameters, not in the summary
GOALS = {
    "strongest_right_single": (">=", 0.95),
    "exact_larger": (">=", 0.98),
    "exact_small": (">=", 0.93),
    "exact_pair": (">=", 0.95),
    "exact_triple": (">=", 0.80),
    "exact_beside": (">=", 0.85),
    "named_on_clean": ("<=", 0.01),
    "unknown_on_outside": (">=", 0.97),
    "known_called_unknown": ("<=", 0.03),
    "parameter_error_median": ("<=", 0.005),
    "parameter_error_p90": ("<=", 0.03),
    "gap_closed_median": (">=", 0.99),
    "gap_closed_p10": (">=", 0.90),
}
SAYS = {
    "strongest_right_single": "strongest effect right, one effect hidden",
    "exact_single": "exact set right, one effect hidden",
    "exact_larger": "... of medium or large size",
    "exact_small": "... of small size",
    "exact_pair": "exact set right, two effects hidden",
    "exact_triple": "exact set right, three effects hidden",
    "exact_beside": "exact set right: a known effect, and `unknown` for one outside the vocabulary",
    "false_names": "cases with a name of something that is not there",
    "named_on_clean": "a name although nothing is hidden",
    "unknown_on_clean": "unknown although nothing is hidden",
    "unknown_on_outside": "unknown and no name, effect outside the vocabulary",
    "known_called_unknown": "unknown, effects of the vocabulary hidden",
    "parameter_error_median": "parameter error, median",
    "parameter_error_p90": "parameter error, 90th percentile",
    "gap_closed_median": "gap above the floor that is closed, median",
    "gap_closed_p10": "gap above the floor that is closed, 10th percentile",
}


@dataclass(frozen=True, slots=True)
class Verdict:
    names: tuple[str, ...]
    parameters: Mapping[str, Mapping[str, float]]
    gap_before: float
    gap_after: float


@dataclass(frozen=True, slots=True)
class CaseScore:
    case: str
    what: str  # one of KINDS
    size: str
    hidden: tuple[str, ...]  # with the names of effects outside
    said: tuple[str, ...] | None  # None: no result
    right: bool
    errors: Mapping[str, float]  # effect.parameter
    gap_closed: float  # nan: not reported, or hardly open


@dataclass(frozen=True, slots=True)
class Score:
    cases: tuple[CaseScore, ...]
    summary: Mapping[str, float]  # nan where there was no such case
    confusion: Mapping[str, Mapping[str, int]]  # hidden alone -> said first

    def missed(self) -> list[str]:
        """Goals that are not reached."""
        return [
            name
            for name, (sense, goal) in GOALS.items()
            if not math.isnan(self.summary[name])
            and not (self.summary[name] >= goal if sense == ">=" else self.summary[name] <= goal)
        ]


def verdict_file(results: Path, case: str) -> Path | None:
    """`results`/CASE/verdict.json or `results`/CASE.json; None when there is neither."""
    return next((path for path in (results / case / "verdict.json", results / f"{case}.json") if path.is_file()), None)


def read_verdict(results: Path, case: str) -> Verdict | None:
    """What a solver answered; None when it left no file."""
    path = verdict_file(results, case)
    if path is None:
        return None
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(path, "file", str(error), "JSON", HINT) from None
    names = content.get("verdict", MISSING) if isinstance(content, dict) else MISSING
    if isinstance(names, str):
        names = [names]
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(path, "verdict", names, "a list of names", HINT)
    parameters = content.get("parameters") or {}
    before, after = (content.get(key) for key in ("gap_before", "gap_after"))
    return Verdict(
        tuple(name for name in names if name != NONE),
        parameters if isinstance(parameters, dict) else {},
        float("nan") if before is None else float(before),
        float("nan") if after is None else float(after),
    )


def score_set(truths: Mapping[str, Truth], results: Path) -> Score:
    if not results.is_dir():
        raise InputError("--results", "folder", str(results), "an existing folder", HINT)
    cases = tuple(score_case(case, truth, read_verdict(results, case)) for case, truth in truths.items())
    if all(case.said is None for case in cases):
        raise InputError("--results", "folder", str(results), "one with results of these cases", HINT)
    return Score(cases, _summary(cases), _confusion(cases))


def score_case(case: str, truth: Truth, verdict: Verdict | None) -> CaseScore:
    hidden = tuple(entry["name"] for entry in truth.effects + truth.outside)
    if verdict is None:
        return CaseScore(case, truth.what, truth.size, hidden, None, False, {}, math.nan)
    errors = {}
    for entry in truth.effects:
        found = verdict.parameters.get(entry["name"])
        if entry["name"] in verdict.names and isinstance(found, Mapping):
            for key, error in parameter_errors(entry["name"], entry["parameters"], found):
                errors[f"{entry['name']}.{key}"] = error
    right = set(verdict.names) == set(truth.verdict)
    open_gap = verdict.gap_before - truth.gap_floor
    closed = (verdict.gap_before - verdict.gap_after) / open_gap if open_gap > LEAST_OPEN_GAP else math.nan
    return CaseScore(case, truth.what, truth.size, hidden, verdict.names, right, errors, closed)


def parameter_errors(effect: str, true: Mapping[str, float], found: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    """How wrong each parameter is. A parameter that was not reported, or is no number, is wrong by 1.

    A phase counts in rad; what is a vector counts as one; a share of the first order counts as that.
    """

    def value(key: str) -> float:
        given = found.get(key)
        return float(given) if isinstance(given, int | float) and not isinstance(given, bool) else math.nan

    def finite(error: float) -> float:
        return error if math.isfinite(error) else 1.0

    fields = fields_of(effect)
    vector = [key for key, field in fields.items() if field.vector]
    if vector and fields[vector[0]].role == "factor":  # only the mismatch counts
        a, b = vector
        with np.errstate(all="ignore"):
            mismatch = np.float64(value(a)) / np.float64(value(b))
        yield "mismatch", finite(abs(mismatch / (true[a] / true[b]) - 1.0))
        return
    if vector:
        off = math.hypot(*(value(key) - true[key] for key in vector))
        yield "offset", finite(off / math.hypot(*(true[key] for key in vector)))
        return
    optional = max((true.get(key, 0.0) for key, f in fields.items() if f.optional and f.role != "phase"), default=0.0)
    for key, right in true.items():
        given, field = value(key), fields.get(key)
        match (field.role, field.optional) if field is not None else ("amplitude", False):
            case ("order", _):
                yield key, finite(float(given != right))
            case ("sign", _):
                yield key, finite(float(given * right <= 0.0))
            case ("phase", False):
                yield key, finite(_angle_between(given, right))
            case ("phase", True):
                if optional > 0.0:
                    yield key, finite(optional * _angle_between(given, right))
            case (_, True):
                yield key, finite(abs(given - right))
            case _:
                yield key, finite(abs(given - right) / abs(right))


def _angle_between(one: float, other: float) -> float:
    """0 to pi; nan where one is no number."""
    off = one - other
    return abs(math.remainder(off, math.tau)) if math.isfinite(off) else math.nan


def _share(values: list[bool]) -> float:
    return float(np.mean(values)) if values else math.nan


def _summary(cases: tuple[CaseScore, ...]) -> dict[str, float]:
    of = {what: [case for case in cases if case.what == what] for what in KINDS}
    known = of["single"] + of["pair"] + of["triple"]
    answered = [case for case in cases if case.said is not None]
    errors = [error for case in cases for key, error in case.errors.items() if not key.endswith(HARD_TO_SEE)]
    closed = [case.gap_closed for case in known if not math.isnan(case.gap_closed)]
    return {
        "strongest_right_single": _share(
            [case.said is not None and case.said[:1] == case.hidden[:1] for case in of["single"]]
        ),
        "exact_single": _share([case.right for case in of["single"]]),
        "exact_larger": _share([case.right for case in of["single"] if case.size != SIZES[0]]),
        "exact_small": _share([case.right for case in of["single"] if case.size == SIZES[0]]),
        "exact_pair": _share([case.right for case in of["pair"]]),
        "exact_triple": _share([case.right for case in of["triple"]]),
        "exact_beside": _share([case.right for case in of["beside"]]),
        "false_names": _share([bool({*(case.said or ())} - {*case.hidden, UNKNOWN}) for case in answered]),
        "named_on_clean": _share([any(name != UNKNOWN for name in case.said or ()) for case in of["none"]]),
        "unknown_on_clean": _share([UNKNOWN in (case.said or ()) for case in of["none"]]),
        "unknown_on_outside": _share([case.right for case in of["outside"]]),
        "known_called_unknown": _share([UNKNOWN in (case.said or ()) for case in known]),
        "parameter_error_median": float(np.median(errors)) if errors else math.nan,
        "parameter_error_p90": float(np.percentile(errors, 90)) if errors else math.nan,
        "gap_closed_median": float(np.median(closed)) if closed else math.nan,
        "gap_closed_p10": float(np.percentile(closed, 10)) if closed else math.nan,
    }


def _confusion(cases: tuple[CaseScore, ...]) -> dict[str, dict[str, int]]:
    """What was said first where one thing, or nothing, was hidden."""
    rows: dict[str, Counter[str]] = {}
    for case in cases:
        if case.what not in ("none", "single", "outside"):
            continue
        hidden = case.hidden[0] if case.hidden else NONE
        said = MISSED if case.said is None else (case.said[0] if case.said else NONE)
        rows.setdefault(hidden, Counter())[said] += 1
    return {name: dict(rows[name]) for name in sorted(rows, key=_rank)}


def _rank(name: str) -> tuple[int, str]:
    """The vocabulary in its order, then none, then what is outside."""
    order = [*EFFECTS, NONE]
    return (order.index(name), "") if name in order else (len(order), name)


def parameter_table(score: Score) -> list[tuple[str, int, float, float]]:
    """effect.parameter, how often found, median and largest error."""
    found: dict[str, list[float]] = {}
    for case in score.cases:
        for key, error in case.errors.items():
            found.setdefault(key, []).append(error)
    order = sorted(found, key=lambda key: (_rank(key.partition(".")[0]), key))
    return [(key, len(found[key]), float(np.median(found[key])), max(found[key])) for key in order]


def size_table(score: Score) -> list[tuple[str, str, int, float]]:
    """Kind, size, cases, share that is exactly right."""
    rights: dict[tuple[str, str], list[bool]] = {}
    for case in score.cases:
        if case.size:
            rights.setdefault((case.what, case.size), []).append(case.right)
    order = sorted(rights, key=lambda key: (KINDS.index(key[0]), SIZES.index(key[1])))
    return [(what, size, len(rights[what, size]), _share(rights[what, size])) for what, size in order]


def markdown(score: Score) -> str:
    """The tables for docs/."""
    counts = Counter(case.what for case in score.cases)
    lines = [
        ", ".join(f"{counts[what]} {what}" for what in KINDS if counts[what]) + ".",
        "",
        "| | found | goal |",
        "|---|---|---|",
    ]
    for name, value in score.summary.items():
        goal = goal_of(name)
        lines.append(f"| {SAYS[name]} | {percent(value)} | {goal} |")
    said = sorted({name for row in score.confusion.values() for name in row}, key=_rank)
    lines += ["", "Said first (columns) where one thing was hidden (rows):", ""]
    lines += ["| hidden | " + " | ".join(said) + " |", "|---" * (len(said) + 1) + "|"]
    for hidden, row in score.confusion.items():
        cells = (str(row[name]) if name in row else "" for name in said)
        lines.append(f"| {hidden} | " + " | ".join(cells) + " |")
    lines += ["", "| hidden | size | cases | exactly right |", "|---|---|---|---|"]
    lines += [f"| {what} | {size} | {n} | {percent(share)} |" for what, size, n, share in size_table(score)]
    lines += ["", "| parameter | cases | median error | largest |", "|---|---|---|---|"]
    lines += [f"| {key} | {n} | {percent(mid)} | {percent(most)} |" for key, n, mid, most in parameter_table(score)]
    return "\n".join(lines) + "\n"


def goal_of(name: str) -> str:
    sense, goal = GOALS.get(name, ("", math.nan))
    return f"{sense} {100.0 * goal:g} %" if name in GOALS else ""


def percent(value: float) -> str:
    return "-" if math.isnan(value) else f"{100.0 * value:.1f} %"
