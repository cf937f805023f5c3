"""What may be off the model: effects of the table, deviations of the unit, and causes that the table does not have.

Every term has coordinates in which the equations are nearly linear. A term that is not named is held near its off
point by its tolerance, so that a deviation of the unit is never mistaken for an effect.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import Hypothesis, Scale, by_difference, hypotheses
from evenspin.effects.equations import has_equation, is_mechanical
from evenspin.effects.two_mass import of_antiresonance
from evenspin.weakform.noise import Noise
from evenspin.weakform.tolerances import HELD, HELD_ALONE, Tolerances

Array = NDArray[np.float64]

ALONE = ("encoder_offset",)  # it acts on an axis of its own: no other deviation shares what it does
STEP = 0.02  # of a coordinate's probe, for its column
OVER_TIME = 0.2  # of the least voltage: separates what changes with time from what is always there
FREE = 30.0  # times the least size: how far a named effect may go before anything holds it


class Kind(Enum):
    EFFECT = "effect"  # of the table: may be named
    UNIT = "unit"  # this machine and this log: always fitted, never named
    FOREIGN = "foreign"  # what no effect of the table is


@dataclass(frozen=True, slots=True)
class Term:
    """`details`: coordinates that say how an effect acts and mean nothing while it is off."""

    name: str
    kind: Kind
    off: Array
    step: Array
    held: Array  # standard deviation of each coordinate while the term is not named
    free: Array
    low: Array
    high: Array
    details: NDArray[np.bool_]
    least: Callable[[Array], float]  # size over the least size
    hypothesis: Hypothesis | None = None
    effect: str = ""
    shaft_only: bool = False
    columns: Callable[[Any], Sequence[Array | None]] | None = None  # of a foreign term: per equation of a log
    log: int | None = None  # of this log alone
    variant: bool = False  # one of several of the same effect, of which one acts
    together: float | None = None  # standard deviation of the mean of all coordinates, named or not
    alike: tuple[str, ...] = ()  # effects without an equation that these logs do not separate from it
    over_angle: bool = False  # repeats with it: at high speeds windows average it away
    edge: float = 1.0  # of what a term that acts on the winding has to change there, rms
    noise: tuple[Noise, ...] = ()  # of each log, where more of it is taken out of the sums than is known

    def __len__(self) -> int:
        return len(self.off)


@dataclass(frozen=True, slots=True)
class Sizes:
    """What sizes are measured by: of the machine, of the bench, of the bridge and of the logs."""

    scale: Scale
    tolerances: Tolerances
    pwm_hz: float
    top_rad_s: float


def effect_terms(
    sizes: Sizes, has_angle: bool, has_voltages: bool, cogging: Sequence[int], has_load: bool = True
) -> list[Term]:
    """Every effect that this log can show, with its least size."""
    scale = sizes.scale
    terms: list[Term] = []
    for name, hypothesis in hypotheses(scale).items():
        if not has_equation(name) or name == SHAFT:  # that has a search of its own
            continue
        if not has_angle and name in TIED_TO_ANGLE:
            continue
        if not has_voltages and (name in ONLY_VOLTAGES or (name == "torque_constant" and not has_load)):
            continue
        if name == "cogging":
            for order in cogging:
                made = hypotheses(_with_order(scale, order))["cogging"]
                terms.append(_effect(made, f"cogging@{order}", sizes, np.zeros(2)))
        elif name == "stribeck_friction":
            for share in STRIBECK_SHARES:
                off = np.array([0.0, np.log(share * sizes.top_rad_s)])
                terms.append(_effect(hypothesis, f"{name}@{share:g}", sizes, off))
        elif name == "dead_time":
            for share in SOFT_SHARES:
                off = np.array([0.0, share * scale.rated_current_a, 0.0])
                terms.append(_effect(hypothesis, f"{name}@{share:g}", sizes, off))
        elif name in NUMBER_OF:
            terms.append(_effect(by_difference(hypothesis), name, sizes, np.zeros(1)))
        else:
            off = np.array(hypothesis.starts[0], dtype=np.float64)
            if name == "inductance_saturation":
                off = np.zeros(3)
            terms.append(_effect(hypothesis, name, sizes, off))
    return terms


SHAFT = "two_mass"
ONLY_VOLTAGES = ("winding_resistance", "dead_time", "inductance_saturation", "encoder_offset")
TIED_TO_ANGLE = ("cogging", "misalignment", "encoder_eccentricity", "current_offset", "current_gain", "flux_harmonics")
STRIBECK_SHARES = (0.05, 0.02, 0.12)  # of the top speed
SOFT_SHARES = (0.015, 0.003, 0.05)  # of the rated current
DETAILS = {
    "dead_time": (1, 2),
    "stribeck_friction": (1,),
    "inductance_saturation": (1, 2),
    "coulomb_friction": (1, 2),
    "two_mass": (1, 2),
}
DETAIL_SIGMA = {
    "dead_time": (0.4, 1e-3),
    "stribeck_friction": (0.7,),
    "inductance_saturation": (1e-3, 1e-3),
    "two_mass": (0.1, 0.7),
    "coulomb_friction": (1e-3, 1e-3),  # windows in which the shaft rests are left out: sliding friction alone
}


TOGETHER = 1e-3  # a gain of all currents, beside inertia, friction and resistance, is a scale that no equation fixes


def _with_order(scale: Scale, order: int) -> Scale:
    return replace(scale, cogging_order=order)


def _effect(h: Hypothesis, name: str, sizes: Sizes, off: Array) -> Term:
    times = sizes.tolerances.scaled(h, sizes.scale, sizes.pwm_hz)
    details = np.zeros(len(off), dtype=bool)
    details[list(DETAILS.get(h.name, ()))] = True
    step = np.array([c.probe for c in h.coordinates]) * STEP
    edge = np.array([_edge(h, off, k, times) if not details[k] else 1.0 for k in range(len(off))])
    held, free = edge / (HELD_ALONE if h.name in ALONE else HELD), edge * FREE
    for k, sigma in zip(DETAILS.get(h.name, ()), DETAIL_SIGMA.get(h.name, ()), strict=True):
        held[k] = free[k] = sigma * (off[k] if h.name == "dead_time" and k == 1 else 1.0)
    low = np.array([c.low for c in h.coordinates])
    high = np.array([c.high for c in h.coordinates])
    return Term(
        name,
        Kind.EFFECT,
        off,
        step,
        held,
        free,
        low,
        high,
        details,
        lambda z: h.magnitude(z) / times,
        h,
        h.name,
        is_mechanical(h.name),
        variant="@" in name and h.name != "cogging",
        together=TOGETHER if h.name == "current_gain" else None,
        over_angle=h.name in TIED_TO_ANGLE,
    )


def _edge(h: Hypothesis, off: Array, k: int, times: float) -> float:
    """How far coordinate k goes until the effect has its least size."""

    def size(x: float) -> float:
        z = off.copy()
        z[k] += x
        return h.magnitude(z)

    low, high = 0.0, h.coordinates[k].probe
    while size(high) < times:
        low, high = high, 2.0 * high
        if high > 1e6 * h.coordinates[k].probe:
            return h.coordinates[k].probe
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if size(middle) < times else (low, middle)
    return high


def shaft_term(f_hz: float, damping: float, sizes: Sizes, alike: tuple[str, ...], noise: tuple[Noise, ...]) -> Term:
    """A load behind a shaft that twists, near this antiresonance."""
    off = np.array([0.0, np.log(f_hz), np.log(damping)])
    made = _effect(of_antiresonance(sizes.scale), f"{SHAFT}@{f_hz:.4g}", sizes, off)
    return replace(made, alike=alike, noise=noise)


NUMBER_OF = {  # of the plant, that an effect is a factor on
    "winding_resistance": "resistance_ohm",
    "torque_constant": "psi_wb",
    "inertia": "inertia_kgm2",
    "viscous_friction": "viscous_nms",
}
OPEN = 0.3  # one standard deviation of a number that the log itself gave, by another fit


def opened(term: Term) -> Term:
    """A factor on a number that nobody stated: fitted, and never named."""
    return replace(term, kind=Kind.UNIT, held=np.full(1, OPEN), free=np.full(1, OPEN))


def unit_term(name: str, sigma: float, step: float, off: float = 0.0, log: int | None = None) -> Term:
    """A number of the unit or of a log that is always fitted."""
    one = np.ones(1)
    return Term(
        name,
        Kind.UNIT,
        off * one,
        step * one,
        sigma * one,
        sigma * one,
        -np.inf * one,
        np.inf * one,
        np.zeros(1, dtype=bool),
        lambda z: 0.0,
        log=log,
    )


def foreign_term(
    name: str,
    columns: Callable[[Any], Sequence[Array | None]],
    edge: Sequence[float],
    over_angle: bool = False,
    over_time: bool = False,
) -> Term:
    """A cause that the table does not have, linear in its size. `over_time`: it changes through a log, while what the
    equations of the winding lack stays the same."""
    edges = np.array(edge)
    n = len(edges)
    return Term(
        f"foreign: {name}",
        Kind.FOREIGN,
        np.zeros(n),
        np.ones(n),
        edges * 1e-6,
        edges * FREE,
        np.full(n, -np.inf),
        np.full(n, np.inf),
        np.zeros(n, dtype=bool),
        lambda z: float(np.linalg.norm(z / edges)),
        columns=columns,
        over_angle=over_angle,
        edge=OVER_TIME if over_time else 1.0,
    )
