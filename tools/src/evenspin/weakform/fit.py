"""Weighted least squares of all windows of all logs, and what each choice of named terms costs.

Weights come from the robust scatter of each equation with every term free. What is left is not white: the information
of each equation is divided by the factor by which its scores scatter more between stretches than within.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.weakform.model import Model, Point
from evenspin.weakform.noise import acceleration_noise, floors, noise_of, stated, swing_noise, torque_noise
from evenspin.weakform.terms import SHAFT, Kind, Term

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

HUBER = 2.0
ROUNDS = 4
INFLATED_LEAST = 1.0
PINS = 4  # rounds in which coordinates that would leave their range are put at its end
PINNED = 1e6
SLACK = 1e-3
OFF = 1e-6  # of its tolerance: a variant that does not act
LEAST_FLOOR = 0.7  # of the noise: a fit that leaves less has taken noise for a signal
MOST_NOISE = 0.95  # of the information of a column that noise may be said to be
ALWAYS = ("encoder_offset",)  # within its tolerance, but too large for one linear step
# Of the noise of the torque, what is in the column of each coordinate: a flux is a factor on all of it, the gain of one
# of two sensors divides half of it.
CURRENT_SHARES = {"torque_constant": 1.0, "current_gain": -0.5}
BENDING = ("encoder_offset", "encoder_eccentricity", "inductance_saturation")  # change the columns of the others


@dataclass(frozen=True, slots=True)
class Piece:
    """One equation of one log: rows that fit, with their stretch. `noise`: of a column, the variance that noise of the
    sensors gives it; the same noise is in what is left, and would pull the size by `pull`, their covariance."""

    r: Array
    x: Array
    stretch: NDArray[np.int64]
    noise: Array
    pull: Array
    floor: float  # what noise alone leaves
    kind: int  # which part of a residual it is

    def sums(self, w: Array) -> tuple[Array, Array]:
        """Normal equations with these weights, less what noise alone puts into them."""
        h, g = self.x.T @ (w[:, None] * self.x), self.x.T @ (w * self.r)
        whole = self.noise * float(np.sum(w))
        excess = np.minimum(whole, MOST_NOISE * np.diag(h))
        kept = np.divide(excess, whole, out=np.zeros_like(whole), where=whole > 0.0)
        return np.asarray(h - np.diag(excess)), np.asarray(g - kept * self.pull * float(np.sum(w)))


@dataclass(frozen=True, slots=True)
class Normal:
    """cost(dz) = constant + 2 g dz + dz H dz, about a point."""

    constant: float
    g: Array
    h: Array
    sigma: tuple[float, ...]  # of each piece, robust
    inflation: tuple[float, ...]
    grams: tuple[Array, ...]  # of each piece: what a step changes there is the root of dz G dz, rms
    kinds: tuple[int, ...]  # of each piece: which part of a residual it is
    columns: tuple[Array, ...]  # of each piece


class Gatherer:
    """Residuals and columns at a point. Columns that hardly change from point to point are kept."""

    def __init__(
        self, model: Model, fits: Sequence[Sequence[Flags]], stretches: Sequence[Sequence[NDArray[np.int64]]]
    ) -> None:
        self.model, self.fits, self.stretches = model, fits, stretches
        self.noise = [stated(noise_of(log.signals), log.plant) for log in model.logs]
        self._kept: list[dict[str, list[Array]]] = [{} for _ in model.logs]

    def pieces(self, point: Point, named: Collection[str]) -> list[Piece]:
        again = any(term.effect in BENDING and term.name in named for term in self.model.terms)
        found = []
        for log, kept in enumerate(self._kept):
            here = self.model.residual(point, log)
            floor = floors(self.model.logs[log], self.noise[log])
            for term in self.model.terms:
                if term.name not in kept or again or term.name in named:
                    kept[term.name] = self._calm(term, log, self.model.columns_of(term, point, log, here))
            for k, r in enumerate(here):
                columns = [kept[term.name][k] for term in self.model.terms]
                noises = [self._noise(term, log, k, point[term.name]) for term in self.model.terms]
                noise, pull = (np.concatenate([each[n] for each in noises]) for n in (0, 1))
                use = self.fits[log][k]
                x = np.column_stack(columns)
                found.append(Piece(r[use], x[use], self.stretches[log][k][use], noise, pull, floor[k], k))
        return found

    def _calm(self, term: Term, log: int, columns: list[Array]) -> list[Array]:
        """The acceleration of short windows is mostly noise of the angle: an inertia takes that of the long ones."""
        if term.effect == "inertia":
            equations = self.model.logs[log]
            fine, shaft = (w.centre[w.used].astype(np.float64) for w in (equations.fine, equations.shaft))
            columns[1] = np.interp(fine, shaft, columns[0][:, 0])[:, None]
        return columns

    def _noise(self, term: Term, log: int, part: int, z: Array) -> tuple[Array, Array]:
        """Of each column of a term, the variance by noise of the sensors, and its covariance with what is left."""
        equations, noise = self.model.logs[log], self.noise[log]
        variance, covariance = np.zeros(len(term)), np.zeros(len(term))
        if term.effect == "inertia" and part == 0:
            variance += (equations.plant["inertia_kgm2"] * acceleration_noise(equations.shaft.bump, noise)) ** 2
            covariance += variance
        if term.effect in CURRENT_SHARES and part < 2:  # noise of the current, as much larger with the torque of it
            share = CURRENT_SHARES[term.effect]
            square = torque_noise((equations.shaft, equations.fine)[part].bump, noise, equations.plant) ** 2
            variance += abs(share) * square
            covariance += share * square
        if term.effect == SHAFT and part < 2:
            bump = (equations.shaft, equations.fine)[part].bump
            square, product = swing_noise(bump, term.noise[log], float(np.exp(z[1])), float(np.exp(z[2])))
            scale = equations.plant["inertia_kgm2"] ** 2
            variance[0], covariance[0] = scale * square, scale * (z[0] * square - product)
        return variance, covariance


def normal_of(pieces: Sequence[Piece], prior: Array, toward: Array) -> Normal:
    """`prior`: inverse covariance with every term free; `toward`: where they pull, as a step from here."""
    weights = [np.ones(len(piece.r)) / max(_mad(piece.r), 1e-30) ** 2 for piece in pieces]
    step = np.zeros(len(prior))
    sigma = [1.0] * len(pieces)
    for _ in range(ROUNDS):
        h, g = np.zeros((len(prior), len(prior))), np.zeros(len(prior))
        for piece, w in zip(pieces, weights, strict=True):
            of_piece = piece.sums(w)
            h += of_piece[0]
            g += of_piece[1]
        step = solve(h, g, prior, toward)
        for k, piece in enumerate(pieces):
            left = piece.r + piece.x @ step
            sigma[k] = max(_mad(left), LEAST_FLOOR * piece.floor, 1e-30)
            weights[k] = np.minimum(1.0, HUBER / np.maximum(np.abs(left) / sigma[k], 1e-12)) / sigma[k] ** 2
    n = len(prior)
    h_all, g_all, constant, inflation = np.zeros((n, n)), np.zeros(n), 0.0, []
    for piece, w in zip(pieces, weights, strict=True):
        left = piece.r + piece.x @ step
        factor = _inflation(piece.x, w * left, piece.x.T @ (w[:, None] * piece.x), piece.stretch)
        inflation.append(factor)
        h, g = piece.sums(w)
        h_all += h / factor
        g_all += g / factor
        constant += float(np.sum(w * piece.r**2)) / factor
    grams = tuple(piece.x.T @ piece.x / max(len(piece.r), 1) for piece in pieces)
    kinds = tuple(piece.kind for piece in pieces)
    return Normal(
        constant, g_all, h_all, tuple(sigma), tuple(inflation), grams, kinds, tuple(piece.x for piece in pieces)
    )


def solve(h: Array, g: Array, prior: Array, toward: Array) -> Array:
    return _even_solve(h + prior, prior @ toward - g)


def _even_solve(a: Array, b: Array) -> Array:
    """a^-1 b, with a scaled to an even diagonal; a is overwritten."""
    scale = 1.0 / np.sqrt(np.maximum(a.diagonal(), 1e-300))
    a *= scale[:, None] * scale
    a.flat[:: len(b) + 1] += 1e-12
    return np.asarray(scale * np.linalg.solve(a, scale * b))


def cost_of(normal: Normal, prior: Array, toward: Array, low: Array) -> tuple[float, Array]:
    """`low`: the smallest step of each coordinate; one that would go below stays there."""
    drawn = prior @ toward
    a, lowest = normal.h + prior, low - SLACK * np.abs(low) - 1e-15
    diagonal = np.maximum(a.diagonal(), 1e-300)
    pinned: Flags | None = None
    step = _even_solve(a, drawn - normal.g)
    for _ in range(PINS):
        below = step < lowest
        if pinned is not None:
            below &= ~pinned
        if not below.any():
            break
        pinned = below if pinned is None else pinned | below
        at = np.flatnonzero(pinned)
        stiff = PINNED * diagonal[at]
        held, aim = prior.copy(), drawn.copy()
        held[at, at] += stiff
        aim[at] += stiff * low[at]
        step = _even_solve(normal.h + held, aim - normal.g)
    data = normal.constant + float(2.0 * normal.g @ step + step @ normal.h @ step)
    away = step - toward
    return data + float(away @ prior @ away), step


class Priors:
    """Inverse covariances of these terms, for any choice of those that are named. `reach`: of a free term, over its
    least size, where it is not to go as far as it could."""

    def __init__(self, terms: Sequence[Term], reach: float = 1.0) -> None:
        ends = np.cumsum([len(term) for term in terms])
        self._place = {term.name: slice(end - len(term), end) for term, end in zip(terms, ends, strict=True)}
        self._order = {term.name: number for number, term in enumerate(terms)}
        self._free = {term.name: 1.0 / (reach * term.free) ** 2 for term in terms}
        self._variants: dict[str, dict[str, Array]] = {}  # by effect: what each has while another one acts
        self._effect: dict[str, str] = {}  # of the terms that are variants
        held = []
        self._together = np.zeros((ends[-1], ends[-1]))
        for term in terms:
            off = term.variant and term.effect in self._variants  # the first one acts
            held.append(1.0 / (term.held * OFF if off else term.held) ** 2)
            if term.variant:
                self._variants.setdefault(term.effect, {})[term.name] = 1.0 / (term.held * OFF) ** 2
                self._effect[term.name] = term.effect
            if term.together is not None:
                here = self._place[term.name]
                self._together[here, here] += 1.0 / (len(term) * term.together) ** 2
        self._held = np.concatenate(held)

    def of(self, named: Collection[str]) -> Array:
        """Of the variants of an effect one acts: the named one, or the first."""
        diagonal = self._held.copy()
        for name in sorted((name for name in named if name in self._order), key=self._order.__getitem__):
            if name in self._effect:
                for other, off in self._variants[self._effect[name]].items():
                    diagonal[self._place[other]] = off
            diagonal[self._place[name]] = self._free[name]
        prior = self._together.copy()
        prior.flat[:: len(diagonal) + 1] += diagonal
        return prior


def prior_of(terms: Sequence[Term], named: Collection[str], reach: float = 1.0) -> Array:
    """One of the `Priors` of these terms."""
    return Priors(terms, reach).of(named)


def pull_of(terms: Sequence[Term], point: Point) -> Array:
    return np.concatenate([term.off - point[term.name] for term in terms])


def moved(terms: Sequence[Term], point: Point, step: Array, keep: Collection[str]) -> Point:
    """The point after a step. What is held is fitted again at every point, and stays off unless it bends the rest."""
    out, at = {}, 0
    for term in terms:
        z = point[term.name] + step[at : at + len(term)]
        if term.kind is not Kind.UNIT and term.name not in keep and term.effect not in ALWAYS:
            z = term.off.copy()
        out[term.name] = np.clip(z, term.low, term.high)
        at += len(term)
    return out


def settled(terms: Sequence[Term], point: Point, step: Array, named: Collection[str]) -> Point:
    """The point with all deviations of the unit, where causes that the table does not have are off unless chosen."""
    out = moved(terms, point, step, {term.name for term in terms})
    for term in terms:
        if term.kind is Kind.FOREIGN and term.name not in named:
            out[term.name] = term.off.copy()
    return out


def _mad(x: Array) -> float:
    return float(1.4826 * np.median(np.abs(x))) if len(x) else 0.0


def _inflation(x: Array, weighted: Array, h: Array, stretch: NDArray[np.int64]) -> float:
    """How much more the scores of whole stretches scatter than those of independent windows."""
    names, index = np.unique(stretch, return_inverse=True)
    if len(names) < 4:
        return 2.0
    scores = np.zeros((len(names), x.shape[1]))
    np.add.at(scores, index, x * weighted[:, None])
    known = np.diag(h) > 1e-12 * max(float(np.max(np.diag(h))), 1e-300)
    if not np.any(known):
        return INFLATED_LEAST
    ratio = np.sum(scores[:, known] ** 2, axis=0) / np.diag(h)[known]
    return max(INFLATED_LEAST, float(np.median(ratio)))
