"""A load behind a twisting shaft: many local minima over the resonance."""

from math import exp, log

from evenspin.effects.hypothesis import Coordinate, Hypothesis, Scale, odds


def hypothesis(scale: Scale) -> Hypothesis:
    return Hypothesis(
        "two_mass",
        (
            Coordinate("log_f_res", 0.03, log(5.0), log(900.0), 0.22),
            Coordinate("log_odds", 0.15, -3.0, 3.0, 1.2),
            Coordinate("log_damping", 0.3, log(0.002), log(0.9), 0.8),
            Coordinate("load_friction_share", 0.3, 0.0, 1.0, 0.5),
        ),
        lambda z: {
            "f_res_hz": exp(float(z[0])),
            "load_ratio": odds(z[1]),
            "damping_ratio": exp(float(z[2])),
            "load_friction_share": float(z[3]),
        },
        lambda z: odds(z[1]) / 0.02,
        tuple((log(f), 0.0, log(0.03), 0.3) for f in (15.0, 22.0, 33.0, 47.0, 68.0, 100.0, 150.0, 230.0)),
        linear=False,
    )
