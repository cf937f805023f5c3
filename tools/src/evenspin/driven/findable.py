"""Said before the work begins: from which size on each effect shows in what was recorded, and what would add most."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from evenspin.native import tables
from evenspin.weakform.equations import Equations
from evenspin.weakform.fit import Normal, prior_of
from evenspin.weakform.search import PRICE
from evenspin.weakform.shaft import grid_hz
from evenspin.weakform.signals import SLOW_S, Signals
from evenspin.weakform.terms import Kind, Term

MUCH = 3.0  # times the least size: from there on the log hardly shows an effect
NEVER = {
    "current_filter": "looks like a voltage that comes late: what the controller adds for its delay is not known",
    "current_loop_delay": "looks like a voltage that comes late: what the controller adds for its delay is not known",
}


BACKLASH = "backlash"
SHAFTS = ("two_mass", BACKLASH)


@dataclass(frozen=True, slots=True)
class Findable:
    """`times`: smallest size that the log shows, over the least size that counts; infinite where it shows none."""

    effect: str
    times: float
    why: str


def findable(
    terms: Sequence[Term], normal: Normal, equations: Sequence[Equations], opened: bool = False
) -> list[Findable]:
    """`opened`: crossings of a gap were seen."""
    logs = [each.signals for each in equations]
    found: dict[str, Findable] = {}
    held = prior_of(terms, ())
    inverse = np.linalg.inv(normal.h + held)
    at = 0
    for term in terms:
        here = slice(at, at + len(term))
        at += len(term)
        if term.kind is not Kind.EFFECT:
            continue
        main = ~term.details
        variance = np.diag(inverse)[here][main]
        freed = 1.0 / np.maximum(
            1.0 / variance - np.diag(held)[here][main], 1e-300
        )  # without what holds this coordinate itself
        z = term.off.copy()
        z[main] += math.sqrt(PRICE) * np.sqrt(freed)
        times = term.least(np.clip(z, term.low, term.high))
        known = found.get(term.effect)
        if known is None or times < known.times:
            why = "the tolerance decides" if times < 1.0 else "the noise of the log decides"
            found[term.effect] = Findable(term.effect, times, why)
    if opened:
        found[BACKLASH] = Findable(BACKLASH, 1.0, "what looks like crossings of its gap is in the log")
    for name, effect in tables().effects.items():
        if name not in found and not effect.scenario_only:
            why = (
                _shaft(equations)
                if name in SHAFTS and all(log.shows_orders for log in logs)
                else NEVER.get(name, _missing(logs))
            )
            found[name] = Findable(name, math.inf, why)
    return list(found.values())


def _shaft(equations: Sequence[Equations]) -> str:
    """The least size of a compliant shaft that shows hangs on its antiresonance: the range that was tried."""
    tried = grid_hz(equations)
    return f"no antiresonance between {tried[0]:.3g} and {tried[-1]:.3g} Hz stands out of what is left"


def _missing(logs: Sequence[Signals]) -> str:
    if not all(log.has_angle for log in logs):
        return "needs the angle"
    if not all(log.shows_orders for log in logs):
        return f"needs more than {1.0 / SLOW_S:.0f} rows per second"
    return "needs the voltages" if not any(log.has_voltages for log in logs) else "no equation of the log has it"


def advice(found: Sequence[Findable], logs: Sequence[Signals]) -> str:
    """The cheapest extra signal or experiment that would add most."""
    weak = [each.effect for each in found if each.times > MUCH and each.effect not in (*NEVER, *SHAFTS)]
    if not all(log.has_angle for log in logs):
        return "record the angle of the encoder: what repeats with it, and errors of the current sensors, need it"
    if not any(log.has_voltages for log in logs):
        return "record the commanded voltages: resistance, flux, dead time and saturation need them"
    speeds = np.concatenate([log.speed_rad_s[:: max(1, len(log) // 2000)] for log in logs])
    top = float(np.max(np.abs(speeds)))
    both = min(float(np.max(speeds)), -float(np.min(speeds))) > 0.3 * top
    if not both:
        return (
            "record the other direction, too: Coulomb friction and a load of fixed sign are one thing in one direction"
        )
    moving = np.abs(speeds[np.abs(speeds) > 0.02 * top])
    if float(np.percentile(moving, 90.0)) < 1.6 * float(np.percentile(moving, 10.0)):
        return "record several speeds, with ramps between them: friction by its kind, inertia and flux need them"
    if weak and "inductance_saturation" in weak or "winding_resistance" in weak:
        return f"record a load, up to the rated current: {', '.join(weak)} show with current alone"
    if weak:
        return f"record some minutes more at low speed: {', '.join(weak)} show there"
    return "nothing is missing for the effects that a log without the controller can show"
