"""What may be missing: every effect of the simulator's table, in coordinates in which a search can move.

A coordinate is chosen so that its effect on a log is nearly linear: a sine and a cosine for amplitude and phase, the
logarithm of a factor, the inverse square of a saturation current. An effect without an entry here is searched over its
own parameters, so that a new file in sim_host/effects/ is a new hypothesis.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.features import slot_order
from evenspin.gap.tolerance import TOLERANCE_EFFECTS
from evenspin.native import tables

Params = dict[str, float]
Motor = Mapping[str, float]
BACKLASH_STARTS = ((-0.6, 110.0, 0.4), (0.5, 110.0, 0.0), (-0.6, 190.0, 0.0), (0.5, 190.0, 0.4))
EDGES_LEAST = 0.02  # a smaller share of the loss at edges is none: the simulation is faster without
COMPOSITE = ("torque_ripple",)  # sums of others, for scenarios: never an explanation


@dataclass(frozen=True, slots=True)
class Coordinate:
    name: str
    probe: float  # a step that shows clearly and is still nearly linear
    low: float = -math.inf
    high: float = math.inf
    spread: float = 0.0  # half the pitch of the grid of starts, for effects that are not linear
    wildest: float | None = None  # where the logs of an effect repeat least, if that depends on this coordinate
    beside: int | None = None  # probed beside this coordinate, to which it is relative


@dataclass(frozen=True, slots=True)
class Hypothesis:
    name: str
    coordinates: tuple[Coordinate, ...]
    to_params: Callable[[NDArray[np.float64]], Params]
    magnitude: Callable[[NDArray[np.float64]], float]  # over what tolerance and format call "no effect": 1 is its edge
    starts: tuple[tuple[float, ...], ...]  # one at the off point where the effect is linear; else a grid
    linear: bool = True
    simpler: tuple[str, tuple[int, ...]] | None = None  # an effect that this one holds, and which coordinates make it
    rests: bool = False  # a sine and a cosine of a torque in which the rotor can come to rest
    amplitude: int | None = None  # coordinate that scales the signature of an effect that is not linear

    @property
    def is_tolerance(self) -> bool:
        """The same number as one of the tolerances, only further off."""
        return self.name in TOLERANCE_EFFECTS

    @property
    def is_shaft(self) -> bool:
        """There is one shaft: two of these are not looked for together."""
        return tables().effects[self.name].acts_on == "shaft"

    def as_wild_as_can_be(self, z: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where its logs repeat least: there what does not repeat is known to be noise."""
        least = [x if c.wildest is None else c.wildest for x, c in zip(z, self.coordinates, strict=True)]
        return np.array(least, dtype=np.float64)

    def clip(self, z: NDArray[np.float64]) -> NDArray[np.float64]:
        low, high = ([getattr(c, key) for c in self.coordinates] for key in ("low", "high"))
        return np.clip(z, low, high)


def hypotheses(motor: Motor, counts_per_rev: float, cogging_order: int | None = None) -> dict[str, Hypothesis]:
    """The whole table for this machine, by name; `cogging_order`: that of slots and poles unless given."""
    known = {h.name: h for h in _vocabulary(motor, counts_per_rev, cogging_order)}
    table = tables().effects
    out = {name: known[name] for name in table if name in known}
    out.update({name: _generic(name) for name in table if name not in known and name not in COMPOSITE})
    return out


