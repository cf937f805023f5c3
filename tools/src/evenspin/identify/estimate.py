"""A number and how sure it is, and least squares that say so."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CONFIDENCE = 0.95


@dataclass(frozen=True, slots=True)
class Estimate:
    """`half` is half of the 95 % confidence interval."""

    value: float
    half: float

    @property
    def relative(self) -> float:
        return self.half / abs(self.value) if self.value != 0.0 else float("inf")

    def as_json(self) -> dict[str, float]:
        return {"value": self.value, "low": self.value - self.half, "high": self.value + self.half}


def linear(columns: Array, values: Array, effective: float = 1.0) -> tuple[list[Estimate], Array]:
    """Least squares; `effective`: independent samples per row. Returns the estimates and the residual."""
    solution, _, rank, _ = np.linalg.lstsq(columns, values, rcond=None)
    residual = values - columns @ solution
    freedom = max(len(values) * effective - columns.shape[1], 1.0)
    if rank < columns.shape[1]:
        return [Estimate(float(value), float("inf")) for value in solution], residual
    # One row carries `effective` of an independent one: the variance of the parameters grows by its inverse.
    covariance: Array = np.linalg.inv(columns.T @ columns) * float(residual @ residual) / len(values) / effective
    return _with_intervals(np.asarray(solution, dtype=np.float64), covariance, freedom), residual


def nonlinear(
    model: Callable[[Array], Array], start: Sequence[float], low: Sequence[float], high: Sequence[float], values: Array
) -> tuple[list[Estimate], Array]:
    """Least squares with bounds; intervals from the linearised problem at the solution."""
    from scipy.optimize import least_squares

    found = least_squares(
        lambda p: model(p) - values, start, bounds=(low, high), x_scale=np.maximum(np.abs(start), 1e-6), xtol=1e-12
    )
    freedom = len(values) - len(start)
    information = found.jac.T @ found.jac
    if freedom < 1 or np.linalg.cond(information) > 1e18:
        return [Estimate(float(value), float("inf")) for value in found.x], -found.fun
    covariance: Array = np.linalg.inv(information) * 2.0 * found.cost / freedom
    return _with_intervals(found.x, covariance, freedom), -found.fun


def _with_intervals(solution: Array, covariance: Array, freedom: float) -> list[Estimate]:
    from scipy.special import stdtrit

    factor = float(stdtrit(freedom, 0.5 + CONFIDENCE / 2.0))
    half = factor * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return [Estimate(float(value), float(h)) for value, h in zip(solution, half, strict=True)]
