"""From evidence to names: what is missing, with which parameters, what else it could be, and what stays unexplained."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from evenspin.gap.balance.analysis import Analysis
from evenspin.gap.balance.angle_orders import FoundLine
from evenspin.gap.balance.friction import CHANCE, VALID_SHARE, Remainder
from evenspin.gap.balance.nominal import Nominal
from evenspin.native import tables

Numbers = dict[str, float]

# A sound unit differs from its data sheet by as much (docs/log-format.md): 2.5 times inertia 1.2 % with flux 0.4 %, and
# viscous friction 4 %.
INERTIA_EDGE, VISCOUS_EDGE = 0.032, 0.10
MODEL_EDGE = 0.2  # a line or a friction of the model that is found again within this is not missing
TOLD_SHARE = 0.5  # of the residue's rms that speed and acceleration tell: with nothing named, something is missing
DRIFT_EDGE = 0.2
MUCH = 0.3  # of the residue, rms, in one line
FEW_ODD = 3  # stretches that are told one by one
SLOW_RATIO = 3.0  # of the residue at low speed to that at high speed, to be worth a word
NOISE_LSB_A = 1e-3  # below a few of these it is the resolution of a current sensor
STRIBECK_SIGMAS = 4.0  # widths of the smoothing that low speed must last
LOWEST_COGGING = 3  # lower mechanical orders are misalignment
MAIN_LINES = 3  # that are told in words


@dataclass(slots=True)
class Verdict:
    """Names, strongest first."""

    names: list[str] = field(default_factory=list)
    parameters: dict[str, Numbers] = field(default_factory=dict)
    confidence: Numbers = field(default_factory=dict)
    alternatives: list[tuple[str, float, str]] = field(default_factory=list)
    against: list[tuple[str, str]] = field(default_factory=list)  # (effect, why not)
    unexplained: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    takes_a: Numbers = field(default_factory=dict)

    def name(self, effect: str, parameters: Numbers, confidence: float, takes_a: float) -> None:
        assert effect in tables().effects, effect
        self.parameters[effect] = parameters
        self.confidence[effect] = round(min(confidence, 0.99), 4)
        self.takes_a[effect] = takes_a
        self.names = sorted(self.takes_a, key=lambda name: -self.takes_a[name])


def judge(analysis: Analysis) -> Verdict:
    verdict = Verdict()
    if analysis.friction is not None:
        _friction(analysis, verdict)
    else:
        verdict.warnings.append(
            "the log stays near one speed: viscous_friction, coulomb_friction, stribeck_friction and load_torque "
            "cannot be "
            "told apart; a log that sweeps the speed in both directions would"
        )
    if analysis.angle is not None:
        _angle(analysis, verdict)
    elif analysis.log.theta_m_rad is not None:
        verdict.warnings.append(
            "too few turns at low speed for orders of the angle: record a slow run at constant speed"
        )
    if analysis.friction is None and analysis.angle is None:
        verdict.warnings.append("nothing could be judged: that no effect is named does not mean that none is missing")
    _alignment(analysis, verdict)
    _controller(analysis, verdict)
    if not verdict.names and verdict.unexplained and _significant(analysis):
        verdict.names = ["unknown"]
    return verdict


def _friction(analysis: Analysis, verdict: Verdict) -> None:
    found, nominal = analysis.friction, analysis.nominal
    assert found is not None
    for evidence in found.evidence:
        if not evidence.named:
            verdict.against.append((evidence.effect, evidence.said))
            continue
        parameters = dict(evidence.values)
        if evidence.effect == "misalignment":
            parameters = _misalignment(
                [complex(*(evidence.values[f"{f}_{k}_a"] for f in ("sin", "cos"))) for k in (1, 2)]
            )
        if nominal is not None and _in_model(evidence.effect, parameters, nominal):
            continue
        verdict.name(evidence.effect, parameters, 1.0 - evidence.p_value, evidence.validation_drop * found.before_rms_a)
        if evidence.effect == "stribeck_friction":
            _stribeck_seen(analysis, parameters["speed_rad_s"], verdict)
    if nominal is not None:
        _factors(analysis, verdict)
    _left_by_friction(analysis, verdict)


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
            "identifiable "
            "from this log, only their product; reverse more slowly"
        )


def _in_model(effect: str, parameters: Numbers, nominal: Nominal) -> bool:
    known = {
        "coulomb_friction": nominal.coulomb_a,
        "load_torque": nominal.load_a,
        "stribeck_friction": nominal.stribeck_a,
    }
    size = abs(known.get(effect, 0.0))
    return size > 0.0 and abs(parameters.get("torque_a_equiv", np.inf)) < MODEL_EDGE * size


def _factors(analysis: Analysis, verdict: Verdict) -> None:
    """Inertia and viscous friction off what the model says."""
    found, nominal = analysis.friction, analysis.nominal
    assert found is not None and nominal is not None
    checks = (
        ("inertia", "inertia.inertia_as2_per_rad", nominal.inertia_as2, INERTIA_EDGE),
        ("viscous_friction", "viscous_friction.viscous_as_per_rad", nominal.viscous_as, VISCOUS_EDGE),
    )
    column = {"inertia": found.motion.accel_rad_s2, "viscous_friction": found.motion.speed_rad_s}
    for effect, key, known, edge in checks:
        if known <= 0.0:
            continue
        off, half = found.final[key] / known, found.final.half(key) / known
        half += analysis.alignment_half.get(key, 0.0) / known
        takes_a = abs(found.final[key]) * float(np.std(column[effect][found.validation_rows]))
        if abs(off) > edge + half and takes_a > VALID_SHARE * found.before_rms_a:
            verdict.name(effect, {"factor": 1.0 + off}, 1.0 - found.final.p_value([key]), takes_a)
        else:
            verdict.against.append((effect, f"{1.0 + off:.3f} +- {half:.3f} of the model: within what units differ by"))
    if "inertia" in verdict.names:
        verdict.alternatives.append(
            (
                "torque_constant",
                0.5,
                "a balance in ampere equivalents sees J/Kt only: J larger or Kt smaller look the same",
            )
        )


def _left_by_friction(analysis: Analysis, verdict: Verdict) -> None:
    found = analysis.friction
    assert found is not None
    left = found.remainder
    if left.curvature_p < CHANCE:
        how = "less" if left.curvature < 0.0 else "more"
        verdict.unexplained.append(
            f"friction grows {how} than linearly with speed (p = {left.curvature_p:.1g}): no effect of the table does "
            "that, "
            "so it is left unexplained"
        )
    if left.told_rms_a > TOLD_SHARE * left.rms_a:
        verdict.unexplained.append(
            f"of {1e3 * left.rms_a:.2f} mA rms that are left, {1e3 * left.told_rms_a:.2f} mA follow speed and "
            "acceleration"
        )
    if _at_low_speed(left):
        verdict.unexplained.append(
            f"below {left.slow_below_rad_s:.0f} rad/s {1e3 * left.slow_rms_a:.1f} mA rms are left, above only "
            f"{1e3 * left.fast_rms_a:.1f} mA: torque tied to the angle looks like that where the speed passes zero; a "
            "slow run "
            "at constant speed would tell its orders"
        )
    if left.drift_p < CHANCE and abs(left.drift_share) > DRIFT_EDGE:
        verdict.unexplained.append(
            f"the dry friction changes by {100.0 * left.drift_share:+.0f} % over the log (drift)"
        )


def _at_low_speed(left: Remainder) -> bool:
    return left.slow_rms_a > SLOW_RATIO * max(left.fast_rms_a, NOISE_LSB_A)


def _significant(analysis: Analysis) -> bool:
    """Is what is left more than noise, with nothing named?"""
    if analysis.friction is not None:
        left = analysis.friction.remainder
        if _at_low_speed(left):
            return True
        drifts = left.drift_p < CHANCE and abs(left.drift_share) > DRIFT_EDGE
        if left.told_rms_a > TOLD_SHARE * left.rms_a or drifts:
            return True
    return analysis.angle is not None and bool(analysis.angle.strange or moved_lines(analysis))


def _misalignment(phasors: Sequence[complex]) -> Numbers:
    first = abs(phasors[0])
    parameters = {"amplitude_a_equiv": first, "phase_rad": float(np.angle(phasors[0]))}
    if len(phasors) > 1 and first > 0.0:
        parameters |= {"second_rel": abs(phasors[1]) / first, "phase2_rad": float(np.angle(phasors[1]))}
    return parameters


def missing_lines(analysis: Analysis) -> list[FoundLine]:
    """Lines that both halves of the log have, and the model has not."""
    if analysis.angle is None:
        return []
    real = [each for each in analysis.angle.lines if each.validated]
    if analysis.nominal is None:
        return real
    known = {line.order: line.amplitude_a for line in analysis.nominal.lines}
    strongest = max((each.line.amplitude_a for each in real), default=0.0)
    return [
        each
        for each in real
        if abs(each.line.amplitude_a - abs(known.get(each.line.order, 0.0)))
        > max(MODEL_EDGE * each.line.amplitude_a, each.half_a)
        and (not known or each.line.amplitude_a > MODEL_EDGE * strongest)
    ]


def _angle(analysis: Analysis, verdict: Verdict) -> None:
    angle = analysis.angle
    assert angle is not None
    for order, amplitude in angle.strange:
        verdict.unexplained.append(
            f"a line at order {order:g}, {1e3 * amplitude:.1f} mA: not a whole order, so not tied to this shaft"
        )
    if len(angle.odd_s) > FEW_ODD:
        verdict.unexplained.append(
            f"{len(angle.odd_s)} stretches between {angle.odd_s[0][0]:.2f} and {angle.odd_s[-1][1]:.2f} s follow no "
            "line and "
            "are left out of the fit (an angle that jumps, say once per turn at its index, looks like that)"
        )
    for start_s, end_s, off_a in angle.odd_s[: 0 if len(angle.odd_s) > FEW_ODD else None]:
        verdict.unexplained.append(
            f"from {start_s:.2f} to {end_s:.2f} s the balance is off by {off_a:.2f} A rms, far beyond the rest: left "
            "out of the "
            "fit (a start against a stop or an alignment looks like that)"
        )
    _moved(analysis, verdict)
    lines = missing_lines(analysis)
    drop = 1.0 - angle.after_rms_a / angle.before_rms_a if angle.before_rms_a > 0.0 else 0.0
    if not lines or drop < VALID_SHARE:
        verdict.against.append(("cogging", f"{_why_no_line(analysis, lines, drop)} (up to order {angle.highest})"))
        return
    takes_a = angle.before_rms_a - angle.after_rms_a
    low = [each for each in lines if each.line.order < LOWEST_COGGING]
    high = [each for each in lines if each.line.order >= LOWEST_COGGING]
    p = analysis.nominal.pole_pairs if analysis.nominal is not None else None
    power = sum(each.line.amplitude_a**2 for each in lines)
    if high:
        main = high[0]
        effect = "current_offset" if p is not None and main.line.order == p else "cogging"
        share = np.sqrt(sum(each.line.amplitude_a**2 for each in high) / power)
        verdict.name(effect, _line_parameters(analysis, main), _confidence(main), takes_a * float(share))
        _alternatives(analysis, main, high, verdict)
    first = next((each for each in low if each.line.order == 1.0), low[0] if low else None)
    if first is not None and first.line.amplitude_a > 0.3 * lines[0].line.amplitude_a:
        phasors = [first.line.amplitude_a * np.exp(1j * first.line.phase_rad)]
        share = np.sqrt(sum(each.line.amplitude_a**2 for each in low) / power)
        verdict.name("misalignment", _misalignment(phasors), _confidence(first), takes_a * float(share))
        verdict.alternatives.append(
            ("encoder_eccentricity", 0.3, "the same order at one speed; a second speed tells them apart")
        )
    elif first is not None:
        verdict.unexplained.append(f"a small line at order {first.line.order:g}, {1e3 * first.line.amplitude_a:.1f} mA")


def _why_no_line(analysis: Analysis, lines: Sequence[FoundLine], drop: float) -> str:
    assert analysis.angle is not None
    if not analysis.angle.lines:
        return "no order of the angle stands out of the noise between the orders"
    if not any(each.validated for each in analysis.angle.lines):
        return "no line is in both halves of the log"
    if not lines:
        return "the lines are those of the model"
    return f"the lines take only {100.0 * drop:.1f} % off the residue of the validation half"


def moved_lines(analysis: Analysis) -> list[FoundLine]:
    """Lines that make up much of the residue and stand out in both halves of the log, at another phase.

    Only in a log of one speed: the few slow rows of a sweep make lines of their own.
    """
    angle = analysis.angle
    if angle is None or analysis.sweeps:
        return []
    least_a = np.sqrt(2.0) * MUCH * angle.before_rms_a
    return [each for each in angle.lines if each.both and not each.validated and each.line.amplitude_a > least_a]


def _moved(analysis: Analysis, verdict: Verdict) -> None:
    orders = ", ".join(f"{each.line.order:g}" for each in moved_lines(analysis))
    if orders:
        verdict.unexplained.append(
            f"order {orders} stands out in both halves of the log, at another phase: the angle has lost counts or its "
            "zero has "
            "moved, or this is not torque of the shaft; cut the log where that happens"
        )


def _confidence(each: FoundLine) -> float:
    """How sure the line is: its noise, and how well the halves of the log agree."""
    snr = each.line.amplitude_a / max(each.noise_a, 1e-12)
    return (1.0 - float(np.exp(-0.25 * snr))) * (1.0 - 0.5 * each.agree**2)


def _line_parameters(analysis: Analysis, main: FoundLine) -> Numbers:
    parameters = {"order": main.line.order}
    if analysis.inertia_known:
        half = main.half_a + analysis.lag_spread_a.get(int(main.line.order), 0.0)
        return parameters | {
            "amplitude_a_equiv": main.line.amplitude_a,
            "amplitude_half_a_equiv": half,
            "phase_rad": main.line.phase_rad,
        }
    return parameters


def _alternatives(analysis: Analysis, main: FoundLine, lines: Sequence[FoundLine], verdict: Verdict) -> None:
    angle = analysis.angle
    assert angle is not None
    if not analysis.inertia_known:
        verdict.warnings.append(
            "at one speed the acceleration is made of the same orders as the torque, so J/Kt cannot be told and the "
            "orders "
            "have no amplitude in torque: give --model with inertia_kgm2 (a log that sweeps the speed yields one)"
        )
    elif analysis.lag_spread_a:
        verdict.warnings.append(
            "how late the speed estimate is cannot be told from this log: the amplitudes allow for 0 to 4 ms"
        )
    if analysis.windings:
        best = analysis.windings[0]
        if main.line.order % (6 * best.pole_pairs) == 0:
            said = (
                f"order {main.line.order:g} is also the 6th electrical order of {best.pole_pairs} pole pairs; against "
                "it: the "
                f"line changes by {100.0 * angle.current_share:.0f} % per ampere only"
                if angle.current_share < 1.0
                else f"order {main.line.order:g} is also the 6th electrical order of {best.pole_pairs} pole pairs"
            )
            verdict.alternatives.append(("flux_harmonics", 0.1 if angle.current_share < 1.0 else 0.4, said))
        for each in lines:
            if each.line.order == best.pole_pairs:
                said = f"for the line at order {best.pole_pairs}, if the machine has {best.pole_pairs} pole pairs"
                verdict.alternatives.append(("current_offset", 0.2, said))
            if each.line.order == 2 * best.pole_pairs:
                said = f"for the line at order {2 * best.pole_pairs}, if the machine has {best.pole_pairs} pole pairs"
                verdict.alternatives.append(("current_gain", 0.1, said))
    if angle.highest > 1 and analysis.nominal is not None:
        nominal = analysis.nominal.coulomb_a + analysis.nominal.viscous_as * abs(_usual_speed(analysis))
        if nominal > 0.0 and abs(angle.drag_a) > max(MODEL_EDGE * nominal, 2.0 * angle.drag_half_a):
            verdict.unexplained.append(
                f"the mean drag is {1e3 * angle.drag_a:+.1f} mA off the model; at one speed it cannot be told which "
                "friction"
            )


def _usual_speed(analysis: Analysis) -> float:
    assert analysis.angle is not None
    return float(np.mean(analysis.angle.motion.speed_rad_s[analysis.angle.rows]))


def _alignment(analysis: Analysis, verdict: Verdict) -> None:
    """What was put right in time is said; a speed estimate that does not fit the angle is a warning."""
    if analysis.log.speed_rad_s is not None and analysis.log.theta_m_rad is None:
        verdict.warnings.append(
            "how late the speed estimate is cannot be told without theta_m_rad: viscous friction and inertia take up "
            "a part"
        )


def _controller(analysis: Analysis, verdict: Verdict) -> None:
    if analysis.controller is None:
        if analysis.log.speed_ref_rad_s is not None and analysis.log.speed_rad_s is None:
            verdict.warnings.append(
                "the speed controller cannot be found without speed_rad_s: no closed loop is simulated"
            )
        elif analysis.log.speed_ref_rad_s is not None:
            verdict.warnings.append(
                "the current is not a gain times the speed error anywhere: the speed controller is another one, or "
                "something "
                "adds current throughout; no closed loop is simulated"
            )
        return
    if not analysis.controller.plain:
        verdict.warnings.append("something adds current throughout the log: no uncompensated part to simulate")
