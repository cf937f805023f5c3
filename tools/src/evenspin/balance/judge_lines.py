"""Names for what repeats with the angle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evenspin.balance.analysis import Analysis
from evenspin.balance.confidence import confident_lines, line_confidence, threshold_of
from evenspin.balance.formatting import amperes
from evenspin.balance.friction import SMALL
from evenspin.balance.line_estimate import FoundLine
from evenspin.balance.verdict import Numbers, Verdict

MODEL_EDGE = 0.2  # a line of the model that is found again within this is not missing
LARGE_SHARE = 0.3  # of the residue, rms, in one line
FEW_OUTLIERS = 3  # stretches that are reported one by one
LOWEST_COGGING = 3  # lower mechanical orders are misalignment
MISALIGNED = 0.3  # of the strongest line


def missing_lines(analysis: Analysis) -> list[FoundLine]:
    """Lines that both parts of the log have, and the model has not."""
    if analysis.angle is None:
        return []
    real = confident_lines(analysis)
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


def name_lines(analysis: Analysis, verdict: Verdict) -> None:
    angle = analysis.angle
    assert angle is not None
    for order, amplitude in angle.fractional:
        verdict.unexplained.append(
            f"a line at order {order:g}, {amperes(amplitude)}: not a whole order, so not tied to this shaft"
        )
    _odd(analysis, verdict)
    _moved(analysis, verdict)
    if moved_lines(analysis):
        verdict.against.append(("cogging", "the angle cannot be trusted: its strongest line moves"))
        return
    if angle.fractional and analysis.log.speed_rad_s is None:
        why = "lines at fractions of a turn, and no speed beside the angle: is it electrical, or not in rad?"
        verdict.against.append(("cogging", why))
        verdict.unexplained.append(why)
        return
    lines = missing_lines(analysis)
    if not lines:
        verdict.against.append(("cogging", f"{_why_no_line(analysis)} (up to order {angle.highest})"))
        return
    low = [each for each in lines if each.line.order < LOWEST_COGGING]
    high = [each for each in lines if each.line.order >= LOWEST_COGGING]
    if high:
        main = high[0]
        verdict.name(
            _effect(analysis, main), _parameters(analysis, main), line_confidence(analysis, main), _takes(high)
        )
        _alternatives(analysis, main, high, verdict)
    first = next((each for each in low if each.line.order == 1.0), None)
    if first is not None and first.line.amplitude_a > MISALIGNED * lines[0].line.amplitude_a:
        verdict.name("misalignment", _misalignment(low, analysis), line_confidence(analysis, first), _takes(low))
        if analysis.drive.one_speed:
            verdict.apart("misalignment or encoder_eccentricity")
            why = "the same order at one speed; a second speed separates them"
            verdict.alternative("misalignment", "encoder_eccentricity", 0.3, why)
        return
    for each in low:
        verdict.unexplained.append(
            f"a line at order {each.line.order:g}, {amperes(each.line.amplitude_a)}, that no effect of the table makes "
            "alone"
        )


def _takes(lines: Sequence[FoundLine]) -> float:
    return float(np.sqrt(0.5 * sum(each.line.amplitude_a**2 for each in lines)))


def _effect(analysis: Analysis, main: FoundLine) -> str:
    """The first electrical order is torque of the shaft or an offset of a current sensor: the current has both."""
    p = analysis.nominal.pole_pairs if analysis.nominal is not None else None
    return "cogging or current_offset" if p is not None and main.line.order == p else "cogging"


def _odd(analysis: Analysis, verdict: Verdict) -> None:
    outliers = analysis.angle.outliers if analysis.angle is not None else ()
    if len(outliers) > FEW_OUTLIERS:
        verdict.unexplained.append(
            f"{len(outliers)} stretches between {outliers[0].start_s:.2f} and {outliers[-1].end_s:.2f} s follow no "
            "line and are left out of the fit (possible cause: an angle that jumps, for example once per turn at its "
            "index)"
        )
        return
    for each in outliers:
        verdict.unexplained.append(
            f"from {each.start_s:.2f} to {each.end_s:.2f} s the balance is off by {amperes(each.off_a)} rms, far "
            "beyond the rest: left out of the fit (possible cause: a start against a stop, or an alignment)"
        )


def _why_no_line(analysis: Analysis) -> str:
    assert analysis.angle is not None
    found = analysis.angle.lines
    if not found:
        return f"no order of the angle stands out of the noise between the orders{_threshold(analysis)}"
    if not any(each.validated for each in found):
        strongest = found[0]
        if strongest.one_speed:
            return (
                f"order {strongest.line.order:g}, {amperes(strongest.line.amplitude_a)}, is there near one speed only: "
                "a frequency, such as the beat of encoder counts with the rows, and no torque of the shaft"
            )
        return (
            f"no line is the same in all parts of the log: order {strongest.line.order:g} is the strongest, "
            f"{amperes(strongest.line.amplitude_a)}, and differs by {100.0 * strongest.agree:.0f} %"
        )
    if confident_lines(analysis):
        return "the lines are those of the model"
    strongest = next(each for each in found if each.validated)
    return (
        f"the strongest line, order {strongest.line.order:g} with {amperes(strongest.line.amplitude_a)} +- "
        f"{amperes(strongest.half_a)}, is less than {100.0 * SMALL:.0f} % of the current or lost in what else is left "
        f"(confidence {line_confidence(analysis, strongest):.2f}): not named"
    )


def _threshold(analysis: Analysis) -> str:
    """How large a line would have had to be; unknown without J/Kt."""
    at = threshold_of(analysis)
    if at is None:
        return ""
    return (
        f"; detection threshold {amperes(at.smallest_a)} (order {at.smallest_at}) to {amperes(at.largest_a)} "
        f"(order {at.largest_at})"
    )


def moved_lines(analysis: Analysis) -> list[FoundLine]:
    """Lines that make up much of the residue and stand out in both parts of the log, at another phase."""
    angle = analysis.angle
    if angle is None:
        return []
    least_a = np.sqrt(2.0) * LARGE_SHARE * angle.before_rms_a
    return [
        each
        for each in angle.lines
        if each.both and not (each.validated or each.one_speed) and each.line.amplitude_a > least_a
    ]


def _moved(analysis: Analysis, verdict: Verdict) -> None:
    moved = moved_lines(analysis)
    orders = ", ".join(f"{each.line.order:g}" for each in moved)
    if orders:
        verdict.unexplained.append(
            f"order {orders} stands out in both halves of the log ({amperes(moved[0].line.amplitude_a)}), at another "
            "phase: the angle has lost counts or its zero has moved, or this is not torque of the shaft; cut the log "
            "where that happens"
        )


def _parameters(analysis: Analysis, main: FoundLine) -> Numbers:
    parameters = {"order": main.line.order}
    if not analysis.inertia_known:
        return parameters
    return parameters | {
        "amplitude_a_equiv": main.line.amplitude_a,
        "amplitude_half_a_equiv": main.half_a,
        "phase_rad": main.line.phase_rad,
    }


def _misalignment(low: Sequence[FoundLine], analysis: Analysis) -> Numbers:
    at = {each.line.order: each.line for each in low}
    if not analysis.inertia_known:
        return {}
    parameters = {"amplitude_a_equiv": at[1.0].amplitude_a, "phase_rad": at[1.0].phase_rad}
    if 2.0 in at:
        parameters |= {"second_rel": at[2.0].amplitude_a / at[1.0].amplitude_a, "phase2_rad": at[2.0].phase_rad}
    return parameters


def _alternatives(analysis: Analysis, main: FoundLine, lines: Sequence[FoundLine], verdict: Verdict) -> None:
    angle = analysis.angle
    assert angle is not None
    if not analysis.inertia_known:
        verdict.warnings.append(
            "at one speed the acceleration is made of the same orders as the torque, so J/Kt is not identifiable and "
            "the orders have no amplitude in torque: give --model with inertia_kgm2 (a log that sweeps the speed "
            "yields one)"
        )
    elif analysis.lag_assumed:
        verdict.warnings.append(
            "the delay of the speed estimate is not identifiable in this log: the intervals of the amplitudes include "
            "0 to 4 ms"
        )
    p = analysis.nominal.pole_pairs if analysis.nominal is not None else None
    if p is None:
        why = "if the strongest order is that of the pole pairs, which no model gives"
        verdict.alternative("cogging", "current_offset", 0.2, why)
        return
    if main.line.order % (6 * p) == 0:
        weak = angle.current_share < 1.0
        reason = f"order {main.line.order:g} is also the 6th electrical order of {p} pole pairs"
        reason += (
            f"; against it: the line changes by {100.0 * angle.current_share:.0f} % per ampere only" if weak else ""
        )
        verdict.alternative("cogging", "flux_harmonics", 0.1 if weak else 0.4, reason)
    for each in lines:
        if each.line.order == p:
            verdict.apart("cogging or current_offset")
            verdict.warnings.append(
                f"order {p} is the first electrical order: torque of the shaft and an offset of a current sensor "
                "cannot be separated; turning the shaft by hand or by another motor with the current at zero would "
                "separate them"
            )
        if each.line.order == 2 * p:
            why = f"for the line at order {2 * p}, the 2nd electrical order"
            verdict.alternative("cogging", "current_gain", 0.1, why)
