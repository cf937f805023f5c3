"""What may be missing from a model, in coordinates in which a search can move.

A coordinate is chosen so that its effect on a log is nearly linear: a sine and a cosine for amplitude and phase, the
logarithm of a factor, the inverse square of a saturation current.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.native import tables
from evenspin.native.tables import EffectParam

Array = NDArray[np.float64]
Params = dict[str, float]
SMALL_TORQUE = 0.0025  # of the rated torque: less counts as no effect


@dataclass(frozen=True, slots=True)
class Coordinate:
    name: str
    probe: float  # a step that shows clearly and is still nearly linear
    low: float = -math.inf
    high: float = math.inf
    spread: float = 0.0  # half the pitch of the grid of starts, for effects that are not linear
    least_repeatable: float | None = (
        None  # where the logs of an effect repeat least, if that depends on this coordinate
    )
    form: bool = False  # one of the forms of an effect: at its low end it is off, and only a variant turns it on
    beside: int | None = None  # probed beside this coordinate, to which it is relative


@dataclass(frozen=True, slots=True)
class Hypothesis:
    name: str
    coordinates: tuple[Coordinate, ...]
    to_params: Callable[[Array], Params]
    magnitude: Callable[[Array], float]  # over what tolerance and format call "no effect": 1 is its edge
    starts: tuple[tuple[float, ...], ...]  # one at the off point where the effect is linear; else a grid
    linear: bool = True
    simpler: tuple[str, tuple[int, ...]] | None = None  # an effect that this one holds, and which coordinates make it
    rests: bool = False  # a sine and a cosine of a torque in which the rotor can come to rest
    # Forms that a simulator or a machine may have it in: values of coordinates that are details. Between them the cost
    # has local minima.
    variants: tuple[Mapping[int, float], ...] = ()
    amplitude: int | None = None  # coordinate that scales the signature of an effect that is not linear

    @property
    def is_shaft(self) -> bool:
        """There is one shaft: two of these are not searched together."""
        return tables().effects[self.name].acts_on == "shaft"

    def least_repeatable(self, z: Array) -> Array:
        """The point where its logs repeat least: there what does not repeat is known to be noise."""
        least = [
            x if c.least_repeatable is None else c.least_repeatable for x, c in zip(z, self.coordinates, strict=True)
        ]
        return np.array(least, dtype=np.float64)

    def is_asked(self, i: int, z: Array) -> bool:
        """Whether a search moves a coordinate from there."""
        return not self.coordinates[i].form or z[i] > self.coordinates[i].low

    def clip(self, z: Array) -> Array:
        low, high = ([getattr(c, key) for c in self.coordinates] for key in ("low", "high"))
        return np.asarray(np.clip(z, low, high), dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Scale:
    """What the sizes of effects are measured by in one machine."""

    rated_current_a: float
    rated_torque_nm: float
    pole_pairs: int
    slots: int  # 0: not known
    counts_per_rev: float
    cogging_order: int | None = None  # that of slots and poles unless given

    @classmethod
    def of(cls, motor: Mapping[str, Any], counts_per_rev: float, cogging_order: int | None = None) -> Scale:
        """From `motor` of a meta.json."""
        slots = int(motor.get("slots", 0) or 0)
        rated = float(motor["rated_current_a"]), float(motor["rated_torque_nm"])
        return cls(*rated, int(motor["pole_pairs"]), slots, counts_per_rev, cogging_order)

    @property
    def small_torque_nm(self) -> float:
        return SMALL_TORQUE * self.rated_torque_nm


def single(name: str, param: str, probe: float, low: float, high: float, edge: float) -> Hypothesis:
    """One parameter that is 0 when the effect is off; `edge`: the size that counts."""
    return Hypothesis(
        name,
        (Coordinate(param, probe, low, high),),
        lambda z: {param: float(z[0])},
        lambda z: abs(float(z[0])) / edge,
        ((0.0,),),
    )


def pair(name: str, params: tuple[str, str], probe: float, edge: float, limit: float) -> Hypothesis:
    """Two parameters of which only the length counts."""
    return Hypothesis(
        name,
        tuple(Coordinate(param, probe, -limit, limit) for param in params),
        lambda z: {param: float(x) for param, x in zip(params, z, strict=True)},
        lambda z: float(np.hypot(*z)) / edge,
        ((0.0, 0.0),),
    )


def factor(name: str, probe: float, edge: float) -> Hypothesis:
    """A factor on the nominal machine, by its logarithm."""
    return Hypothesis(
        name,
        (Coordinate("log_factor", probe, math.log(0.1), math.log(30.0)),),
        lambda z: {"factor": math.exp(float(z[0]))},
        lambda z: abs(float(z[0])) / edge,
        ((0.0,),),
    )


def by_difference(h: Hypothesis) -> Hypothesis:
    """The same factor by its difference from 1, in which equations that it multiplies a number of are linear."""
    (log_factor,) = h.coordinates
    probe, low, high = (math.expm1(x) for x in (log_factor.probe, log_factor.low, log_factor.high))
    return replace(
        h,
        coordinates=(Coordinate("factor_less_1", probe, low, high),),
        to_params=lambda z: {"factor": 1.0 + float(z[0])},
        magnitude=lambda z: h.magnitude(np.log1p(np.maximum(z, low))),
    )


def polar(z: Array, amplitude: str, phase: str) -> Params:
    """A sin(x + phase) from its sine and cosine parts."""
    return {amplitude: float(np.hypot(z[0], z[1])), phase: math.atan2(float(z[1]), float(z[0])) % math.tau}


def odds(x: float) -> float:
    """A share between 0 and 1 from its logarithmic odds."""
    return 1.0 / (1.0 + math.exp(-float(x)))


def by_roles(name: str, scale: Scale) -> Hypothesis:
    """An effect without a module of its own, searched by the roles of its parameters.

    An amplitude followed by a phase is a sine and a cosine, a factor goes by its logarithm, any other amplitude, share
    or quantity by itself; orders, signs and details keep their example. Steps and the size that counts are shares of
    the rated torque or current where the unit is one of theirs, else of the example.
    """
    fields = list(tables().effects[name].params.values())
    fixed = {f.name: f.example for f in fields if f.role in ("order", "sign", "detail")}
    coordinates: list[Coordinate] = []
    parts: list[Callable[[Array], Params]] = []
    edges: list[float] = []
    at = 0
    for k, f in enumerate(fields):
        follows = fields[k + 1] if k + 1 < len(fields) else None
        if f.name in fixed or f.role == "phase":
            continue
        size = _size(f, scale)
        if f.role == "amplitude" and follows is not None and follows.role == "phase":
            coordinates += [Coordinate(f"{f.name} {part}", 0.2 * size) for part in ("sine", "cosine")]
            parts.append(_polar_at(at, f.name, follows.name))
            edges += [0.05 * size] * 2
            at += 2
        elif f.role == "factor":
            coordinates.append(Coordinate(f"log {f.name}", 0.1, math.log(0.1), math.log(30.0)))
            parts.append(_exp_at(at, f.name))
            edges.append(0.03)
            at += 1
        else:
            coordinates.append(Coordinate(f.name, 0.2 * size, f.minimum - f.default, f.maximum - f.default))
            parts.append(_offset_at(at, f.name, f.default))
            edges.append(0.05 * size)
            at += 1
    edge = np.array(edges)
    return Hypothesis(
        name,
        tuple(coordinates),
        lambda z: {**fixed, **{key: value for part in parts for key, value in part(z).items()}},
        lambda z: float(np.max(np.abs(z) / edge)),
        ((0.0,) * at,),
    )


def _size(f: EffectParam, scale: Scale) -> float:
    """A deviation that shows clearly in this machine."""
    example = abs(f.example - f.default) or 1.0
    return {"N m": 0.1 * scale.rated_torque_nm, "A": 0.05 * scale.rated_current_a}.get(f.unit, example)


def _polar_at(at: int, amplitude: str, phase: str) -> Callable[[Array], Params]:
    return lambda z: polar(z[at : at + 2], amplitude, phase)


def _exp_at(at: int, name: str) -> Callable[[Array], Params]:
    return lambda z: {name: math.exp(float(z[at]))}


def _offset_at(at: int, name: str, off: float) -> Callable[[Array], Params]:
    return lambda z: {name: off + float(z[at])}