def _vocabulary(m: Motor, counts: float, cogging_order: int | None) -> list[Hypothesis]:
    amps, torque, p = m["rated_current_a"], m["rated_torque_nm"], m["pole_pairs"]
    slots = int(m.get("slots", 0) or 0)
    order = float(cogging_order or (slot_order(int(p), slots) if slots > 0 else 6 * p))
    small_torque = 0.0025 * torque
    log = math.log
    return [
        _pair("current_offset", ("offset_a_a", "offset_b_a"), 0.01 * amps, 0.028, amps),
        Hypothesis(
            "current_gain",
            (Coordinate("gain_a", 0.03, -0.5, 0.5), Coordinate("gain_b", 0.03, -0.5, 0.5)),
            lambda z: {"gain_a": 1.0 + float(z[0]), "gain_b": 1.0 + float(z[1])},
            lambda z: abs(float(z[0] - z[1])) / 0.008,
            ((0.0, 0.0),),
        ),
        Hypothesis(
            "dead_time",
            (
                Coordinate("dead_time_s", 1e-6, 0.0, 1.9e-5),
                Coordinate("soft_a", 0.01 * amps, 0.0, 0.05 * amps),
                Coordinate("by_edges", 0.3, 0.0, 1.0),
            ),
            _dead_time,
            lambda z: abs(float(z[0])) / 1e-7,
            ((0.0, 0.005 * amps, 0.5 * EDGES_LEAST),),
        ),
        Hypothesis(
            "cogging",
            (Coordinate("sine", 0.02 * torque), Coordinate("cosine", 0.02 * torque)),
            lambda z: {**_polar(z, "amplitude_nm", "phase_rad"), "order": order},
            lambda z: float(np.hypot(*z)) / small_torque,
            ((0.0, 0.0),),
            rests=True,
        ),
        Hypothesis(
            "flux_harmonics",
            (Coordinate("ripple", 0.02, -0.5, 0.5), Coordinate("unequal", 0.02, -0.5, 0.5)),
            _flux_harmonics,
            lambda z: float(np.hypot(*z)) / 0.003,
            ((0.0, 0.0),),
        ),
        _single("coulomb_friction", "torque_nm", 0.02 * torque, 0.0, torque, small_torque),
        Hypothesis(
            "stribeck_friction",
            (
                Coordinate("torque_nm", 0.02 * torque, 0.0, torque, 0.02 * torque),
                Coordinate("log_speed", 0.1, log(0.1), log(60.0), 0.5),
            ),
            lambda z: {"torque_nm": float(z[0]), "speed_rad_s": math.exp(float(z[1])), "shape": 2.0},
            lambda z: abs(float(z[0])) / small_torque,
            tuple((0.03 * torque, log(w)) for w in (0.8, 2.5, 6.0, 15.0)),
            linear=False,
            amplitude=0,
        ),
        _factor("viscous_friction", 0.3, 0.12),
        _factor("inertia", 0.1, 0.036),
        _single("load_torque", "torque_nm", 0.02 * torque, -torque, torque, small_torque),
        Hypothesis(
            "misalignment",
            (
                Coordinate("sine", 0.02 * torque),
                Coordinate("cosine", 0.02 * torque),
                Coordinate("sine2", 0.02 * torque, beside=0),
                Coordinate("cosine2", 0.02 * torque, beside=0),
            ),
            _misalignment,
            lambda z: float(np.linalg.norm(z)) / small_torque,
            ((0.0,) * 4,),
        ),
        Hypothesis(
            "encoder_eccentricity",
            (Coordinate("sine", 0.003, -0.4, 0.4), Coordinate("cosine", 0.003, -0.4, 0.4)),
            lambda z: _polar(z, "amplitude_rad", "phase_rad"),
            lambda z: float(np.hypot(*z)) / max(2e-4, 0.25 * math.tau / max(counts, 1.0)),
            ((0.0, 0.0),),
        ),
        _single("encoder_offset", "angle_el_rad", 0.05, -1.4, 1.4, 0.01),
        _single("current_loop_delay", "extra_periods", 0.3, 0.0, 6.0, 0.03),
        _factor("torque_constant", 0.04, 0.012),
        _factor("winding_resistance", 0.1, 0.036),
        Hypothesis(
            "inductance_saturation",
            (
                Coordinate("inverse_square", (0.35 / amps) ** 2, 0.0, (4.0 / amps) ** 2),
                Coordinate("by_amplitude", 0.3, 0.0, 1.0),
                Coordinate("by_slope", 0.3, 0.0, 1.0),
            ),
            lambda z: {
                "i_sat_a": 1.0 / math.sqrt(float(z[0])) if z[0] > (1e-3 / amps) ** 2 else 0.0,
                "by_amplitude": float(z[1]),
                "by_slope": float(z[2]),
            },
            lambda z: math.sqrt(max(float(z[0]), 0.0)) * amps / 0.15,
            ((0.0, 0.5, 0.5),),
        ),
        Hypothesis(
            "two_mass",
            (
                Coordinate("log_f_res", 0.03, log(5.0), log(900.0), 0.22),
                Coordinate("log_odds", 0.15, -3.0, 3.0, 1.2),
                Coordinate("log_damping", 0.3, log(0.002), log(0.9), 0.8),
                Coordinate("load_friction_share", 0.3, 0.0, 1.0, 0.5),
            ),
            lambda z: {
                "f_res_hz": math.exp(float(z[0])),
                "load_ratio": _odds(z[1]),
                "damping_ratio": math.exp(float(z[2])),
                "load_friction_share": float(z[3]),
            },
            lambda z: _odds(z[1]) / 0.02,
            tuple((log(f), 0.0, log(0.03), 0.3) for f in (15.0, 22.0, 33.0, 47.0, 68.0, 100.0, 150.0, 230.0)),
            linear=False,
        ),
        Hypothesis(
            "backlash",
            (
                Coordinate("log_gap", 0.15, log(2e-4), log(0.5), 0.5),
                Coordinate("log_odds", 0.15, -3.0, 3.0, 0.8),
                Coordinate("log_f_res", 0.2, log(20.0), log(900.0), 0.7),
                Coordinate("log_damping", 0.5, log(0.002), log(0.9), 0.8),
                Coordinate("load_friction_share", 0.3, 0.0, 1.0, 0.35, wildest=0.0),
            ),
            lambda z: {
                "gap_rad": math.exp(float(z[0])),
                "load_ratio": _odds(z[1]),
                "f_res_hz": math.exp(float(z[2])),
                "damping_ratio": math.exp(float(z[3])),
                "load_friction_share": float(z[4]),
            },
            lambda z: math.exp(float(z[0])) / 5e-4,
            tuple(
                (log(gap), odds, log(f), log(0.1), share)
                for gap, (odds, f, share) in itertools.product((0.004, 0.01, 0.025, 0.06), BACKLASH_STARTS)
            ),
            linear=False,
            simpler=("two_mass", (2, 1, 3, 4)),
        ),
        _single("current_filter", "tau_s", 3e-5, 0.0, 3e-3, 5e-6),
    ]


