"""From evidence to names: what is missing, with which parameters, what else it could be, and what stays unexplained."""

from __future__ import annotations

from evenspin.balance.analysis import Analysis
from evenspin.balance.formatting import amperes
from evenspin.balance.friction import CHANCE
from evenspin.balance.judge_factors import has_wrong_unit, name_factors
from evenspin.balance.judge_friction import (
    DRIFT_EDGE,
    PREDICTABLE_SHARE,
    describe_residual,
    name_friction,
    stands_out_at_low_speed,
)
from evenspin.balance.judge_lines import moved_lines, name_lines
from evenspin.balance.unexplained import unexplained_of
from evenspin.balance.verdict import Verdict

REVERSED = "iq_a has the wrong sign: J/Kt is negative with it; negate the column (or the angle and the speed)"


def judge(analysis: Analysis) -> Verdict:
    verdict = Verdict()
    if _impossible(analysis, verdict):
        return verdict
    if analysis.friction is not None:
        name_friction(analysis, verdict)
        if analysis.nominal is not None:
            name_factors(analysis, verdict)
        describe_residual(analysis, verdict)
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
    if not verdict.names and (_significant(analysis, verdict) or has_wrong_unit(analysis)):
        verdict.names = ["unknown"]
    return verdict


def _impossible(analysis: Analysis, verdict: Verdict) -> bool:
    """A wrong sign makes every name wrong: it is reported, and nothing is named."""
    found = analysis.friction
    if found is None or "inertia" not in found.impossible:
        return False
    verdict.names = ["unknown"]
    verdict.unexplained.append(REVERSED)
    verdict.against += [(each.effect, "not judged: the sign of the current is wrong") for each in found.evidence]
    return True


def _left(analysis: Analysis, verdict: Verdict) -> None:
    """No all-clear over something that stands out: its size, where it is, and what was turned down."""
    left = unexplained_of(analysis)
    if left is None or not left.significant:
        return
    size = f"{amperes(left.rms_a)} rms are left where noise alone would leave {amperes(left.noise_a)}"
    verdict.unexplained.insert(0, f"{size}, {'; '.join(left.where)}")


def _significant(analysis: Analysis, verdict: Verdict) -> bool:
    """Is what is left more than noise, with nothing named?"""
    left = unexplained_of(analysis)
    if left is not None and left.significant and verdict.unexplained:
        return True
    if analysis.friction is not None:
        rest = analysis.friction.remainder
        if stands_out_at_low_speed(rest):
            return True
        drifts = rest.drift_p < CHANCE and abs(rest.drift_share) > DRIFT_EDGE
        if rest.predictable_rms_a > PREDICTABLE_SHARE * rest.rms_a or drifts:
            return True
    return analysis.angle is not None and bool(analysis.angle.fractional or moved_lines(analysis))


def _limits(analysis: Analysis, verdict: Verdict) -> None:
    """What the log does not show, and what was left out."""
    if analysis.stretches.idle_s:
        total = sum(end - start for start, end in analysis.stretches.idle_s)
        verdict.warnings.append(f"the rotor rests for {total:.1f} s together: those stretches are left out")
    if analysis.log.speed_rad_s is not None and analysis.log.theta_m_rad is None:
        verdict.warnings.append(
            "the delay of the speed estimate is not identifiable without theta_m_rad: viscous friction and inertia "
            "take up a part"
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
