"""From evidence to names: what is missing, with which parameters, what else it could be, and what stays unexplained."""

from __future__ import annotations

import numpy as np

from evenspin.balance.analysis import Analysis
from evenspin.balance.friction import CHANCE, SMALL, VALID_SHARE, Evidence, FrictionResult
from evenspin.balance.left import SURE, left_of, milli
from evenspin.balance.naming_lines import moved_lines, name_lines
from evenspin.balance.nominal import Nominal
from evenspin.balance.remainder import Remainder
from evenspin.balance.shaft import INERTIA, VISCOUS
from evenspin.balance.verdict import OR, Numbers, Verdict, out_of_range

# A sound unit differs from its data sheet by as much (docs/log-format.md): 2.5 times inertia 1.2 % with flux 0.4 %, and
# viscous friction 4 %.
INERTIA_EDGE, VISCOUS_EDGE = 0.032, 0.10
MODEL_EDGE = 0.2  # a line or a friction of the model that is found again within this is not missing
TOLD_SHARE = 0.5  # of the residue's rms that speed and acceleration tell: with nothing named, something is missing
DRIFT_EDGE = 0.2
BENDS = 0.005  # of the residue that bending takes away
SLOW_RATIO = 3.0  # of the residue at low speed to that at high speed, to be worth a word
NOISE_LSB_A = 1e-3  # below a few of these it is the resolution of a current sensor
SURE_SHARE = 0.3  # half width over value of a factor, above which nothing is named
UNITS_OFF = {
    2.0 * np.pi / 60.0: "the speed is in r/min, not in rad/s",
    np.pi / 180.0: "the motion is in degrees, not in rad",
    2.0 * np.pi: "the motion is in turns, not in rad",
    1e3: "the current is in mA, not in A",
}
UNIT_BAND = 0.1  # of the logarithm of such a ratio
VAGUE = 0.7  # half width over value, above which nothing is named
STRIBECK_SIGMAS = 4.0  # widths of the smoothing that low speed must last
REVERSED = "iq_a has the wrong sign: J/Kt is negative with it; negate the column (or the angle and the speed)"


def judge(analysis: Analysis) -> Verdict:
    verdict = Verdict()
    if _impossible(analysis, verdict):
        return verdict
    if analysis.friction is not None:
        _friction(analysis, verdict)
    if analysis.angle is not None:
        name_lines(analysis, verdict)
    elif analysis.log.theta_m_rad is not None:
        verdict.warnings.append(
            "too few turns at low speed for orders of the angle: record four turns or more at a slow, constant speed"
        )
    if not analysis.judges:
        verdict.warnings.append("nothing could be judged: that no effect is named does not mean that none is missing")
    _left(analysis, verdict)
    _limits(analysis, verdict)
    if not verdict.names and (_significant(analysis, verdict) or _wrong_unit(analysis)):
        verdict.names = ["unknown"]
    return verdict


def _impossible(analysis: Analysis, verdict: Verdict) -> bool:
    """A sign that is wrong makes every name wrong: it is told, and nothing is named."""
    found = analysis.friction
    if found is None or "inertia" not in found.impossible:
        return False
    verdict.names = ["unknown"]
    verdict.unexplained.append(REVERSED)
    verdict.against += [(each.effect, "not judged: the sign of the current is wrong") for each in found.evidence]
    return True


def _friction(analysis: Analysis, verdict: Verdict) -> None:
    found, nominal = analysis.friction, analysis.nominal
    assert found is not None
    _cannot_tell(analysis, verdict)
    if "viscous_friction" in found.impossible:
        verdict.unexplained.append(
            "the drag falls with rising speed, so that viscous_friction would be negative: no friction, but a "
            "controller that answers the ripple, a limit that was reached, or a load that depends on the speed; "
            "friction is told as one mean drag"
        )
    for evidence in found.evidence:
        effect = evidence.effect
        parameters = _values(found, evidence)
        if evidence.named and OR in effect and parameters["torque_a_equiv"] < 0.0:
            effect = "load_torque" if "load_torque" in effect else effect
        if not evidence.named:
            verdict.against.append((effect, evidence.said))
            continue
        if nominal is not None and _in_model(effect, parameters, nominal):
            continue
        if evidence.small:
            verdict.against.append((effect, f"less than {100.0 * SMALL:.0f} % of the current: too small to name"))
            continue
        value, half = parameters["torque_a_equiv"], found.half[f"{evidence.effect}.torque_a_equiv"]
        if half > VAGUE * abs(value):
            verdict.against.append((effect, f"{milli(value)} +- {milli(half)}: not told well enough to name"))
            continue
        wrong = out_of_range(effect, _whole(effect, parameters, nominal))
        if wrong is not None:
            verdict.against.append((effect, wrong))
            verdict.unexplained.append(f"{effect}: {wrong}")
            continue
        takes_a = max(evidence.validation_drop * found.before_rms_a, _size(analysis, evidence))
        sure = _sure(analysis, evidence, takes_a)
        if sure < SURE:
            size = f"{milli(value)} +- {milli(half)}"
            verdict.against.append((effect, f"{size}: confidence {sure:.2f}, too little to name"))
            continue
        verdict.name(effect, parameters, sure, takes_a)
        if effect == "stribeck_friction":
            _stribeck_seen(analysis, parameters["speed_rad_s"], verdict)
    if nominal is not None:
        _factors(analysis, verdict)
    _left_by_friction(analysis, verdict)


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


