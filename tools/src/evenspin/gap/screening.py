"""Screening: which effects are worth a refinement, as a linear fit of their signatures sees it. Cheap."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import Hypothesis
from evenspin.gap.candidate import Candidate, Model
from evenspin.gap.evidence import model_features
from evenspin.gap.fitting import Fitter
from evenspin.gap.thresholds_effects import LIKENESS, LINEAR_SHARE
from evenspin.log.tolerance import SIGMA

Array = NDArray[np.float64]
AMOUNT_MIN, AMOUNT_MAX = 0.05, 20.0  # by which the amplitude of a start that is not linear is scaled


@dataclass(frozen=True, slots=True)
class Signature:
    """How an effect shows in the features, from one of its starts."""

    name: str
    start: Array
    columns: Array  # features x coordinates; one column, of the start as a whole, where the effect is not linear


def signatures(fitter: Fitter, model: Model, among: frozenset[str] | None = None) -> list[Signature]:
    """Of every effect and start that the model does not have and that can act beside it: there is one shaft.

    `among`: only of these effects.
    """
    jobs: list[tuple[str, Array, list[Array]]] = []
    has_shaft = any(fitter.library[name].is_shaft for name in model.z)
    for name, h in fitter.library.items():
        if name in model.z or (has_shaft and h.is_shaft) or (among is not None and name not in among):
            continue
        for start in h.starts:
            z0 = np.array(start, dtype=np.float64)
            jobs.append((name, z0, probe_points(h, z0)))
    units = [fitter.effects({**model.z, name: z}) for name, _, points in jobs for z in points]
    runs = iter(model_features(fitter.forward, units, 1))
    out = []
    for name, z0, points in jobs:
        h = fitter.library[name]
        columns = [next(runs)[0] for _ in points]
        if h.linear:
            at = dict(zip(_asked(h, z0), columns, strict=True))
            columns = [
                (at[i] - (model.probe if c.beside is None else at[c.beside])) / c.probe
                if i in at
                else np.zeros(len(model.probe))
                for i, c in enumerate(h.coordinates)
            ]
        else:
            columns = [columns[0] - model.probe]
        out.append(Signature(name, z0, np.stack(columns, axis=1)))
    return out


def candidates(
    fitter: Fitter, model: Model, known: Sequence[Signature], size: int = 1, keep: int = 6
) -> list[Candidate]:
    """Sets of `size` more effects, best first. `known`: signatures around the model or, cheaper, the bare machine."""
    fresh = [s for s in known if s.name not in model.z]
    gram, right = _normal_equations(fitter, model, fresh)
    n = len(SIGMA)
    edges = np.cumsum([n, *(s.columns.shape[1] for s in fresh)])
    base = _explained(gram, right, np.arange(n))[0]
    tried = _gains_of_starts(fitter, model, fresh) if size == 1 else {}
    best: dict[frozenset[str], Candidate] = {}
    for combination in itertools.combinations(range(len(fresh)), size):
        names = frozenset(fresh[i].name for i in combination)
        if len(names) < size or sum(fitter.library[name].is_shaft for name in {*names, *model.z}) > 1:
            continue
        columns = np.concatenate([np.arange(n), *(np.arange(edges[i], edges[i + 1]) for i in combination)])
        explained, x = _explained(gram, right, columns)
        z = dict(model.z)
        at, allowed = n, True
        for i in combination:
            width = fresh[i].columns.shape[1]
            point = _point(fitter.library[fresh[i].name], fresh[i].start, x[at : at + width])
            at += width
            if point is None:
                allowed = False
                break
            z[fresh[i].name] = point
        gain = explained - base
        if combination[0] in tried:
            gain = max(tried[combination[0]], LIKENESS * gain)
        if allowed and gain > (best[names].gain if names in best else 0.0):
            best[names] = Candidate(z, gain, names)
    return sorted(best.values(), key=lambda candidate: -candidate.gain)[:keep]


def _normal_equations(fitter: Fitter, model: Model, fresh: Sequence[Signature]) -> tuple[Array, Array]:
    y = (fitter.forward.measured - model.features) * fitter.judge.weight
    weight = 1.0 / np.sqrt(1.0 + (LINEAR_SHARE * y) ** 2)
    blocks = [fitter.nuisance, *(s.columns for s in fresh)]
    a = np.hstack(blocks) * (fitter.judge.weight * weight)[:, None]
    gram, right = a.T @ a, a.T @ (y * weight)
    n = len(SIGMA)
    gram[:n, :n] += np.diag(1.0 / SIGMA**2)
    return gram, right


def _gains_of_starts(fitter: Fitter, model: Model, fresh: Sequence[Signature]) -> dict[int, float]:
    """What each start of an effect that is not linear takes off the cost as it stands: no line leads there."""
    y = fitter.forward.measured
    before = fitter.judge.fit(y - model.probe, fitter.nuisance).cost
    return {
        i: before - fitter.judge.fit(y - model.probe - s.columns[:, 0], fitter.nuisance).cost
        for i, s in enumerate(fresh)
        if not fitter.library[s.name].linear and fitter.library[s.name].amplitude is None
    }


def _point(h: Hypothesis, z0: Array, amount: Array) -> Array | None:
    """Where a linear fit puts the effect; None where that is the wrong side of off."""
    if not h.linear:
        z = z0.copy()
        if h.amplitude is not None:
            z[h.amplitude] *= min(max(float(amount[0]), AMOUNT_MIN), AMOUNT_MAX)
        return h.clip(z) if amount[0] > 0.0 else None
    z = h.clip(z0 + amount)
    low = np.array([-np.inf if c.form else c.low for c in h.coordinates])
    return None if np.any((low == z0) & (amount <= 0.0)) else z


def probe_points(h: Hypothesis, z0: Array) -> list[Array]:
    """Where an effect is simulated for its signature: one point a coordinate that is asked, or the start itself."""
    if not h.linear:
        return [z0]
    points = []
    for i in _asked(h, z0):
        c = h.coordinates[i]
        z = z0.copy()
        z[i] += c.probe
        if c.beside is not None:
            z[c.beside] += h.coordinates[c.beside].probe
        points.append(z)
    return points


def _asked(h: Hypothesis, z0: Array) -> list[int]:
    return [i for i in range(len(z0)) if h.is_asked(i, z0)]


def _explained(gram: Array, right: Array, columns: NDArray[np.int_]) -> tuple[float, Array]:
    g = gram[np.ix_(columns, columns)].copy()
    g[np.diag_indices_from(g)] *= 1.0 + 1e-9
    g[np.diag_indices_from(g)] += 1e-12
    x = np.asarray(np.linalg.solve(g, right[columns]), dtype=np.float64)
    return float(right[columns] @ x), x
