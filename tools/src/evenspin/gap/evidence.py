"""What the log says against a model: residuals in units of their noise, and what a healthy unit may add to them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.forward import Forward
from evenspin.gap.thresholds_evidence import OUTLIER_SIGMAS, SIMULATOR_RANGE_SHARE, SIMULATOR_SHARE
from evenspin.log.tolerance import SIGMA, prior_of, unit_of

Array = NDArray[np.float64]
Effects = dict[str, dict[str, float]]
REPEATS = 16  # simulated units behind the noise level
POOL = 4.0  # weight, in repeats, of a feature group's common level in the level of one feature
PASSES = 6  # of reweighting
PROBES = ((11, 0.25), (12, 0.75))  # noise seed and start angle in a count of the simulations behind a model


@dataclass(frozen=True, slots=True)
class Noise:
    sigma: Array  # per feature
    used: NDArray[np.bool_]
    group: NDArray[np.int64]  # feature group: record, signal, kind
    group_names: tuple[tuple[str, str, str], ...]


def noise_level(forward: Forward, nuisance: Array, effects: Effects | None = None, seed: int = 5) -> Noise:
    """Spread of the features over healthy units, noise and start angles within a count, pooled over like features.

    What a unit's deviations add in proportion is left out (`nuisance`, see nuisance_columns): the fit finds that. What
    stays is noise and what does not follow in proportion, such as an encoder's rounding that locks in at some speeds.
    """
    random = np.random.default_rng(seed)
    deltas = random.normal(0.0, SIGMA, (REPEATS, len(SIGMA))).clip(-2.0 * SIGMA, 2.0 * SIGMA)
    units = [unit_of(effects or {}, delta, 1000 + i, (i + 0.5) / REPEATS) for i, delta in enumerate(deltas)]
    runs = np.array(forward.many(units)) - deltas @ nuisance.T
    variance = runs.var(axis=0, ddof=1)
    members: dict[tuple[str, str, str], list[int]] = defaultdict(list)
    for i, key in enumerate(forward.keys):
        members[key.group].append(i)
    names = tuple(members)
    group = np.empty(len(forward.keys), dtype=np.int64)
    sigma = np.empty(len(forward.keys))
    spread = _simulator_spread(forward, runs.mean(axis=0))
    for index, name in enumerate(names):
        rows = members[name]
        group[rows] = index
        common = float(np.mean(variance[rows]) + np.median(variance[rows])) / 2.0
        sigma[rows] = np.sqrt(((REPEATS - 1.0) * variance[rows] + POOL * common) / (REPEATS - 1.0 + POOL))
    used = (sigma > 0.0) & forward.compared
    return Noise(np.sqrt(sigma**2 + spread**2), used, group, names)


def _simulator_spread(forward: Forward, mean: Array) -> Array:
    """A share of how much a signal changes among neighbouring bins: there small differences show large."""
    spread = np.zeros(len(mean))
    runs: dict[tuple[str, str, int], list[int]] = defaultdict(list)
    for i, key in enumerate(forward.keys):
        if key.bin is not None:
            runs[(key.record, key.signal, key.block)].append(i)
    for rows in runs.values():
        x = mean[rows]
        change = np.abs(np.gradient(x)) if len(x) > 1 else np.zeros(len(x))
        spread[rows] = SIMULATOR_SHARE * (change + SIMULATOR_RANGE_SHARE * float(np.ptp(x)))
    return spread


@dataclass(frozen=True, slots=True)
class Fit:
    """A model held against the log with the unit's own deviations taken as far as their priors let them."""

    residual: Array  # whitened, nuisance taken out
    delta: Array  # nuisance estimate
    amount: Array  # of the extra columns
    covariance: Array  # of amount
    cost: float  # robust chi-square with priors


class Judge:
    """Robust generalised least squares of a residual on nuisance columns and extra columns."""

    def __init__(self, noise: Noise) -> None:
        self.noise = noise
        self.weight = noise.used / np.where(noise.used, noise.sigma, 1.0) / np.sqrt(1.0 + 1.0 / len(PROBES))

    def fit(
        self,
        residual: Array,
        nuisance: Array,
        extra: Array | None = None,
        damping: float = 0.0,
        known: Iterable[str] = (),
    ) -> Fit:
        """`residual`: measured less model; columns: what one unit of each adds to it; `known`: effects of the model."""
        r = residual * self.weight
        columns = nuisance if extra is None else np.hstack((nuisance, extra))
        a = columns * self.weight[:, None]
        prior = np.zeros(a.shape[1])
        prior[: len(SIGMA)] = prior_of(known)
        x = np.zeros(a.shape[1])
        for _ in range(PASSES):
            w = 1.0 / (1.0 + ((r - a @ x) / OUTLIER_SIGMAS) ** 2)
            normal = (a * w[:, None]).T @ a + np.diag(prior)
            diagonal = np.diag(normal).copy()
            diagonal[: len(SIGMA)] *= 1e-10
            diagonal[len(SIGMA) :] *= 1e-10 + damping
            normal[np.diag_indices_from(normal)] += diagonal + 1e-300
            x = np.linalg.solve(normal, (a * w[:, None]).T @ r)
        left = r - a @ x
        n = len(SIGMA)
        return Fit(left, x[:n], x[n:], np.linalg.pinv(normal)[n:, n:], robust_cost(left) + float(np.sum(prior * x**2)))


def robust_cost(whitened: Array) -> float:
    return float(np.sum(OUTLIER_SIGMAS**2 * np.log1p((whitened / OUTLIER_SIGMAS) ** 2)))


def model_features(forward: Forward, units: Sequence[Effects], probes: int = len(PROBES)) -> list[Array]:
    """Features of each unit for each probe: units x (probes x features)."""
    todo = [unit_of(effects, None, seed, part) for effects in units for seed, part in PROBES[:probes]]
    runs = forward.many(todo)
    return [np.array(runs[i * probes : (i + 1) * probes]) for i in range(len(units))]


def nuisance_columns(forward: Forward, effects: Effects) -> Array:
    """Change of the features per unit of each tolerance, by central differences over two sigmas."""
    seed, part = PROBES[0]
    steps = [side * 2.0 * sigma for sigma in SIGMA for side in (1.0, -1.0)]
    deltas = np.zeros((len(steps), len(SIGMA)))
    deltas[np.arange(len(steps)), np.arange(len(steps)) // 2] = steps
    runs = forward.many([unit_of(effects, delta, seed, part) for delta in deltas])
    return np.stack([(runs[2 * i] - runs[2 * i + 1]) / (4.0 * SIGMA[i]) for i in range(len(SIGMA))], axis=1)
