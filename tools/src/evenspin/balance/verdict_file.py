"""verdict.json: the result format of docs/log-format.md, and all that a torque balance adds to it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from evenspin.balance.analysis import Analysis
from evenspin.balance.confidence import threshold_of
from evenspin.balance.shaft_regression import MACHINE
from evenspin.balance.unexplained import judged_balance, unexplained_of
from evenspin.balance.verdict import OR, Verdict

IDENTIFIED = 1.0  # half width over value: a wider interval counts as not identifiable

UNITS = {
    "torque_a_equiv": "A of q current that makes this torque; beyond the model, where there is one",
    "amplitude_a_equiv": "A of q current that makes this torque",
    "amplitude_half_a_equiv": "A, half of the 95 % interval",
    "inertia_as2_per_rad": "A s^2/rad, J over Kt",
    "viscous_as_per_rad": "A s/rad, B over Kt",
    "order": "1/turn, mechanical",
    "phase_rad": "rad, braking torque A sin(order theta_m + phase)",
    "speed_rad_s": "rad/s",
    "factor": "relative to the model",
    "gap_before": "A rms, residue of the torque balance on the validation stretches",
    "gap_after": "A rms, residue of the torque balance on the validation stretches",
}


def verdict_json(analysis: Analysis, verdict: Verdict) -> dict[str, Any]:
    before, after = gap_of(analysis)
    content: dict[str, Any] = {
        "case": analysis.log.path.name.removesuffix(".gz").removesuffix(".csv"),
        "method": "torque balance in ampere equivalents",
        "verdict": verdict.names,
        "parameters": verdict.parameters,
        "confidence": verdict.confidence,
        "alternatives": [[name, weight] for name, weight, _ in verdict.alternatives],
        "cannot_separate": verdict.cannot_separate,
        "gap_before": before,
        "gap_after": after,
        "units": UNITS,
        "identified": identified(analysis),
        "evidence": _evidence(analysis, verdict),
        "unexplained": verdict.unexplained,
        "warnings": verdict.warnings,
        "repairs": list(analysis.log.repairs),
        "limits": list(analysis.log.limits),
        "time": {
            "speed_estimate_late_s": analysis.lag.delay_s if analysis.lag.known else None,
            "current_log_late_s": analysis.current_later_s,
        },
        "orders": _orders(analysis),
        "line_detection_threshold": _line_threshold(analysis),
        "windings": [
            {"slots": w.slots, "pole_pairs": w.pole_pairs, "covered": w.covered, "meaning": dict(w.meaning)}
            for w in analysis.windings
        ],
        "controller": _controller(analysis),
        "speed_ripple": _ripple(analysis),
        "remainder": _remainder(analysis),
        "left": _left(analysis),
        "clear": is_clear(analysis, verdict),
    }
    return finite(content)


def gap_of(analysis: Analysis) -> tuple[float, float]:
    """Residue before and after, A rms, on the validation stretches, of the balance that this log is good for."""
    found = judged_balance(analysis)
    return (found.before_a, found.after_a) if found is not None else (math.nan, math.nan)


def identified(analysis: Analysis) -> dict[str, dict[str, float]]:
    """Parameters of the shaft with 95 % intervals, absolute, whatever the model gives; only what the log identifies."""
    friction, nominal = analysis.friction, analysis.nominal
    if friction is None or "inertia" in friction.impossible:
        return {}
    known = {}
    if nominal is not None:
        known = {
            "inertia": nominal.inertia_as2,
            "viscous_friction": nominal.viscous_as,
            "coulomb_friction": nominal.coulomb_a,
            "load_torque": nominal.load_a,
        }
    found: dict[str, dict[str, float]] = {}
    for name, half in friction.half.items():
        effect = name.split(".")[0]
        value = friction.final[name] + known.get(effect, 0.0)
        if OR in effect:  # beyond the model, whichever of them it is
            name = ("drag" if nominal is None else "drag_beyond_model") + ".torque_a_equiv"
        elif half > IDENTIFIED * abs(value):
            continue
        found[name] = {"value": value, "half": half, "low": value - half, "high": value + half}
    drag = ("drag" if nominal is None else "drag_beyond_model") + ".torque_a_equiv"
    angle = analysis.angle
    if OR in friction.drive.friction and drag not in found and angle is not None:
        speed_rad_s = float(np.median(np.abs(angle.motion.speed_rad_s[angle.rows])))
        whole = angle.drag_a + (nominal.coulomb_a + nominal.viscous_as * speed_rad_s if nominal is not None else 0.0)
        value, half = angle.drag_a, math.hypot(angle.drag_half_a, MACHINE * whole)
        found[drag] = {"value": value, "half": half, "low": value - half, "high": value + half}
    return found


def _evidence(analysis: Analysis, verdict: Verdict) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = [
        {"effect": name, "named": True, "takes_a_rms": verdict.takes_a.get(name), **verdict.parameters.get(name, {})}
        for name in verdict.names
    ]
    rows += [{"effect": effect, "named": False, "why": why} for effect, why in verdict.against]
    rows += [{"effect": effect, "named": False, "alternative": why} for effect, _, why in verdict.alternatives]
    return rows


def is_clear(analysis: Analysis, verdict: Verdict) -> bool:
    """Everything has a name or is explained down to noise."""
    left = unexplained_of(analysis)
    at_noise = left is not None and not left.significant
    return analysis.judges and at_noise and not verdict.unexplained and "unknown" not in verdict.names


def _left(analysis: Analysis) -> dict[str, Any] | None:
    left = unexplained_of(analysis)
    if left is None:
        return None
    return {
        "rms_a": left.rms_a,
        "noise_a": left.noise_a,
        "more_than_noise": left.significant,
        "where": list(left.where),
    }


def _orders(analysis: Analysis) -> list[dict[str, Any]]:
    if analysis.angle is None:
        return []
    return [
        {
            "order": int(each.line.order),
            "amplitude_a_equiv": each.line.amplitude_a if analysis.inertia_known else None,
            "half_a_equiv": each.half_a,
            "phase_rad": each.line.phase_rad,
            "noise_a": each.noise_a,
            "halves_differ": each.agree,
            "in_both_halves": each.validated,
        }
        for each in analysis.angle.lines
    ]


def _line_threshold(analysis: Analysis) -> dict[str, Any] | None:
    at = threshold_of(analysis)
    if at is None:
        return None
    return {
        "up_to_order": at.up_to_order,
        "smallest_a_equiv": at.smallest_a,
        "smallest_at_order": at.smallest_at,
        "largest_a_equiv": at.largest_a,
        "largest_at_order": at.largest_at,
        "a_equiv_by_order": {str(order): threshold_a for order, threshold_a in analysis.thresholds_a.items()},
    }


def _controller(analysis: Analysis) -> dict[str, Any] | None:
    found = analysis.controller
    if found is None:
        return None
    return {
        "gain_as_per_rad": found.gain_as_per_rad,
        "late_s": found.lag_s,
        "explained": found.explained,
        "parts": [
            {
                "start_s": part.start_s,
                "end_s": part.end_s,
                "compensated": not part.plain,
                "current_beside_controller_a_rms": part.added_a,
                "speed_ripple_rad_s_rms": part.speed_ripple_rad_s,
                "current_ripple_a_rms": part.current_ripple_a,
            }
            for part in found.parts
        ],
    }


def _ripple(analysis: Analysis) -> dict[str, Any] | None:
    ripple = analysis.ripple
    if ripple is None:
        return None
    return {
        "from_s": ripple.part.start_s,
        "to_s": ripple.part.end_s,
        "measured_rad_s_rms": ripple.measured_rms,
        "simulated_rad_s_rms": ripple.simulated_rms,
        "simulated_without_rad_s_rms": ripple.without_rms,
        "ratio": ripple.simulated_rms / ripple.measured_rms if ripple.measured_rms > 0.0 else None,
        "orders": [{"order": k, "measured_rad_s": m, "simulated_rad_s": s} for k, m, s in ripple.orders],
    }


def _remainder(analysis: Analysis) -> dict[str, Any] | None:
    if analysis.friction is None:
        return None
    left = analysis.friction.remainder
    return {
        "rms_a": left.rms_a,
        "below_rad_s": left.slow_below_rad_s,
        "below_rms_a": left.slow_rms_a,
        "above_rms_a": left.fast_rms_a,
        "follows_speed_and_acceleration_a": left.predictable_rms_a,
        "curvature_a_per_rad2_s2": left.curvature,
        "curvature_p": left.curvature_p,
        "dry_friction_drift_share": left.drift_share,
        "dry_friction_drift_p": left.drift_p,
    }


def finite(value: Any) -> Any:
    """JSON has no not-a-number: null instead, and NumPy's numbers become Python's."""
    if isinstance(value, dict):
        return {str(key): finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [finite(each) for each in value]
    if isinstance(value, str | bool | int) or value is None:
        return value
    if hasattr(value, "item"):
        return finite(value.item())
    return float(value) if math.isfinite(value) else None
