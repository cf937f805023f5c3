"""Friction and load: which of them are named, and why the others are not."""

from __future__ import annotations

import numpy as np

from evenspin.balance.analysis import Analysis
from evenspin.balance.confidence import LEAST_CONFIDENCE
from evenspin.balance.formatting import amperes
from evenspin.balance.friction import CHANCE, SMALL, Evidence, FrictionResult
from evenspin.balance.nominal_model import Nominal
from evenspin.balance.residual_tests import Remainder
from evenspin.balance.unexplained import unexplained_of
from evenspin.balance.verdict import OR, Numbers, Verdict, out_of_range

MODEL_EDGE = 0.2  # a line or a friction of the model that is found again within this is not missing
PREDICTABLE_SHARE = (
    0.5  # of the residue's rms that follows speed and acceleration: with nothing named, something is missing
)
DRIFT_EDGE = 0.2
BENDS = 0.005  # of the residue that bending takes away
SLOW_RATIO = 3.0  # of the residue at low speed to that at high speed, to be worth a word
NOISE_LSB_A = 1e-3  # below a few of these it is the resolution of a current sensor
UNCERTAIN = 0.7  # half width over value, above which nothing is named
STRIBECK_SIGMAS = 4.0  # widths of the smoothing that low speed must last


def name_friction(analysis: Analysis, verdict: Verdict) -> None:
    found, nominal = analysis.friction, analysis.nominal
    assert found is not None
    _cannot_tell(analysis, verdict)
    if "viscous_friction" in found.impossible:
        verdict.unexplained.append(
            "the drag falls with rising speed, so that viscous_friction would be negative: no friction, but a "
            "controller that answers the ripple, a limit that was reached, or a load that depends on the speed; "
            "friction is given as one mean drag"
        )
    for evidence in found.evidence:
        effect = evidence.effect
        parameters = _values(found, evidence)
        if evidence.named and OR in effect and parameters["torque_a_equiv"] < 0.0:
            effect = "load_torque" if "load_torque" in effect else effect
        if not evidence.named:
            verdict.against.append((effect, evidence.reason))
            continue
        if nominal is not None and _in_model(effect, parameters, nominal):
            continue
        if evidence.small:
            verdict.against.append((effect, f"less than {100.0 * SMALL:.0f} % of the current: too small to name"))
            continue
        value, half = parameters["torque_a_equiv"], found.half.get(f"{evidence.effect}.torque_a_equiv")
        if half is None:
            verdict.against.append((effect, "it is not in the fit of the whole log, which gives its interval"))
            continue
        if half > UNCERTAIN * abs(value):
            verdict.against.append(
                (effect, f"{amperes(value)} +- {amperes(half)}: the interval is too wide to name it")
            )
            continue
        wrong = out_of_range(effect, _whole(effect, parameters, nominal))
        if wrong is not None:
            verdict.against.append((effect, wrong))
            verdict.unexplained.append(f"{effect}: {wrong}")
            continue
        takes_a = max(evidence.validation_drop * found.before_rms_a, _size(analysis, evidence))
        confidence = _confidence(analysis, evidence, takes_a)
        if confidence < LEAST_CONFIDENCE:
            size = f"{amperes(value)} +- {amperes(half)}"
            verdict.against.append((effect, f"{size}: confidence {confidence:.2f}, too little to name"))
            continue
        verdict.name(effect, parameters, confidence, takes_a)
        if effect == "stribeck_friction":
            _stribeck_seen(analysis, parameters["speed_rad_s"], verdict)


def _values(found: FrictionResult, evidence: Evidence) -> Numbers:
    """Where it is in the balance, the values of the whole log."""
    whole = {key: f"{evidence.effect}.{key}" for key in evidence.values}
    known = dict(zip(found.final.names, found.final.value.tolist(), strict=True))
    return {key: known.get(name, evidence.values[key]) for key, name in whole.items()}


def _whole(effect: str, parameters: Numbers, nominal: Nominal | None) -> Numbers:
    """With what the model has of it already."""
    known = nominal.coulomb_a if nominal is not None and effect == "coulomb_friction" else 0.0
    return {key: value + known if key == "torque_a_equiv" else value for key, value in parameters.items()}


