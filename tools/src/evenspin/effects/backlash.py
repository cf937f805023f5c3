"""Backlash between rotor and load: chaotic at the flanks, so that no log repeats, and many local minima."""

import itertools
from math import exp, log

from evenspin.effects.hypothesis import Coordinate, Hypothesis, Scale, odds

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
