"""A load behind a shaft that twists: the antiresonance at which its swing would be the torque that is left.

The load follows the measured angle of the rotor through a damped spring; what it swings beyond the rotor takes torque
that a stiff shaft does not. Tried over a grid of antiresonances; the best becomes a term that the search may name.
Where one stands out, a shaft with a gap is tried, too, which looks much like a soft one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import backlash, two_mass
from evenspin.weakform.equations import Equations
from evenspin.weakform.fit import Gatherer
from evenspin.weakform.noise import Noise, acceleration_noise, swing_noise
from evenspin.weakform.screen import Left
from evenspin.weakform.signals import Signals
from evenspin.weakform.terms import Sizes, Term, shaft_term

Array = NDArray[np.float64]

LOWEST_HZ = 3.0
HIGHEST = 0.12  # of the rate of the rows
IN_WINDOW = 0.6  # over the half width of the short windows: faster is averaged away there
RATIO = 1.06  # from one antiresonance to the next
DAMPINGS = (0.03, 0.12)
STANDS_OUT = 60.0  # cost that the twist has to take off
LEAST_RATIO, MOST_RATIO = 0.04, 0.97
FLANKS_HZ, GAPS_RAD = (70.0, 140.0), (0.003, 0.006, 0.012, 0.025, 0.05, 0.1)
FINE = 1  # place of the short windows among the equations of a log
FLANK = 0.2  # of the rate of the rows: a faster flank is not resolved
FLANK_DAMPING = 0.1
LIKE_A_GAP = 0.25  # of the cost that a compliant shaft takes off: from there on it may be a gap


def grid_hz(logs: Sequence[Equations]) -> Array:
    """Antiresonances that every log can show."""
    top = min(min(HIGHEST / e.signals.period_s, IN_WINDOW / (e.fine.bump.half * e.signals.period_s)) for e in logs)
    count = int(np.log(max(top, LOWEST_HZ) / LOWEST_HZ) / np.log(RATIO))
    return np.asarray(LOWEST_HZ * RATIO ** np.arange(count + 1))


def shaft_candidates(gatherer: Gatherer, left: Left, sizes: Sizes) -> list[Term]:
    """The best compliant shaft, if one stands out. `left`: of the windows that `gatherer` gives, all of which fit."""

    noise = _at_most(gatherer, left)

    def gain(f_hz: float, damping: float) -> tuple[float, float]:
        found, size = left.gain(*_compliant(gatherer, noise, f_hz, damping))
        return found, float(size[0])

    best, at, share = 0.0, (0.0, 0.0), 0.0
    for f_hz in grid_hz(gatherer.model.logs):
        for damping in DAMPINGS:
            found, ratio = gain(float(f_hz), damping)
            if found > best and LEAST_RATIO < ratio < MOST_RATIO:
                best, at, share = found, (float(f_hz), damping), ratio
    if best < STANDS_OUT:
        return []
    finer = [(at[0] * RATIO**x, at[1] * y) for x in np.linspace(-0.75, 0.75, 7) for y in (0.5, 1.0, 2.0)]
    f_hz, damping = max(finer, key=lambda each: gain(*each)[0])
    most = max(best, gain(f_hz, damping)[0])
    alike = ("backlash",) if _with_backlash(gatherer, noise, left, share) > LIKE_A_GAP * most else ()
    return [shaft_term(f_hz, damping, sizes, alike, tuple(noise))]


def _at_most(gatherer: Gatherer, left: Left) -> list[Noise]:
    """With all that the short windows leave taken for noise of the angle: rounding is not white, and a load that would
    not follow it is no load."""
    found = []
    at = 0
    for e, noise, flags in zip(gatherer.model.logs, gatherer.noise, gatherer.fits, strict=True):
        piece, sigma = left.pieces[at + FINE], left.sigma[at + FINE]
        own = e.plant["inertia_kgm2"] * acceleration_noise(e.fine.bump, noise)
        square = own**2 + sigma**2 - piece.floor**2  # less is left where the noise is less than was thought
        more = math.sqrt(max(square, 0.0)) / max(own, 1e-300)
        found.append(replace(noise, theta_rad=more * noise.theta_rad, speed_rad_s=more * noise.speed_rad_s))
        at += len(flags)
    return found


def _with_backlash(gatherer: Gatherer, noise: Sequence[Noise], left: Left, share: float) -> float:
    """Cost that the best backlash of a grid takes off. Bouncing between the flanks hangs on how it began, so that a log
    tells that there is a gap, and not its numbers. `share`: of the load in the inertia, for torque on it."""
    top_hz = FLANK / max(e.signals.period_s for e in gatherer.model.logs)
    best = 0.0
    for f_hz in (hz for hz in FLANKS_HZ if hz < top_hz):
        for gap_rad in GAPS_RAD:
            found, size = left.gain(*_with_gap(gatherer, noise, f_hz, gap_rad, share))
            best = max(best, found if 0.0 < float(size[0]) < MOST_RATIO else 0.0)
    return best


Columns = tuple[list[Array | None], list[tuple[float, float]]]


def _compliant(gatherer: Gatherer, noise: Sequence[Noise], f_hz: float, damping: float) -> Columns:
    def swing(s: Signals, inertia: float) -> tuple[Array, Array | None]:
        back_nm = 2.0 * two_mass.swing_of(s.load_nm, f_hz, damping, s.period_s) if s.has_load else None
        return two_mass.swing_of(s.theta_m_rad, f_hz, damping, s.period_s), back_nm

    return _columns(gatherer, noise, f_hz, damping, swing)


def _with_gap(gatherer: Gatherer, noise: Sequence[Noise], f_hz: float, gap_rad: float, share: float) -> Columns:
    def swing(s: Signals, inertia: float) -> tuple[Array, Array | None]:
        own = s.load_nm / (share * inertia) if s.has_load else None
        return backlash.swing_of(s.theta_m_rad, f_hz, FLANK_DAMPING, gap_rad, s.period_s, own), None

    return _columns(gatherer, noise, f_hz, FLANK_DAMPING, swing)


def _columns(
    gatherer: Gatherer,
    noise: Sequence[Noise],
    f_hz: float,
    damping: float,
    swing: Callable[[Signals, float], tuple[Array, Array | None]],
) -> Columns:
    """Per piece, the torque of the whole inertia as a load, where half of it is one; and what noise of the angle alone
    adds to its square and to its product with what is left."""
    columns: list[Array | None] = []
    noises = []
    for log, e in enumerate(gatherer.model.logs):
        inertia = e.plant["inertia_kgm2"]
        swing_rad, back_nm = swing(e.signals, inertia)
        for k, flags in enumerate(gatherer.fits[log]):
            if k > 1:
                columns.append(None)
                noises.append((0.0, 0.0))
                continue
            over = (e.shaft, e.fine)[k]
            torque = inertia * over.curve(swing_rad) + (0.0 if back_nm is None else over.value(back_nm))
            columns.append(torque[flags][:, None])
            square, product = swing_noise(over.bump, noise[log], f_hz, damping)
            noises.append((inertia**2 * square, -(inertia**2) * product))
    return columns, noises
