"""Is a drive's speed loop stable, by itself and with repetitive control?

The poles of the whole sampled loop (design/sampled.py), memory of the repetitive controller included: a loop is
stable when all lie inside the unit circle. Numbers of a motor are known to some percent, so a verdict must hold
for loops nearby, too:

    stable     this loop, and every one nearby (SPREAD), and the repetitive controller at every speed
    unstable   this loop, and every one nearby
    marginal   anything between: not to be relied on
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from evenspin.blocks import lagrange
from evenspin.design.rc import Repetitive, frequencies, gain_bound
from evenspin.design.sampled import Sampled, sampled_loop

Array = NDArray[np.float64]
Numbers = Mapping[str, float]

SPREAD = 0.05  # of the gains of speed loop and learning, and of the current loop, up and down
LONGEST = 420  # samples that the memory of the firmware holds, less what interpolation needs


class Verdict(StrEnum):
    STABLE = "stable"
    MARGINAL = "marginal"
    UNSTABLE = "NOT stable"


def with_repetitive(loop: Sampled, rc: Repetitive, period_samples: float, *, whole: bool = False) -> Array:
    """State matrix of the loop with the memory of the controller behind it, newest value first.

    As control/repetitive/repetitive.h: the error is written `lead` samples back, Q and the interpolation read what is
    a period old. fal counts with its largest gain. `whole`: the period is cut to samples (CRC).
    """
    size = len(loop.a)
    cut = int(np.floor(period_samples + 5e-4))
    fraction = 0.0 if whole else max(period_samples - cut, 0.0)
    ahead = 0 if whole else rc.ahead
    taps = np.convolve(rc.q_taps, lagrange(0 if whole else rc.order, fraction + ahead))
    first = cut - 2 - ahead - rc.beyond
    length = first + len(taps)
    error = -loop.unit * loop.c
    learned = rc.gain * rc.lambda_max * error
    matrix = np.zeros((size + length, size + length))
    written = np.eye(length, size + length, size)  # rows: the memory after this sample's error was written
    if rc.lead > 0:
        written[rc.lead - 1, :size] += learned
    out = taps @ written[first : first + len(taps)]
    matrix[:size, :size] = loop.a
    matrix[:size] += np.outer(loop.b, out)
    matrix[size] = out
    if rc.lead == 0:
        matrix[size, :size] += learned
    matrix[size + 1 :] = written[:-1]
    return matrix


@dataclass(frozen=True, slots=True)
class Stability:
    """What was found at one speed. `radius`: largest pole, per speed sample; `alone`: without repetitive control."""

    verdict: Verdict
    reason: str
    speed_rad_s: float
    radius_alone: float
    radius: float
    k_rc_bound: float  # largest learning gain that is stable at every speed; 0: none


def judge(
    plant: Numbers,
    drive: Numbers,
    speed_rad_s: float,
    rc: Repetitive | None = None,
    *,
    whole: bool = False,
    delay_periods: int = 0,
) -> Stability:
    """The loop of this drive at this speed, and those nearby."""
    loop = sampled_loop(plant, drive, speed_rad_s, delay_periods)
    period = 2.0 * np.pi / (plant["pole_pairs"] * abs(speed_rad_s) * loop.ts_s) if speed_rad_s else np.inf
    resting = rc is not None and not rc.shortest <= period <= LONGEST
    acting = None if resting else rc
    radii = [_radius(loop, acting, period, whole)]
    for speed_gain, current_gain in itertools.product((1.0 - SPREAD, 1.0 + SPREAD), repeat=2):
        near = sampled_loop(plant, _scaled(drive, speed_gain, current_gain), speed_rad_s, delay_periods)
        other = replace(acting, gain=acting.gain * speed_gain) if acting is not None else None
        radii.append(_radius(near, other, period, whole))
    bound = _bound(loop, rc) if rc is not None and loop.radius < 1.0 else 0.0
    verdict, reason = _verdict(radii, loop.radius, bound, rc, resting)
    if not loop.radius < 1.0 and _current_loop(plant, drive, speed_rad_s) > 1.0:
        reason = "the current loop itself"
    return Stability(verdict, reason, speed_rad_s, loop.radius, radii[0], bound)


def _verdict(
    radii: list[float], alone: float, bound: float, rc: Repetitive | None, resting: bool
) -> tuple[Verdict, str]:
    outside = [not radius < 1.0 for radius in radii]
    if not np.isfinite(radii[0]) or not alone < 1.0:
        return Verdict.UNSTABLE, "the speed loop itself, without repetitive control"
    if all(outside):
        return Verdict.UNSTABLE, "with repetitive control at this speed"
    if any(outside):
        return Verdict.MARGINAL, f"NOT stable for sure: gains {100.0 * SPREAD:g} % off decide"
    if rc is not None and rc.gain * rc.lambda_max > bound:
        return Verdict.MARGINAL, "stable at this speed, NOT stable at every speed"
    return Verdict.STABLE, "the speed loop; repetitive control pauses at this speed" if resting else ""


def _radius(loop: Sampled, rc: Repetitive | None, period: float, whole: bool) -> float:
    if rc is None or not np.isfinite(loop.a).all():
        return loop.radius if np.isfinite(loop.a).all() else np.inf
    return float(np.abs(np.linalg.eigvals(with_repetitive(loop, rc, period, whole=whole))).max())


def _bound(loop: Sampled, rc: Repetitive) -> float:
    """On k_rc times the largest gain of fal: |Q (1 - k z^m M)| < 1 at every frequency."""
    f_hz = frequencies(loop.ts_s)
    ahead = loop.closed(f_hz) * np.exp(2j * np.pi * f_hz * loop.ts_s * rc.lead)
    return float(gain_bound(ahead, rc.q(f_hz, loop.ts_s)).min())


def _current_loop(plant: Numbers, drive: Numbers, speed_rad_s: float) -> float:
    """Largest pole with a speed loop that hardly acts; its own slow poles lie just inside."""
    faint = {name: min(drive[name], 1e-9) for name in ("speed_kp_a_per_unit", "speed_ki_a_per_unit_s")}
    poles = np.abs(sampled_loop({**plant, "viscous_nms": plant["inertia_kgm2"]}, {**drive, **faint}, speed_rad_s).poles)
    return float(poles[poles > 1.001].max(initial=0.0))


def _scaled(drive: Numbers, speed_gain: float, current_gain: float) -> dict[str, float]:
    changed = dict(drive)
    for name in ("speed_kp_a_per_unit", "speed_ki_a_per_unit_s"):
        changed[name] *= speed_gain
    for name in ("current_kp_v_per_a", "current_ki_v_per_as"):
        changed[name] *= current_gain
    for name in ("motor_ld_h", "motor_lq_h"):
        changed[name] *= current_gain
    return changed
