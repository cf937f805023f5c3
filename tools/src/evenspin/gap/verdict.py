"""verdict.json: the result format of docs/log-format.md, and beside it all that a reader may want to know."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from evenspin.empirical.verdict import term_json
from evenspin.gap.intervals import reported_parameters
from evenspin.gap.periodic import as_json
from evenspin.gap.result import CaseResult, inseparable
from evenspin.gap.support import Support
from evenspin.gap.thresholds_effects import LINE_RATIO
from evenspin.gap.thresholds_evidence import DAMPING_SHARE, PARAMETER_SHARE, SATURATION_SHARE
from evenspin.log.gap import RecordGap, gap_of_records
from evenspin.log.tolerance import TOLERANCES

VERDICT = "verdict.json"


def verdict_json(result: CaseResult) -> dict[str, Any]:
    finding = result.finding
    return {
        "case": result.name,
        "verdict": list(result.verdict),
        "parameters": {name: reported_parameters(name, result.effects[name]) for name in finding.named},
        "confidence": {name: round(value, 4) for name, value in result.confidence.items()},
        "shares": {name: real(share) for name, share in result.shares.items()},
        "support": {name: [support_json(s) for s in result.support[name]] for name in finding.named},
        "alternatives": [[" + ".join(names), round(weight, 4)] for names, weight in result.other],
        "gap_before": real(result.before.gap),
        "gap_after": real(result.after.gap),
        "gap_after_known": real((result.known or result.after).gap),
        "gap_floor": real(gap_of_records(result.noise_floor)),
        "gap_closed": real(result.closed),
        "gap_records": _records(result),
        "intervals": _intervals(result),
        "intervals_note": (
            "95 %; standard deviations of the fit times "
            f"{result.intervals.inflation:.2f}, the factor by which simulated healthy units scatter more; "
            "the tolerance of a unit where the effect is one, only larger; "
            f"and {100 * PARAMETER_SHARE:.0f} % for what the model of an effect may be off itself "
            f"({100 * SATURATION_SHARE:.0f} % of a saturation current, {100 * DAMPING_SHARE:.0f} % of a damping)"
        ),
        "cannot_separate": {name: list(inseparable(result, name)) for name in finding.named},
        "warnings": list(result.warnings),
        "left": left_json(result),
        "empirical": [term_json(term) for term in result.rest.terms],
        "empirical_not_simulated": list(result.rest.not_simulated),
        "details": _details(result),
    }


def support_json(support: Support) -> dict[str, Any]:
    """A group of features that speaks for a name; residuals in standard deviations of healthy units."""
    return {
        "record": support.record,
        "signal": support.signal,
        "what": support.what,
        "share": round(support.share, 4),
        "without_sigma": support.without,
        "with_it_sigma": support.with_it,
    }


def left_json(result: CaseResult) -> dict[str, Any]:
    """What the model does not explain, and whether that is noise."""
    finding = result.finding
    expected = finding.expected_cost
    return {
        "is_noise": not finding.unknown,
        "cost": finding.model.cost,
        "cost_with_empirical": result.rest_cost,
        "cost_of_sound_units": {"mean": expected.mean, "sigma": expected.sigma},
        "because": because(result),
        "periodic": as_json(finding.periodic),
        "lines": [
            {
                "record": line.record,
                "signal": line.signal,
                "speed_rad_s": line.speed_rad_s,
                "hz": line.hz,
                "order": real(line.order),
                "amplitude": line.amplitude,
                "power_over_noise": line.ratio,
            }
            for line in finding.lines
            if line.ratio > LINE_RATIO
        ],
    }


def because(result: CaseResult) -> list[str]:
    """Why it is unknown; empty where it is not."""
    finding = result.finding
    if not finding.unknown:
        return []
    reasons = []
    best = "what is named" if result.partial and set(finding.named) == set(finding.model.z) else "the best explanation"
    if finding.expected_cost.excess(finding.model.cost) > finding.expected_cost.limit:
        reasons.append(
            f"{best} leaves a cost of {finding.model.cost:.0f}; healthy units have "
            f"{finding.expected_cost.mean:.0f} +- {finding.expected_cost.sigma:.0f}"
        )
    for name in finding.changes:
        reasons.append(
            f"the size of {name} is not the same over the log: it differs by {100 * finding.size_spread[name]:.0f} % "
            "from part to part, as of something that drifts, or of another law"
        )
    reasons += [
        f"something foreign repeats: {line.text}; the names are those of the log without it"
        for line in finding.periodic
    ]
    left = [line for line in finding.lines if line.ratio > LINE_RATIO]
    if left:
        hz = sorted({round(line.hz) for line in left})
        reasons.append(f"{len(left)} spectral lines that no known order takes up, at {', '.join(map(str, hz[:8]))} Hz")
    return reasons


def _details(result: CaseResult) -> dict[str, Any]:
    finding = result.finding
    details: dict[str, Any] = {
        "effects": {name: dict(params) for name, params in result.effects.items()},
        "cost_each_takes_away": {name: float(gain) for name, gain in finding.weights.items()},
        "cost_before": finding.before,
        "tolerance": {
            t.name: {"deviation": float(d), "sigma": t.sigma} for t, d in zip(TOLERANCES, result.delta, strict=True)
        },
        "steps": [
            {"effects": list(step.names), "cost": step.cost, "gap": real(step.outcome.gap)} for step in result.steps
        ],
        "experiments": list(result.case.experiments),
        "simulations": finding.simulations,
        "seconds": round(result.seconds, 1),
    }
    if finding.model.z:
        details["size_spread"] = {name: real(spread) for name, spread in finding.size_spread.items()}
    if result.nearest is not None and finding.model.z:
        details["nearest"] = {
            "note": "the known effects that come nearest; they do not explain the log and were not added",
            "effects": {name: dict(params) for name, params in result.nearest_effects.items()},
            "gap": real(result.nearest.gap),
        }
    return details


def _records(result: CaseResult) -> dict[str, Any]:
    def by_record(records: Sequence[RecordGap]) -> dict[str, dict[str, Any]]:
        return {r.record: {"gap": r.gap, "rms": dict(r.rms)} for r in records}

    before, after, floor = (
        by_record(result.before.records),
        by_record(result.after.records),
        by_record(result.noise_floor),
    )
    return {name: {"before": before[name], "after": after[name], "floor": floor[name]} for name in before}


def _intervals(result: CaseResult) -> dict[str, Any]:
    return {
        name: {interval.parameter: interval.as_json() for interval in result.intervals.of(name)}
        for name in result.finding.named
    }


def real(value: float) -> float | None:
    """JSON has no not-a-number."""
    return float(value) if math.isfinite(value) else None