def _sure(analysis: Analysis, evidence: Evidence, takes_a: float) -> float:
    """Chance that it is none by accident, how well it is known, and how much of the log it leaves unexplained."""
    found = analysis.friction
    assert found is not None
    name = f"{evidence.effect}.torque_a_equiv"
    value, half = abs(evidence.values.get("torque_a_equiv", 0.0)), found.half.get(name, 0.0)
    return (1.0 - evidence.p_value) * sureness(analysis, takes_a, half / max(value, 1e-12))


def sureness(analysis: Analysis, takes_a: float, share: float) -> float:
    """1 where all is explained and the value is exact. `share`: half width over value."""
    left = left_of(analysis)
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
        f"the log turns in {driven}: {drive.friction} cannot be told apart; {drive.separator()} would separate them"
    )


def _stribeck_seen(analysis: Analysis, speed_rad_s: float, verdict: Verdict) -> None:
    """A low speed that is passed within the smoothing has no shape to tell torque and speed apart by."""
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


def _factors(analysis: Analysis, verdict: Verdict) -> None:
    """Inertia and viscous friction off what the model says."""
    found, nominal = analysis.friction, analysis.nominal
    assert found is not None and nominal is not None
    checks = (
        ("inertia", INERTIA, nominal.inertia_as2, INERTIA_EDGE),
        ("viscous_friction", VISCOUS, nominal.viscous_as, VISCOUS_EDGE),
    )
    column = {"inertia": found.motion.accel_rad_s2, "viscous_friction": found.motion.speed_rad_s}
    for effect, key, known, edge in checks:
        if known <= 0.0:
            continue
        if key not in found.final.names:
            verdict.against.append((effect, "this log does not tell it: the model's is kept"))
            continue
        off, half = found.final[key] / known, found.half[key] / known
        takes_a = abs(found.final[key]) * float(np.std(column[effect][found.validation_rows]))
        wrong = out_of_range(effect, {"factor": 1.0 + off}) or (_unit(1.0 + off) if effect == "inertia" else None)
        if effect == "inertia" and analysis.drive.one_speed:
            why = "at one speed nothing but ripple accelerates the shaft: the model's is kept"
            verdict.against.append((effect, why))
            continue
        told = half < SURE_SHARE * abs(1.0 + off)
        if abs(off) > edge + half and told and takes_a > VALID_SHARE * found.before_rms_a and wrong is None:
            chance = found.final.p_value([key])
            verdict.name(
                effect, {"factor": 1.0 + off}, (1.0 - chance) * sureness(analysis, takes_a, half / abs(off)), takes_a
            )
        elif wrong is not None:
            verdict.against.append((effect, wrong))
            verdict.unexplained.append(wrong)
        elif abs(off) > edge + half and told:
            verdict.against.append((effect, f"{1.0 + off:.3f} +- {half:.3f} of the model: too small to show here"))
        elif abs(off) > edge:
            verdict.against.append((effect, f"{1.0 + off:.3f} +- {half:.3f} of the model: not told well enough"))
        else:
            verdict.against.append((effect, f"{1.0 + off:.3f} +- {half:.3f} of the model: within what units differ by"))
    if "inertia" in verdict.names:
        verdict.apart("inertia or torque_constant")
        verdict.alternatives.append(
            (
                "torque_constant",
                0.5,
                "a balance in ampere equivalents sees J/Kt only: J larger or Kt smaller look the same",
            )
        )


