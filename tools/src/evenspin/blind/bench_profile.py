"""What a person at a bench has the drive do: speed steps up and down, both ways, slowly for a while, with some load."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from evenspin.blind.bench_drives import Drive
from evenspin.blind.referee import Inputs

SLOW_RAD_S = (2.5, 5.0)
RISE_S = (0.03, 0.15)  # of the torque of a load machine
LEVELS = (0.06, 0.12, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0)  # of the full speed


def draw_inputs(rng: np.random.Generator, drive: Drive, duration_s: float, load_nm: float) -> Inputs:
    """`load_nm`: largest step of the load machine; 0: there is none."""
    pwm_hz = float(drive.meta["pwm_hz"])
    count = round(duration_s * pwm_hz)
    t_s = np.arange(count) / pwm_hz
    none = np.zeros(count)
    speed = np.interp(t_s, *_knots(rng, drive, duration_s))
    return Inputs(speed, none, none, _load(rng, count, pwm_hz, load_nm) if load_nm > 0.0 else none, none)


def _knots(rng: np.random.Generator, drive: Drive, duration_s: float) -> tuple[list[float], list[float]]:
    levels = [float(level) for level in rng.permutation(LEVELS)] * 20
    signs = [1.0, -1.0] if rng.uniform() < 0.6 else [1.0, 1.0, -1.0, -1.0]
    ramp_rad_s2 = drive.full_speed_rad_s / float(rng.uniform(0.1, 0.5))
    slow_s = min(4.0, 0.1 * duration_s)
    slow = float(rng.uniform(*SLOW_RAD_S))
    plan = [(slow, slow_s), (-slow, slow_s)]
    n, at_s = 0, 2.0 * slow_s
    while at_s < duration_s:
        hold_s = float(rng.uniform(0.6, 2.2))
        plan.insert(
            int(rng.integers(len(plan) + 1)) if n % 3 == 0 else len(plan), (_speed(drive, signs, levels, n), hold_s)
        )
        at_s += hold_s
        n += 1
    knots_s, knots, now = [0.0, 0.3], [0.0, 0.0], 0.0
    for target, hold_s in plan:
        ramp_s = abs(target - now) / ramp_rad_s2
        knots_s += [knots_s[-1] + ramp_s, knots_s[-1] + ramp_s + hold_s]
        knots += [target, target]
        now = target
    return knots_s, knots


def _speed(drive: Drive, signs: list[float], levels: list[float], n: int) -> float:
    return signs[n % len(signs)] * levels[n % len(levels)] * drive.full_speed_rad_s


def _load(rng: np.random.Generator, count: int, pwm_hz: float, load_nm: float) -> NDArray[np.float64]:
    """Steps at random in the middle half of the record, as fast as a brake or a load machine rises."""
    load = np.zeros(count)
    at, end = count // 4, count - count // 4
    while at < end:
        length = round(float(rng.uniform(0.5, 2.0)) * pwm_hz)
        level = 0.0 if rng.uniform() < 0.35 else float(rng.uniform(0.3, 1.0)) * load_nm * float(rng.choice((-1.0, 1.0)))
        load[at : min(at + length, end)] = level
        at += length
    rise = np.ones(max(1, round(float(rng.uniform(*RISE_S)) * pwm_hz)))
    sums = np.concatenate((np.zeros(len(rise)), np.cumsum(load)))
    return np.asarray((sums[len(rise) :] - sums[: -len(rise)]) / len(rise), dtype=np.float64)


def follows(signals: dict[str, NDArray[np.float64]], drive: Drive) -> bool:
    """Whether a drive without effects can do what is asked of it."""
    limit_v = drive.meta["dc_link_v"] / math.sqrt(3.0)
    size_v = np.hypot(signals["vd_v"], signals["vq_v"])
    off = np.abs(signals["true_speed_rad_s"] - signals["speed_ref_rad_s"])
    at_limit = np.hypot(signals["id_ref_a"], signals["iq_ref_a"]) > 1.49 * drive.meta["motor"]["rated_current_a"]
    return bool(
        np.all(np.isfinite(size_v))
        and np.mean(size_v > 0.98 * limit_v) < 0.01
        and np.mean(at_limit) < 0.2
        and np.median(off) < 0.02 * drive.full_speed_rad_s
    )