def _single(name: str, param: str, probe: float, low: float, high: float, edge: float) -> Hypothesis:
    return Hypothesis(
        name,
        (Coordinate(param, probe, low, high),),
        lambda z: {param: float(z[0])},
        lambda z: abs(float(z[0])) / edge,
        ((0.0,),),
    )


def _pair(name: str, params: tuple[str, str], probe: float, edge: float, limit: float) -> Hypothesis:
    return Hypothesis(
        name,
        tuple(Coordinate(param, probe, -limit, limit) for param in params),
        lambda z: {param: float(x) for param, x in zip(params, z, strict=True)},
        lambda z: float(np.hypot(*z)) / edge,
        ((0.0, 0.0),),
    )


def _factor(name: str, probe: float, edge: float) -> Hypothesis:
    return Hypothesis(
        name,
        (Coordinate("log_factor", probe, math.log(0.1), math.log(30.0)),),
        lambda z: {"factor": math.exp(float(z[0]))},
        lambda z: abs(float(z[0])) / edge,
        ((0.0,),),
    )


def _generic(name: str) -> Hypothesis:
    """An effect that nobody has described here: its parameters as they are, from where they are off."""
    fields = list(tables().effects[name].params.values())
    off = tuple(f.default for f in fields)
    probes = tuple(0.01 * min(abs(f.maximum - f.default), 100.0) or 0.01 for f in fields)
    return Hypothesis(
        name,
        tuple(Coordinate(f.name, h, f.minimum, f.maximum) for f, h in zip(fields, probes, strict=True)),
        lambda z: {f.name: float(x) for f, x in zip(fields, z, strict=True)},
        lambda z: float(np.max(np.abs((z - np.array(off)) / np.array(probes)))),
        (off,),
    )


def _polar(z: NDArray[np.float64], amplitude: str, phase: str) -> Params:
    """A sin(x + phase) from its sine and cosine parts."""
    return {amplitude: float(np.hypot(z[0], z[1])), phase: math.atan2(float(z[1]), float(z[0])) % math.tau}


def _dead_time(z: NDArray[np.float64]) -> Params:
    """How the loss goes through zero current has no name in the vocabulary: every inverter has its own way."""
    by_edges = float(z[2]) if z[2] > EDGES_LEAST else 0.0
    shape = {"soft_a": float(z[1]), "by_edges": by_edges} if z[0] > 0.0 else {}
    return {"dead_time_s": float(z[0]), **shape}


def _flux_harmonics(z: NDArray[np.float64]) -> Params:
    """Ripple of the q axis and of the d axis; the second is (1 - 2 fifth_share) of the first."""
    ripple = float(z[0]) if abs(z[0]) > 0.2 * abs(z[1]) else math.copysign(0.2 * abs(float(z[1])), float(z[0]))
    share = 0.5 * (1.0 - float(z[1]) / ripple) if ripple != 0.0 else 0.5
    return {"torque_ripple_rel": abs(ripple), "sign": math.copysign(1.0, ripple), "fifth_share": share}


def _misalignment(z: NDArray[np.float64]) -> Params:
    first, second = _polar(z[:2], "a", "p"), _polar(z[2:], "a", "p")
    amplitude = max(first["a"], 2e-6 * second["a"], 1e-12)
    return {
        "amplitude_nm": amplitude,
        "phase_rad": first["p"],
        "second_rel": second["a"] / amplitude,
        "phase2_rad": second["p"],
    }


def _odds(x: float) -> float:
    return 1.0 / (1.0 + math.exp(-float(x)))