def _unit(factor: float) -> str | None:
    """Inertia over that of the model, when a column has another unit than its name says."""
    for ratio, what in UNITS_OFF.items():
        if factor > 0.0 and abs(np.log(factor / ratio)) < UNIT_BAND:
            return f"the inertia is {factor:.4g} times that of the model, as it is when {what}: convert the column"
    return None


def _wrong_unit(analysis: Analysis) -> bool:
    found, nominal = analysis.friction, analysis.nominal
    if found is None or nominal is None or not nominal.inertia_as2 > 0.0 or INERTIA not in found.final.names:
        return False
    return _unit(1.0 + found.final[INERTIA] / nominal.inertia_as2) is not None


def _left_by_friction(analysis: Analysis, verdict: Verdict) -> None:
    found = analysis.friction
    assert found is not None
    left = found.remainder
    if left.curvature_p < CHANCE and left.curvature_drop > BENDS:
        how = "less" if left.curvature < 0.0 else "more"
        verdict.unexplained.append(
            f"friction grows {how} than linearly with speed (p = {left.curvature_p:.1g}): no effect of the table does "
            "that, so it is left unexplained"
        )
    if left.told_rms_a > TOLD_SHARE * left.rms_a:
        verdict.unexplained.append(
            f"of {milli(left.rms_a)} rms that are left, {milli(left.told_rms_a)} follow speed and acceleration"
        )
    if _at_low_speed(left):
        verdict.unexplained.append(
            f"below {left.slow_below_rad_s:.0f} rad/s {milli(left.slow_rms_a)} rms are left, above only "
            f"{milli(left.fast_rms_a)}: torque tied to the angle looks like that where the speed passes zero; a slow "
            "run at constant speed would tell its orders"
        )
    if left.drift_p < CHANCE and abs(left.drift_share) > DRIFT_EDGE:
        verdict.unexplained.append(
            f"the dry friction changes by {100.0 * left.drift_share:+.0f} % over the log (drift)"
        )


def _at_low_speed(left: Remainder) -> bool:
    return left.slow_rms_a > SLOW_RATIO * max(left.fast_rms_a, NOISE_LSB_A)


def _left(analysis: Analysis, verdict: Verdict) -> None:
    """No all-clear over something that stands out: its size, where it is, and what was turned down."""
    left = left_of(analysis)
    if left is None or not left.significant:
        return
    size = f"{milli(left.rms_a)} rms are left where noise alone would leave {milli(left.noise_a)}"
    verdict.unexplained.insert(0, f"{size}, {'; '.join(left.where)}")


def _significant(analysis: Analysis, verdict: Verdict) -> bool:
    """Is what is left more than noise, with nothing named?"""
    left = left_of(analysis)
    if left is not None and left.significant and verdict.unexplained:
        return True
    if analysis.friction is not None:
        rest = analysis.friction.remainder
        if _at_low_speed(rest):
            return True
        drifts = rest.drift_p < CHANCE and abs(rest.drift_share) > DRIFT_EDGE
        if rest.told_rms_a > TOLD_SHARE * rest.rms_a or drifts:
            return True
    return analysis.angle is not None and bool(analysis.angle.strange or moved_lines(analysis))


def _limits(analysis: Analysis, verdict: Verdict) -> None:
    """What the log does not tell, and what was put right in time."""
    if analysis.stretches.idle_s:
        total = sum(end - start for start, end in analysis.stretches.idle_s)
        verdict.warnings.append(f"the rotor rests for {total:.1f} s together: those stretches are left out")
    if analysis.log.speed_rad_s is not None and analysis.log.theta_m_rad is None:
        verdict.warnings.append(
            "how late the speed estimate is cannot be told without theta_m_rad: viscous friction and inertia take up "
            "a part"
        )
    if analysis.controller is None:
        if analysis.log.speed_ref_rad_s is not None and analysis.log.speed_rad_s is None:
            verdict.warnings.append(
                "the speed controller cannot be found without speed_rad_s: no closed loop is simulated"
            )
        elif analysis.log.speed_ref_rad_s is not None:
            verdict.warnings.append(
                "the current is not a gain times the speed error anywhere: the speed controller is another one, or "
                "something adds current throughout; no closed loop is simulated"
            )
    elif not analysis.controller.plain:
        verdict.warnings.append("something adds current throughout the log: no uncompensated part to simulate")
