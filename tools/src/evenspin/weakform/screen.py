"""What is left after a choice of terms, and how much of it a further term would explain, all others fitted again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.weakform.fit import HUBER, LEAST_FLOOR, MOST_NOISE, Piece, solve

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

ROUNDS = 5
HELD = 1e9  # times the stiffest coordinate: does not move


@dataclass(frozen=True, slots=True)
class Left:
    """Per equation and log. `r`: all windows in use, with `step` done; `w`: weights, none where nothing fits."""

    pieces: Sequence[Piece]
    fits: Sequence[Flags]
    step: Array
    r: Sequence[Array]
    w: Sequence[Array]
    sigma: Sequence[float]
    h: Array  # with what holds the terms
    g: Array  # slope of the cost in each coordinate

    def gain(self, columns: Sequence[Array | None], noises: Sequence[tuple[float, float]] = ()) -> tuple[float, Array]:
        """Cost that a term takes off with all others fitted again, and its coefficients. `noises`: of a term with one
        column, what noise alone adds to its square and to its product with what is left, per window of each piece."""
        count = next((c.shape[1] for c in columns if c is not None), 0)
        a, b, m = np.zeros((count, count)), np.zeros(count), np.zeros((len(self.step), count))
        for piece, r, w, column in zip(self.pieces, self.r, self.w, columns, strict=True):
            if column is None:
                continue
            weighted = w[:, None] * column
            a += column.T @ weighted
            b += weighted.T @ r
            m += piece.x.T @ weighted
        if count == 0 or float(np.max(np.diag(a))) <= 0.0:
            return 0.0, np.zeros(count)
        own = np.diag(a).copy()
        solved = even_solve(self.h, m)
        b = b - solved.T @ self.g
        a = a - m.T @ solved + 1e-9 * np.diag(own) + 1e-300 * np.eye(count)
        if noises:  # of which no other term takes anything up
            whole, product = (sum(n[k] * float(np.sum(w)) for w, n in zip(self.w, noises, strict=True)) for k in (0, 1))
            kept = min(1.0, MOST_NOISE * float(a[0, 0]) / max(whole, 1e-300))
            a, b = a - kept * whole, b - kept * product
        z = -np.linalg.solve(a, b)
        return float(-z @ b), z

    def without(self, own: slice, size: Array) -> Left:
        """What is left when a term of this size is taken out and all others are held where they are."""
        changed = [piece.x[:, own] @ size for piece in self.pieces]
        r = [r - c for r, c in zip(self.r, changed, strict=True)]
        g = self.g - np.sum([p.x.T @ (w * c) for p, w, c in zip(self.pieces, self.w, changed, strict=True)], axis=0)
        h = self.h.copy()
        h[own, :], h[:, own], g[own] = 0.0, 0.0, 0.0
        at = np.arange(own.start, own.stop)
        h[at, at] = HELD * float(np.max(np.diag(self.h)))
        return replace(self, r=r, h=h, g=np.asarray(g))


def even_solve(h: Array, m: Array) -> Array:
    """h^-1 m; held and free coordinates differ by many powers of ten, so that they are scaled first."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(h), 1e-300))
    return np.asarray(scale[:, None] * np.linalg.solve(h * np.outer(scale, scale), scale[:, None] * m))


def left_of(
    pieces: Sequence[Piece], fits: Sequence[Flags], inflation: Sequence[float], prior: Array, toward: Array
) -> Left:
    """Robust fit over the windows that fit."""
    r0 = [piece.r for piece in pieces]
    sigma = [max(_mad(r[f]), 1e-30) for r, f in zip(r0, fits, strict=True)]
    weights = [f / s**2 / q for f, s, q in zip(fits, sigma, inflation, strict=True)]
    step = np.zeros(len(prior))
    for _ in range(ROUNDS):
        h, g = np.zeros_like(prior), np.zeros(len(prior))
        for piece, w in zip(pieces, weights, strict=True):
            weighted = w[:, None] * piece.x  # with the noise of its columns: a gain is a difference of the same sums
            h += piece.x.T @ weighted
            g += weighted.T @ piece.r
        step = solve(h, g, prior, toward)
        for k, piece in enumerate(pieces):
            left = piece.r + piece.x @ step
            sigma[k] = max(_mad(left[fits[k]]), LEAST_FLOOR * piece.floor, 1e-30)
            huber = np.minimum(1.0, HUBER / np.maximum(np.abs(left) / sigma[k], 1e-12))
            weights[k] = fits[k] * huber / sigma[k] ** 2 / inflation[k]
    r = [p.r + p.x @ step for p in pieces]
    h, g = prior.copy(), prior @ (step - toward)  # with the weights as they are now
    for piece, own, w in zip(pieces, r, weights, strict=True):
        h += piece.x.T @ (w[:, None] * piece.x)
        g += piece.x.T @ (w * own)
    return Left(pieces, fits, step, r, weights, sigma, h, g)


def _mad(x: Array) -> float:
    return float(1.4826 * np.median(np.abs(x))) if len(x) else 0.0
