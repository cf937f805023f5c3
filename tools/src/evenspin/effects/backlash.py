"""Backlash between rotor and load: chaotic at the flanks, so that no log repeats, and many local minima."""

import itertools
from math import cos, exp, log, pi, sin, sqrt

import numpy as np

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Scale, odds

STARTS = ((-0.6, 110.0, 0.4), (0.5, 110.0, 0.0), (-0.6, 190.0, 0.0), (0.5, 190.0, 0.4))  # odds, Hz, friction share
GAPS_RAD = (0.004, 0.01, 0.025, 0.06)


def hypothesis(scale: Scale) -> Hypothesis:
    return Hypothesis(
        "backlash",
        (
            Coordinate("log_gap", 0.15, log(2e-4), log(0.5), 0.5),
            Coordinate("log_odds", 0.15, -3.0, 3.0, 0.8),
            Coordinate("log_f_res", 0.2, log(20.0), log(900.0), 0.7),
            Coordinate("log_damping", 0.5, log(0.002), log(0.9), 0.8),
            Coordinate("load_friction_share", 0.3, 0.0, 1.0, 0.35, least_repeatable=0.0),
        ),
        lambda z: {
            "gap_rad": exp(float(z[0])),
            "load_ratio": odds(z[1]),
            "f_res_hz": exp(float(z[2])),
            "damping_ratio": exp(float(z[3])),
            "load_friction_share": float(z[4]),
        },
        lambda z: exp(float(z[0])) / 5e-4,
        tuple(
            (log(gap), share, log(f), log(0.1), friction)
            for gap, (share, f, friction) in itertools.product(GAPS_RAD, STARTS)
        ),
        linear=False,
        simpler=("two_mass", (2, 1, 3, 4)),
    )


MOST_DAMPING = 0.95


def swing_of(
    theta_m_rad: Array, f_hz: float, damping_ratio: float, gap_rad: float, period_s: float, load_rad_s2: Array | None
) -> Array:
    """Rotor less load. On a flank the load hangs on the rotor by a damped spring that pushes and never pulls, between
    them it coasts. From row to row the rotor moves evenly, and the load is on one flank or on none."""
    ff, fd, df, dd = _flank(f_hz, damping_ratio, period_s)
    rate = 2.0 * pi * f_hz
    square, damping, half = rate * rate, 2.0 * damping_ratio * rate, 0.5 * gap_rad
    rotor = (theta_m_rad - theta_m_rad[0]).tolist()
    slow = [0.0] * len(rotor) if load_rad_s2 is None else load_rad_s2.tolist()
    out = [0.0] * len(rotor)
    load, speed = 0.0, 0.0
    for k in range(len(rotor) - 1):
        twist = rotor[k] - load
        out[k] = twist
        turns = (rotor[k + 1] - rotor[k]) / period_s
        side = 1.0 if twist > half else -1.0 if twist < -half else 0.0
        depth, faster = twist - side * half, turns - speed
        if side != 0.0 and side * (square * depth + damping * faster) > 0.0:
            rest = slow[k] / square  # the twist that holds the load
            depth -= rest
            depth, faster = ff * depth + fd * faster + rest, df * depth + dd * faster
            load, speed = rotor[k + 1] - side * half - depth, turns - faster
        else:
            load += (speed - 0.5 * slow[k] * period_s) * period_s
            speed -= slow[k] * period_s
    out[-1] = rotor[-1] - load
    return np.asarray(out)


def _flank(f_hz: float, damping_ratio: float, period_s: float) -> tuple[float, float, float, float]:
    """Depth and its speed after a row, from those before it."""
    rate = 2.0 * pi * f_hz
    share = min(damping_ratio, MOST_DAMPING)
    fades, swings = share * rate, rate * sqrt(1.0 - share * share)
    left, c, s = exp(-fades * period_s), cos(swings * period_s), sin(swings * period_s)
    return (
        left * (c + fades / swings * s),
        left * s / swings,
        -left * rate * rate / swings * s,
        left * (c - fades / swings * s),
    )
