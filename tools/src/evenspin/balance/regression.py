"""Least squares with intervals for coloured residuals: neighbouring rows carry the same information twice.

The covariance is made of blocks of rows (cluster-robust): each block counts once, however many rows it has, so that
correlation within a block does no harm. Quantiles are Student's with blocks - 1 degrees of freedom. What changes slowly
over a log shows in long blocks only: half widths are the larger of those from short and from long blocks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

Array = NDArray[np.float64]

BLOCKS = 24
LONG_BLOCKS = 8
CONFIDENCE = 0.95


@dataclass(frozen=True, slots=True)
class Fit:
    """Coefficients and their covariance."""

    names: tuple[str, ...]
    value: Array
    covariance: Array
    blocks: int
    residual: Array
    long_covariance: Array

    def index(self, name: str) -> int:
        return self.names.index(name)

    def __getitem__(self, name: str) -> float:
        return float(self.value[self.index(name)])

    def sigma(self, name: str) -> float:
        i = self.index(name)
        return float(np.sqrt(self.covariance[i, i]))

    def half(self, name: str) -> float:
        """Half of the 95 % interval."""
        i = self.index(name)
        long = float(np.sqrt(self.long_covariance[i, i]))
        return max(_quantile(self.blocks) * self.sigma(name), _quantile(LONG_BLOCKS) * long)

    def p_value(self, names: Sequence[str]) -> float:
        """Chance of coefficients as large as these, if all of them were zero (Hotelling's T squared)."""
        rows = [self.index(name) for name in names]
        b, cov = self.value[rows], self.covariance[np.ix_(rows, rows)]
        if not np.all(np.isfinite(cov)) or np.linalg.matrix_rank(cov) < len(rows):
            return 1.0
        q, free = len(rows), self.blocks - 1
        t2 = float(b @ np.linalg.solve(cov, b))
        if free <= q:
            return 1.0
        return float(special.fdtrc(q, free - q + 1, max(t2, 0.0) * (free - q + 1) / (free * q)))


def fit(names: Sequence[str], columns: Sequence[Array], y: Array, blocks: int = BLOCKS) -> Fit:
    """Columns and y are the rows to use, in the order of time; they may have holes."""
    x = np.column_stack(columns) if columns else np.empty((len(y), 0))
    scale = np.sqrt(np.mean(x**2, axis=0)) + 1e-30  # a column of zeros stays one
    z = x / scale
    # The columns are scaled and close to orthogonal, or nearly collinear and then cut: the normal equations are good
    # enough.
    inverse = np.linalg.pinv(z.T @ z, rcond=1e-10, hermitian=True)
    value = inverse @ (z.T @ y)
    residual = y - z @ value
    short, long = (
        inverse @ _meat(z, residual, count) @ inverse / np.outer(scale, scale) for count in (blocks, LONG_BLOCKS)
    )
    return Fit(tuple(names), value / scale, short, blocks, residual, long)


def _meat(z: Array, residual: Array, blocks: int) -> Array:
    scores = np.array([z[part].T @ residual[part] for part in np.array_split(np.arange(len(residual)), blocks)])
    return scores.T @ scores * blocks / (blocks - 1)


def _quantile(blocks: int) -> float:
    return float(special.stdtrit(blocks - 1, 0.5 + 0.5 * CONFIDENCE))


def inflation(column: Array, others: Sequence[Array]) -> float:
    """Variance inflation: how much of this column the others already contain (1: nothing; large: not separable)."""
    if not others:
        return 1.0
    x = np.column_stack(others)
    found = np.linalg.pinv(x.T @ x, rcond=1e-10, hermitian=True) @ (x.T @ column)
    left = float(np.sum((column - x @ found) ** 2))
    return float(np.sum(column**2)) / max(left, 1e-300)


def rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x**2))) if len(x) else 0.0
