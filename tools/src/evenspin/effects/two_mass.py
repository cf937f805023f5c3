"""A load behind a twisting shaft: many local minima over the resonance."""

import functools
from math import exp, log, pi, sqrt

import numpy as np

from evenspin.effects.hypothesis import Array, Coordinate, Hypothesis, Params, Scale, odds


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


ANTIRESONANCE_HZ, DAMPING = (2.0, 1000.0), (0.003, 0.2)  # more is no shaft
MOST_RATIO = 0.97
SMALL_RATIO = 0.01


def of_antiresonance(scale: Scale) -> Hypothesis:
    """The same in coordinates in which a torque balance with the measured angle of the rotor is linear, or nearly so:
    the load alone on its spring swings at the antiresonance, whatever its share of the inertia."""
    return Hypothesis(
        "two_mass",
        (
            Coordinate("load_ratio", 0.1, 0.0, MOST_RATIO),
            Coordinate("log_f_antiresonance", 0.03, log(ANTIRESONANCE_HZ[0]), log(ANTIRESONANCE_HZ[1])),
            Coordinate("log_damping", 0.2, log(DAMPING[0]), log(DAMPING[1])),
        ),
        _of_antiresonance,
        lambda z: max(float(z[0]), 0.0) / 0.02,
        ((0.0, log(40.0), log(0.05)),),
        linear=False,
    )


def _of_antiresonance(z: Array) -> Params:
    ratio = min(max(float(z[0]), 0.0), MOST_RATIO)
    free = sqrt(1.0 - ratio)  # of the rotor: resonance and its damping ratio are as much higher
    return {"f_res_hz": exp(float(z[1])) / free, "load_ratio": ratio, "damping_ratio": exp(float(z[2])) / free}


def twist_rad(params: Params, theta_m_rad: Array, period_s: float) -> Array:
    """load_ratio times the angle by which the rotor is ahead of the load. Starts without twist. What a torque on the
    load twists is in `held_back_nm`."""
    shaft = _shaft(params)
    return (
        np.zeros(len(theta_m_rad)) if shaft is None else params["load_ratio"] * swing_of(theta_m_rad, *shaft, period_s)
    )


def held_back_nm(params: Params, load_nm: Array, period_s: float) -> Array:
    """A torque on the load swings it at its antiresonance, whatever its share of the inertia is; where that share is
    all but none, as much as goes with a share of one half."""
    shaft = _shaft(params)
    if shaft is None:
        return np.zeros(len(load_nm))
    ratio = params["load_ratio"]
    return (1.0 if ratio > SMALL_RATIO else 2.0 * ratio) * swing_of(load_nm, *shaft, period_s)


def _shaft(params: Params) -> tuple[float, float] | None:
    """Antiresonance and its damping ratio; None: stiff."""
    if params["f_res_hz"] <= 0.0 or params["load_ratio"] <= 0.0:
        return None
    free = sqrt(1.0 - params["load_ratio"])
    return params["f_res_hz"] * free, params["damping_ratio"] * free


def swing_of(theta_m_rad: Array, f_hz: float, damping_ratio: float, period_s: float) -> Array:
    """Rotor less load, where the load hangs on the rotor by a spring with which it alone swings at `f_hz`."""
    from scipy.signal import lfilter

    over, under = follower(f_hz, damping_ratio, period_s)
    rows = np.arange(len(theta_m_rad))
    first = theta_m_rad[: len(rows[:2])]
    moved = theta_m_rad - first[0] - (first[-1] - first[0]) * rows  # a straight line passes unchanged
    return np.asarray(moved - lfilter(over, under, moved))


@functools.lru_cache(maxsize=1024)
def follower(f_hz: float, damping_ratio: float, period_s: float) -> tuple[Array, Array]:
    """Numerator and denominator of rotor to load, in z; from row to row the rotor moves evenly."""
    from scipy.signal import cont2discrete

    rate = 2.0 * pi * f_hz
    damping = 2.0 * damping_ratio * rate
    over, under, _ = cont2discrete(([damping, rate**2], [1.0, damping, rate**2]), period_s, method="foh")
    return np.ravel(over), np.ravel(under)
