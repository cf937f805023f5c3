"""Every blind case that was not exactly right, with what its verdict says of it; and what a case took."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.blind.score import CaseScore, Score, verdict_file
from evenspin.blind.truth import Truth
from evenspin.blind.vocabulary import UNKNOWN


def markdown(score: Score, truths: Mapping[str, Truth], results: Path) -> str:
    verdicts = {case.case: _read(results, case.case) for case in score.cases}
    return _seeds(truths) + _misses(score, truths, verdicts) + _time(verdicts)


def _seeds(truths: Mapping[str, Truth]) -> str:
    seeds = sorted({truth.seed for truth in truths.values() if truth.seed is not None})
    simulators = sorted({truth.simulator for truth in truths.values()})
    drawn = f"seed {', '.join(map(str, seeds))}" if seeds else "a seed that the truth file does not have"
    return f"\nDrawn with {drawn}; records by {' and '.join(simulators)}.\n"


def _misses(score: Score, truths: Mapping[str, Truth], verdicts: Mapping[str, Mapping[str, Any]]) -> str:
    missed = [case for case in score.cases if not case.right]
    if not missed:
        return "\nEvery verdict is exactly right.\n"
    lines = ["", "Not exactly right, one by one:", "", "| case | hidden | said | why |", "|---|---|---|---|"]
    for case in missed:
        hidden = f"{case.size} {' + '.join(case.hidden)}".strip() or "nothing"
        why = "; ".join(_reasons(case, truths[case.case], verdicts[case.case])) or "-"
        lines.append(f"| {case.case} | {hidden} | {', '.join(case.said or ()) or 'nothing'} | {why} |")
    return "\n".join(lines) + "\n"


def _reasons(case: CaseScore, truth: Truth, verdict: Mapping[str, Any]) -> list[str]:
    """What the files say about each name that is missing or wrong."""
    if case.said is None:
        return ["no verdict"]
    reasons = []
    details = verdict.get("details") or {}
    spreads = details.get("size_spread") or {}
    weights = {name: weight for names, weight in verdict.get("alternatives") or [] for name in names.split(" + ")}
    nearest = (details.get("nearest") or {}).get("effects") or {}
    for name in truth.verdict:
        if name in case.said:
            continue
        if name == UNKNOWN:
            opened = [f"{truth.gap_alone.get(e['name'], math.nan):.3f}" for e in truth.outside]
            reasons.append(f"what is foreign opens {', '.join(opened)} alone at a floor of {truth.gap_floor:.3f}")
            continue
        opened_alone = truth.gap_alone.get(name, math.nan)
        reason = f"{name} opens {opened_alone:.3f} alone at a floor of {truth.gap_floor:.3f}"
        if name in spreads and spreads[name] is not None:
            reason += f", found, its size differs by {spreads[name]:.2f} over the log"
        elif name in nearest:
            reason += ", found, and not enough"
        elif name in weights:
            reason += f", weighed {weights[name]:.2g}"
        else:
            reason += ", not in any explanation that stood"
        reasons.append(reason)
    said = verdict.get("confidence") or {}
    for name in case.said:
        if name not in truth.verdict:
            sure = f"{said[name]:.2f}" if name in said else "-"
            left = (verdict.get("left") or {}).get("because") or []
            reasons.append(f"{name} is not there, said with a confidence of {sure}" + (f" ({left[0]})" if left else ""))
    return reasons


def _time(verdicts: Mapping[str, Mapping[str, Any]]) -> str:
    details = [verdict.get("details") or {} for verdict in verdicts.values()]
    simulations = [d["simulations"] for d in details if isinstance(d.get("simulations"), int)]
    seconds = [d["seconds"] for d in details if isinstance(d.get("seconds"), int | float)]
    if not simulations or not seconds:
        return ""
    return (
        f"\nSimulations of a log: {np.median(simulations):.0f} median, {max(simulations)} at most. "
        f"Time of a case as it was run: {np.median(seconds):.0f} s median, {max(seconds):.0f} s at most.\n"
    )


def _read(results: Path, case: str) -> Mapping[str, Any]:
    path = verdict_file(results, case)
    content = json.loads(path.read_text(encoding="utf-8")) if path is not None else None
    return content if isinstance(content, dict) else {}
