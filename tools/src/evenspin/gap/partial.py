"""What can be named although something is left that no known effect explains.

A right effect beside something foreign has the same size in every part of the log where it shows; a wrong one that
only resembles the foreign cause needs another size in each part. A name stands when its size agrees over the log, and
when records that no fit has seen are simulated better with it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.candidate import Model
from evenspin.gap.evidence import model_features
from evenspin.gap.features import FeatureKey
from evenspin.gap.fitting import Fitter
from evenspin.gap.thresholds_effects import PARTIAL_GAIN, PARTIAL_SHARE, PARTIAL_SPREAD
from evenspin.gap.thresholds_evidence import OUTLIER_SIGMAS
from evenspin.log.tolerance import prior_of

BINS_OF_PART = 8
PASSES = 4  # of reweighting
SIZE_PRIOR, NO_PRIOR = 1.0, 1e-9  # inverse variances of a relative size
MEDIAN_CHI_SQUARE = 0.455  # of one degree of freedom
KNOWN_SHARE = 0.3  # of the size: parts that know it less well say nothing
MODEL_SHARE = 0.1  # of the size, in the weight of a part: no single part decides
WITHIN = (
    0.683  # of the weight of all parts: a robust standard deviation, which a few parts with something else do not move
)
PARTS_LEAST = 3

Array = NDArray[np.float64]
GapOf = Callable[[tuple[str, ...]], float]  # on the validation records, of a machine with these effects of the model


def partial(model: Model, weights: Mapping[str, float], spread: Mapping[str, float], gap_of: GapOf) -> tuple[str, ...]:
    """The effects that stand, strongest first.

    `weights`: what each effect takes off the cost; `spread`: see size_spread; `gap_of`: on the validation records.
    """
    names = [n for n in model.z if spread[n] < PARTIAL_SPREAD and weights.get(n, 0.0) > PARTIAL_GAIN]
    names.sort(key=lambda name: -weights[name])
    while names:
        shares = validated_shares(tuple(names), gap_of)
        weakest = min(names, key=lambda name: shares[name])
        if shares[weakest] > PARTIAL_SHARE:
            break
        names.remove(weakest)
    return tuple(names)


def validated_shares(names: tuple[str, ...], gap_of: GapOf) -> dict[str, float]:
    """Of each effect, the share of the nominal machine's squared gap that is closed with it and open without it."""
    whole, after = gap_of(()) ** 2, gap_of(names) ** 2
    if not math.isfinite(whole) or whole <= 0.0:  # there is no validation record
        return dict.fromkeys(names, math.nan)
    return {name: (gap_of(tuple(n for n in names if n != name)) ** 2 - after) / whole for name in names}


def size_spread(fitter: Fitter, model: Model, name: str) -> float:
    """How far, beyond noise, the size of an effect differs over the parts of the log, as a share of it; inf: not known.

    Each part (a steady stretch, or some bins of a transient, of one record) is fitted by itself: the size of this
    effect, free; that of the other effects and the unit's deviations, held by their priors.
    """
    contributions = []
    for each in model.z:
        without = {other: z for other, z in model.z.items() if other != each}
        (probes,) = model_features(fitter.forward, [fitter.effects(without)])
        contributions.append(model.features - probes.mean(axis=0))
    weight = fitter.judge.weight
    columns = np.column_stack([fitter.nuisance, *contributions]) * weight[:, None]
    prior = np.concatenate([prior_of(model.z), np.full(len(contributions), SIZE_PRIOR)])
    free = fitter.nuisance.shape[1] + list(model.z).index(name)
    prior[free] = NO_PRIOR
    residual = (fitter.forward.measured - model.features) * weight
    used = np.flatnonzero(weight > 0.0)
    sizes = [size_in_part(columns[rows], residual[rows], prior, free) for rows in _parts(fitter.forward.keys, used)]
    return spread_of_sizes(sizes)


def _parts(keys: Sequence[FeatureKey], used: NDArray[np.int64]) -> list[list[int]]:
    parts: dict[tuple[str, str, int, int], list[int]] = defaultdict(list)
    for i in used:
        key = keys[i]
        piece = ("steady", -1) if key.bin is None else (key.kind, key.bin // BINS_OF_PART)
        parts[key.record, piece[0], key.block, piece[1]].append(int(i))
    return list(parts.values())


def size_in_part(columns: Array, residual: Array, prior: Array, free: int) -> tuple[float, float]:
    """What the size of an effect is off by in one part, as a share of it, and the standard deviation of that share.

    `columns` and `residual` in standard deviations of the noise, `prior` as inverse variances. What the part leaves
    beyond noise counts as noise.
    """
    amount: Array = np.zeros(columns.shape[1])
    normal: Array = np.diag(prior)
    for _ in range(PASSES):
        left = residual - columns @ amount
        scale = max(1.0, math.sqrt(float(np.median(left**2)) / MEDIAN_CHI_SQUARE))
        weighted = columns / (scale**2 + (left / OUTLIER_SIGMAS) ** 2)[:, None]
        normal = weighted.T @ columns + np.diag(prior)
        amount = np.asarray(np.linalg.solve(normal, weighted.T @ residual), dtype=np.float64)
    return float(amount[free]), math.sqrt(float(np.linalg.inv(normal)[free, free]))


def spread_of_sizes(sizes: Sequence[tuple[float, float]]) -> float:
    """Of the parts that know the size well enough to differ: two thirds of them agree within this."""
    known = np.array([(share, sigma) for share, sigma in sizes if sigma < KNOWN_SHARE])
    if len(known) < PARTS_LEAST:
        return math.inf
    share, sigma = known.T
    weight = 1.0 / (sigma**2 + MODEL_SHARE**2)
    beyond = np.sqrt(np.maximum(0.0, share**2 - sigma**2))
    order = np.argsort(beyond)
    reached = np.cumsum(weight[order]) / np.sum(weight)
    return float(beyond[order][np.searchsorted(reached, WITHIN)])