def _size(analysis: Analysis, evidence: Evidence) -> float:
    """Of the torque that this effect makes, A rms."""
    return abs(evidence.values.get("torque_a_equiv", 0.0)) if evidence.effect != "stribeck_friction" else 0.0


def _confidence(analysis: Analysis, evidence: Evidence, takes_a: float) -> float:
    """Chance that it is none by accident, how narrow its interval is, and how much of the log it leaves unexplained."""
    found = analysis.friction
    assert found is not None
    name = f"{evidence.effect}.torque_a_equiv"
    value, half = abs(evidence.values.get("torque_a_equiv", 0.0)), found.half.get(name, 0.0)
    return (1.0 - evidence.p_value) * confidence_factor(analysis, takes_a, half / max(value, 1e-12))


def confidence_factor(analysis: Analysis, takes_a: float, share: float) -> float:
    """1 where all is explained and the value is exact. `share`: half width over value."""
    left = unexplained_of(analysis)
    rest = left.beyond_a / max(takes_a, 1e-12) if left is not None else 1.0
    return 1.0 / ((1.0 + rest**2) * (1.0 + share**2))


def _cannot_tell(analysis: Analysis, verdict: Verdict) -> None:
    drive = analysis.drive
    names = drive.drag()
    if len(names) == 1:
        return
    verdict.apart(drive.friction)
    driven = "one direction" if drive.one_way else "both directions"
    driven += " and near one speed" if drive.one_speed else ""
    verdict.warnings.append(
        f"the log turns in {driven}: {drive.friction} cannot be separated; {drive.separator()} would separate them"
    )


def _stribeck_seen(analysis: Analysis, speed_rad_s: float, verdict: Verdict) -> None:
    """A low speed that is passed within the smoothing does not separate torque and speed of the Stribeck rise."""
    found = analysis.friction
    assert found is not None
    slow = found.fit_rows & (np.abs(found.motion.raw_speed_rad_s) < speed_rad_s)
    if not np.any(slow):
        return
    passed_s = speed_rad_s / max(float(np.median(np.abs(found.motion.accel_rad_s2[slow]))), 1e-9)
    if passed_s < STRIBECK_SIGMAS * found.motion.smooth.sigma_s:
        verdict.warnings.append(
            f"low speed is passed in {1e3 * passed_s:.1f} ms: torque and speed of stribeck_friction are not "
            "identifiable from this log, only their product; reverse more slowly"
        )


def _in_model(effect: str, parameters: Numbers, nominal: Nominal) -> bool:
    known = {
        "coulomb_friction": nominal.coulomb_a,
        "load_torque": nominal.load_a,
        "stribeck_friction": nominal.stribeck_a,
    }
    size = sum(abs(known.get(each, 0.0)) for each in effect.split(OR))
    return size > 0.0 and abs(parameters.get("torque_a_equiv", np.inf)) < MODEL_EDGE * size


def describe_residual(analysis: Analysis, verdict: Verdict) -> None:
    found = analysis.friction
    assert found is not None
    left = found.remainder
    if left.curvature_p < CHANCE and left.curvature_drop > BENDS:
        how = "less" if left.curvature < 0.0 else "more"
        verdict.unexplained.append(
            f"friction grows {how} than linearly with speed (p = {left.curvature_p:.1g}): no effect of the table does "
            "that, so it stays unexplained"
        )
    if left.predictable_rms_a > PREDICTABLE_SHARE * left.rms_a:
        verdict.unexplained.append(
            f"of {amperes(left.rms_a)} rms that are left, {amperes(left.predictable_rms_a)} follow speed and "
            "acceleration"
        )
    if stands_out_at_low_speed(left):
        verdict.unexplained.append(
            f"below {left.slow_below_rad_s:.0f} rad/s {amperes(left.slow_rms_a)} rms are left, above only "
            f"{amperes(left.fast_rms_a)}: torque tied to the angle has this effect where the speed passes zero; a slow "
            "run at constant speed would show its orders"
        )
    if left.drift_p < CHANCE and abs(left.drift_share) > DRIFT_EDGE:
        verdict.unexplained.append(
            f"the dry friction changes by {100.0 * left.drift_share:+.0f} % over the log (drift)"
        )


def stands_out_at_low_speed(left: Remainder) -> bool:
    return left.slow_rms_a > SLOW_RATIO * max(left.fast_rms_a, NOISE_LSB_A)
