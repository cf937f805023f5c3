"""Inertia and viscous friction beside those of the model."""

from __future__ import annotations

import numpy as np

from evenspin.balance.analysis import Analysis
from evenspin.balance.friction import VALID_SHARE
from evenspin.balance.judge_friction import confidence_factor
from evenspin.balance.shaft_regression import INERTIA, VISCOUS
from evenspin.balance.verdict import Verdict, out_of_range

# A healthy unit differs from its data sheet by as much (docs/log-format.md): 2.5 times inertia 1.2 % with flux 0.4 %,
# and viscous friction 4 %.
INERTIA_EDGE, VISCOUS_EDGE = 0.032, 0.10
KNOWN_SHARE = 0.3  # half width over value of a factor, above which nothing is named
UNITS_OFF = {
    2.0 * np.pi / 60.0: "the speed is in r/min, not in rad/s",
    np.pi / 180.0: "the motion is in degrees, not in rad",
    2.0 * np.pi: "the motion is in turns, not in rad",
    1e3: "the current is in mA, not in A",
}
UNIT_BAND = 0.1  # of the logarithm of such a ratio


def name_factors(analysis: Analysis, verdict: Verdict) -> None:
    """Inertia and viscous friction that differ from the model."""
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
            verdict.against.append((effect, "not identifiable in this log: the value of the model is kept"))
            continue
        off, half = found.final[key] / known, found.half[key] / known
        takes_a = abs(found.final[key]) * float(np.std(column[effect][found.validation_rows]))
        wrong = out_of_range(effect, {"factor": 1.0 + off}) or (_unit(1.0 + off) if effect == "inertia" else None)
        if effect == "inertia" and analysis.drive.one_speed:
            why = "at one speed nothing but ripple accelerates the shaft: the value of the model is kept"
            verdict.against.append((effect, why))
            continue
        known = half < KNOWN_SHARE * abs(1.0 + off)
        if abs(off) > edge + half and known and takes_a > VALID_SHARE * found.before_rms_a and wrong is None:
            chance = found.final.p_value([key])
            verdict.name(
                effect,
                {"factor": 1.0 + off},
                (1.0 - chance) * confidence_factor(analysis, takes_a, half / abs(off)),
                takes_a,
            )
        elif wrong is not None:
            verdict.against.append((effect, wrong))
            verdict.unexplained.append(wrong)
        elif abs(off) > edge + half and known:
            verdict.against.append((effect, f"{1.0 + off:.3f} +- {half:.3f} of the model: too small to show here"))
        elif abs(off) > edge:
            verdict.against.append((effect, f"{1.0 + off:.3f} +- {half:.3f} of the model: the interval is too wide"))
        else:
            verdict.against.append(
                (effect, f"{1.0 + off:.3f} +- {half:.3f} of the model: within the spread of healthy units")
            )
    if "inertia" in verdict.names:
        verdict.apart("inertia or torque_constant")
        why = "a balance in ampere equivalents contains J/Kt only: a larger J and a smaller Kt have the same effect"
        verdict.alternative("inertia", "torque_constant", 0.5, why)


def _unit(factor: float) -> str | None:
    """Inertia over that of the model, when a column has another unit than its name says."""
    for ratio, what in UNITS_OFF.items():
        if factor > 0.0 and abs(np.log(factor / ratio)) < UNIT_BAND:
            return f"the inertia is {factor:.4g} times that of the model, as it is when {what}: convert the column"
    return None


def has_wrong_unit(analysis: Analysis) -> bool:
    found, nominal = analysis.friction, analysis.nominal
    if found is None or nominal is None or not nominal.inertia_as2 > 0.0 or INERTIA not in found.final.names:
        return False
    return _unit(1.0 + found.final[INERTIA] / nominal.inertia_as2) is not None
