"""How confident a line over the angle is, and how large one would have to be in this log."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.analysis import Analysis
from evenspin.balance.angle_orders import AngleResult
from evenspin.balance.detection_threshold import LineThreshold, line_threshold
from evenspin.balance.friction import SMALL
from evenspin.balance.line_estimate import FoundLine
from evenspin.balance.regression import rms
from evenspin.balance.residuals import angle_balance_of, beyond_noise, noise_of

Array = NDArray[np.float64]

LEAST_CONFIDENCE = 0.5  # below which nothing is named


def smallest_named_a(angle: AngleResult) -> float:
    return float(np.sqrt(2.0)) * SMALL * rms(angle.motion.iq_a[angle.rows])


def threshold_of(analysis: Analysis) -> LineThreshold | None:
    """None where no order is resolved, or where J/Kt is not known and a line has no amplitude in torque."""
    if analysis.angle is None or not analysis.inertia_known:
        return None
    return line_threshold(analysis.thresholds_a, smallest_named_a(analysis.angle))


def confident_lines(analysis: Analysis) -> list[FoundLine]:
    """Lines that are large enough and certain enough to be named, whether or not the model has them."""
    angle = analysis.angle
    if angle is None:
        return []
    least_a = smallest_named_a(angle)
    found = [each for each in angle.lines if each.validated]
    first = [
        each for each in found if each.line.amplitude_a > least_a and line_confidence(analysis, each) > LEAST_CONFIDENCE
    ]
    return found if first else []


def line_confidence(analysis: Analysis, each: FoundLine) -> float:
    """Confidence in a line: its noise, how well parts of the log agree, its interval, and the residual beside it."""
    angle = analysis.angle
    assert angle is not None
    snr = each.line.amplitude_a / max(each.noise_a, 1e-12)
    found = angle_balance_of(angle)
    beyond_a = beyond_noise(found.after_a, noise_of(analysis, found.motion))
    rest = beyond_a / max(each.line.amplitude_a / math.sqrt(2.0), 1e-12)
    share = each.half_a / each.line.amplitude_a
    confidence = (1.0 - math.exp(-0.25 * snr)) * (1.0 - 0.5 * each.agree**2) / ((1.0 + rest**2) * (1.0 + share**2))
    return confidence if analysis.inertia_known else 0.8 * confidence
