"""How good the verdicts on logs of other drives are. A log without voltages is judged by what it can show."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.blind.bench_effects import ELECTRICAL
from evenspin.blind.log_visible import SEEN
from evenspin.blind.logs import LogTruth
from evenspin.blind.score import NONE, parameter_errors
from evenspin.blind.truth import fields_of
from evenspin.blind.vocabulary import UNKNOWN
from evenspin.errors import InputError

OR = " or "  # between the names of effects that a log does not separate
EQUIVALENT = "_a_equiv"  # torque in amperes of q current
GOALS = {
    "exact_single": (">=", 0.90),
    "exact_pair": (">=", 0.75),
    "exact_single_torque_only": (">=", 0.90),
    "exact_pair_torque_only": (">=", 0.75),
    "named_without_voltages": ("<=", 0.0),
    "clean": (">=", 0.97),
    "unknown_on_outside": (">=", 0.95),
    "wrong_name": ("<=", 0.03),
    "parameter_error_median": ("<=", 0.03),
    "coverage": (">=", 0.90),
    "sure_and_right": (">=", 0.90),
    "slowest_s": ("<=", 60.0),
}
SAYS = {
    "read": "read without a question",
    "exact_single": "exact set right, one effect hidden, voltages in the log",
    "exact_pair": "exact set right, two effects hidden, voltages in the log",
    "exact_single_torque_only": "exact set right, one torque effect hidden, no voltages",
    "exact_pair_torque_only": "exact set right, two torque effects hidden, no voltages",
    "shown_single": "the same, of the logs that show the effect: one, with voltages",
    "shown_pair": "two, with voltages",
    "shown_single_torque_only": "one, no voltages",
    "shown_pair_torque_only": "two, no voltages",
    "named_without_voltages": "any other name, where only voltages could show the effect",
    "clean": "no name, nothing hidden",
    "unknown_on_outside": "unknown and no name, effect outside the vocabulary",
    "shown_outside": "the same, of the logs that show it",
    "wrong_name": "a name of what is not there, of all logs",
    "undecided": "the right effect or another one, undecided, of all logs with one",
    "silent": "no name at all, of all logs with an effect that they show",
    "parameter_error_median": "parameter error, median",
    "parameter_error_p90": "parameter error, 90th percentile",
    "coverage": "intervals of 95 % that hold the truth",
    "sure_and_right": "names with a confidence of 0.9 or more that are right",
    "median_s": "time of one log, median",
    "slowest_s": "time of one log, longest",
}
IN_SECONDS = ("median_s", "slowest_s")


@dataclass(frozen=True, slots=True)
class Run:
    """What the command did."""

    seconds: float
    status: int
    message: str


@dataclass(frozen=True, slots=True)
class LogScore:
    log: str
    truth: LogTruth
    run: Run | None
    said: tuple[str, ...] | None  # None: no verdict
    exact: bool
    undecided: bool  # exact, but for a name that leaves it open
    wrong: tuple[str, ...]  # names of what is not there
    errors: Mapping[str, float]
    misses: Sequence[tuple[str, float]]  # distance of the truth from the middle of its interval, in half widths
    sure: Sequence[tuple[float, bool]]  # confidence of every name, and whether it is right

    @property
    def hidden(self) -> tuple[str, ...]:
        return (*self.truth.effects, *self.truth.outside)

    @property
    def visible(self) -> bool:
        """Whether the log has what shows all that is hidden."""
        return shows(self.truth)

    @property
    def shown(self) -> bool:
        """Whether all that is hidden stands out of the noise of the log, which says nothing of what is alike."""
        sizes = self.truth.shown
        return set(sizes) == set(self.hidden) and all(size >= SEEN for size in sizes.values())


def shows(truth: LogTruth) -> bool:
    if truth.voltage:
        return True
    return not any(name in ELECTRICAL or (name == "torque_constant" and not truth.load) for name in truth.effects)


def score_logs(truths: Mapping[str, LogTruth], results: Path) -> list[LogScore]:
    if not results.is_dir():
        raise InputError("--results", "folder", str(results), "an existing folder", "`gap blind run-logs` writes it")
    return [score_log(log, truth, *read_result(results, log)) for log, truth in truths.items()]


def read_result(results: Path, log: str) -> tuple[Run | None, dict[str, Any] | None]:
    run_file, verdict_file = results / f"{log}.run.json", results / log / "verdict.json"
    run = Run(**json.loads(run_file.read_text(encoding="utf-8"))) if run_file.is_file() else None
    verdict = json.loads(verdict_file.read_text(encoding="utf-8")) if verdict_file.is_file() else None
    return run, verdict


def score_log(log: str, truth: LogTruth, run: Run | None, verdict: Mapping[str, Any] | None) -> LogScore:
    if verdict is None:
        return LogScore(log, truth, run, None, False, False, (), {}, (), ())
    said = tuple(str(name) for name in verdict.get("verdict") or () if name != NONE)
    hidden = set(truth.effects) | ({UNKNOWN} if truth.outside else set())
    wrong = tuple(name for name in said if name != UNKNOWN and not hidden & set(name.split(OR)))
    meant = {next(iter(hidden & set(name.split(OR))), name) for name in said}
    expected = hidden if shows(truth) else set()
    if not shows(truth):  # silence is right, and so is `unknown`, or the effect among others
        meant -= {UNKNOWN, *hidden}
    exact = meant == expected
    open_names = any(OR in name for name in said)
    confidence = verdict.get("confidence") or {}
    sure = tuple((float(value), bool(hidden & set(name.split(OR)))) for name, value in confidence.items())
    errors = dict(_errors(truth, said, verdict.get("parameters") or {}))
    misses = tuple(_misses(truth, _intervals(verdict)))
    return LogScore(log, truth, run, said, exact and not open_names, exact and open_names, wrong, errors, misses, sure)


def _errors(truth: LogTruth, said: Sequence[str], found: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    for name, true in truth.effects.items():
        if name in said and isinstance(found.get(name), Mapping):
            for key, error in parameter_errors(name, true, _in_nm(found[name], truth)):
                yield f"{name}.{key}", error


def _in_nm(values: Mapping[str, Any], truth: LogTruth) -> dict[str, Any]:
    """Ampere equivalents as torque, with the torque constant of the model file."""
    result = dict(values)
    for key, value in values.items():
        if key.endswith(EQUIVALENT) and isinstance(value, int | float):
            result[key.removesuffix(EQUIVALENT) + "_nm"] = value * truth.nm_per_a
    return result


def _intervals(verdict: Mapping[str, Any]) -> dict[tuple[str, str], tuple[float, float, bool]]:
    """Low, high, and whether in ampere equivalents, by effect and parameter."""
    found = {}
    for name, parameters in (verdict.get("intervals") or {}).items():
        for key, interval in parameters.items():
            plain = key.removesuffix(EQUIVALENT) + ("_nm" if key.endswith(EQUIVALENT) else "")
            found[name, plain] = (float(interval["low"]), float(interval["high"]), key.endswith(EQUIVALENT))
    return found


def _misses(
    truth: LogTruth, intervals: Mapping[tuple[str, str], tuple[float, float, bool]]
) -> Iterator[tuple[str, float]]:
    for name, true in truth.effects.items():
        fields = fields_of(name)
        for key, value in true.items():
            if (name, key) not in intervals:
                continue
            low, high, equivalent = intervals[name, key]
            scale = truth.nm_per_a if equivalent else 1.0
            half, middle = 0.5 * scale * (high - low), 0.5 * scale * (high + low)
            phase = key in fields and fields[key].role == "phase"
            if not half > 0.0 or (phase and fields[key].optional):
                continue
            off = math.remainder(middle - value, math.tau) if phase else middle - value
            yield f"{name}.{key}", abs(off) / half


def summary_of(scores: Sequence[LogScore]) -> dict[str, float]:
    """The figures of SAYS; nan where no log counts."""
    read = [score for score in scores if score.said is not None]
    known = [s for s in scores if s.truth.kind in ("single", "pair")]
    seen = [s for s in known if s.visible]
    stands_out = [s for s in seen if s.shown]
    errors = [error for s in scores for key, error in s.errors.items() if not key.endswith("damping_ratio")]
    misses = [miss for s in scores for _, miss in s.misses]
    sure = [right for s in scores for said, right in s.sure if said >= 0.9]
    seconds = [s.run.seconds for s in scores if s.run is not None]

    def share(values: Sequence[bool]) -> float:
        return float(np.mean(values)) if values else math.nan

    def exact(kind: str, voltages: bool, of: Sequence[LogScore] = seen) -> float:
        return share([s.exact for s in of if s.truth.kind == kind and bool(s.truth.voltage) == voltages])

    return {
        "read": share([s.said is not None for s in scores]),
        "exact_single": exact("single", True),
        "exact_pair": exact("pair", True),
        "exact_single_torque_only": exact("single", False),
        "exact_pair_torque_only": exact("pair", False),
        "shown_single": exact("single", True, stands_out),
        "shown_pair": exact("pair", True, stands_out),
        "shown_single_torque_only": exact("single", False, stands_out),
        "shown_pair_torque_only": exact("pair", False, stands_out),
        "named_without_voltages": share([bool(s.wrong) for s in known if not s.visible and s.said is not None]),
        "clean": share([s.said == () for s in scores if s.truth.kind == "none"]),
        "unknown_on_outside": share([s.exact for s in scores if s.truth.kind == "outside"]),
        "shown_outside": share([s.exact for s in scores if s.truth.kind == "outside" and s.shown]),
        "wrong_name": share([bool(s.wrong) for s in scores]),
        "undecided": share([s.undecided for s in seen]),
        "silent": share([not s.said for s in read if s in seen]),
        "parameter_error_median": float(np.median(errors)) if errors else math.nan,
        "parameter_error_p90": float(np.percentile(errors, 90)) if errors else math.nan,
        "coverage": share([miss <= 1.0 for miss in misses]),
        "sure_and_right": share(sure),
        "median_s": float(np.median(seconds)) if seconds else math.nan,
        "slowest_s": max(seconds, default=math.nan),
    }


def missed(summary: Mapping[str, float]) -> list[str]:
    """Goals that are not reached."""
    return [
        name
        for name, (sense, goal) in GOALS.items()
        if not math.isnan(summary[name]) and not (summary[name] >= goal if sense == ">=" else summary[name] <= goal)
    ]


def shown(name: str, value: float) -> str:
    if math.isnan(value):
        return "-"
    return f"{value:.1f} s" if name in IN_SECONDS else f"{100.0 * value:.1f} %"


def goal_of(name: str) -> str:
    if name not in GOALS:
        return ""
    sense, goal = GOALS[name]
    return f"{sense} {goal:.0f} s" if name in IN_SECONDS else f"{sense} {goal:.0%}"
