"""verdict.json: the result format of docs/gap.md, for logs that the equations of the machine are held against."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from evenspin.balance.verdict_file import finite
from evenspin.driven.findable import Findable
from evenspin.driven.judge import Gap, Verdict, gaps_of
from evenspin.driven.read import Log, Nominal
from evenspin.empirical.effect import effects_of
from evenspin.empirical.verdict import term_json
from evenspin.gap.intervals import reported_parameters
from evenspin.weakform.analysis import Explained
from evenspin.weakform.beyond import Beyond
from evenspin.weakform.terms import Kind

METHOD = "equations of the machine, driven by the measured voltages and currents"
TORQUE_METHOD = "torque equation of the machine, driven by the measured currents"


def method_of(logs: list[Log]) -> str:
    return METHOD if any(log.signals.has_voltages for log in logs) else TORQUE_METHOD


def verdict_json(
    name: str,
    found: Explained,
    verdict: Verdict,
    nominal: Nominal,
    logs: list[Log],
    table: list[Findable],
    advised: str,
) -> dict[str, Any]:
    before, after = gap_of(verdict.gaps)
    content = {
        "case": name,
        "method": method_of(logs),
        "tolerances": found.tolerances.name,
        "verdict": [verdict.name(each) for each in verdict.names],
        "parameters": {verdict.name(effect): reported_parameters(effect, params) for effect, params in verdict.effects},
        "confidence": {verdict.name(effect): value for effect, value in verdict.confidence.items()},
        "alternatives": [[other, weight] for other, weight in verdict.alternatives],
        "cannot_separate": verdict.cannot_separate,
        "gap_before": before,
        "gap_after": after,
        "gap_floor": 1.0,
        "gap_closed": closed(before, after),
        "gap_records": _records(verdict),
        "intervals": {
            verdict.name(effect): {i.parameter: i.as_json() for i in each} for effect, each in verdict.intervals.items()
        },
        "units": {"gap": "rms of what the equations leave on stretches that no fit saw, over what noise alone leaves"},
        "unit": _unit(found),
        "can_be_found": {each.effect: {"times_least_size": each.times, "why": each.why} for each in table},
        "record_next": advised,
        "unexplained": verdict.unexplained,
        "warnings": [*verdict.warnings, *nominal.assumed],
        "repairs": {log.signals.name: list(log.repairs) for log in logs},
        "doubts": {log.signals.name: list(log.doubts) for log in logs},
        "clear": clear(verdict),
        "details": {
            "nearest": verdict.nearest,
            "choices": [{"terms": sorted(c.names), "cost": c.cost - found.rivals[0].cost} for c in found.rivals[:8]],
        },
    }
    return finite(content)


def empirical_json(beyond: Beyond, verdict: Verdict) -> dict[str, Any]:
    """Terms that no effect of the table is, and the gap with the effects alone."""
    before, known = gap_of(gaps_of(replace(beyond.found, after=beyond.after_known)))
    after = gap_of(verdict.gaps)[1]
    empirical = [term_json(term) for term in beyond.evidence]
    _, left = effects_of(beyond.evidence)
    return finite(
        {"empirical": empirical, "gap_after_known": known if empirical else after, "empirical_not_simulated": left}
    )


def gap_of(gaps: list[Gap]) -> tuple[float, float]:
    """Before and after, in units of what noise alone leaves, over all logs and equations."""
    if not gaps:
        return math.nan, math.nan
    before = np.array([gap.before / gap.floor for gap in gaps])
    after = np.array([gap.after / gap.floor for gap in gaps])
    return float(np.sqrt(np.mean(before**2))), float(np.sqrt(np.mean(after**2)))


def closed(before: float, after: float) -> float:
    return (before - after) / (before - 1.0) if before > 1.0 else math.nan


def clear(verdict: Verdict) -> bool:
    """Everything has a name or is explained down to noise."""
    return not verdict.unknown and not verdict.unexplained


def _records(verdict: Verdict) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for gap in verdict.gaps:
        record = found.setdefault(gap.log, {"before": {}, "after": {}, "floor": {}})
        for key in ("before", "after", "floor"):
            record[key][gap.equation] = getattr(gap, key)
    return found


def _unit(found: Explained) -> dict[str, float]:
    """What this unit and each log are off the model by, and what was found along with it."""
    return {term.name: float(found.point[term.name][0]) for term in found.model.terms if term.kind is Kind.UNIT}
