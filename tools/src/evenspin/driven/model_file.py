"""model.toml: the model that was given, with the effects that were named."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from evenspin.driven.judge import Verdict
from evenspin.driven.read import Nominal
from evenspin.empirical.effect import effects_of
from evenspin.empirical.term import EmpiricalTerm
from evenspin.native import tables
from evenspin.weakform.analysis import Explained
from evenspin.weakform.fit import prior_of
from evenspin.weakform.model import LD, LQ
from evenspin.weakform.terms import NUMBER_OF

Z95 = 1.96
MODEL_SHARE = 0.02  # of a number, that the equations themselves may be off by


def estimates(found: Explained, nominal: Nominal) -> dict[str, dict[str, float]]:
    """Numbers that the model leaves open, with 95 % intervals."""
    terms = found.model.terms
    covariance = np.linalg.inv(found.normal.h + prior_of(terms, found.named))
    values: dict[str, dict[str, float]] = {}
    at = 0
    for term in terms:
        name = NUMBER_OF.get(term.effect, {LD: "ld_h", LQ: "lq_h"}.get(term.name, ""))
        if name in nominal.estimated:
            z = float(found.point[term.name][0])
            value = nominal.plant[name] * (1.0 + z)
            spread = nominal.plant[name] * math.sqrt(float(covariance[at, at]))
            half = math.hypot(Z95 * spread, MODEL_SHARE * value)
            values[name] = {"value": value, "low": value - half, "high": value + half}
        at += len(term)
    return values


def model_text(
    nominal: Nominal,
    verdict: Verdict,
    estimated: Mapping[str, Mapping[str, float]],
    terms: Sequence[EmpiricalTerm] = (),
) -> str:
    import tomlkit

    document = tomlkit.parse(nominal.machine.document.path.read_text(encoding="utf-8"))
    document["name"] = f"{nominal.machine.name}-gap"
    for name, number in estimated.items():
        document["plant"][name] = float(f"{number['value']:.6g}")
        document["plant"][name].comment(f"estimated, {number['low']:.4g} .. {number['high']:.4g}")
    if "dc_link_v" not in nominal.machine.plant_from:
        document["plant"]["dc_link_v"] = float(f"{nominal.plant['dc_link_v']:.4g}")
    beyond, _ = effects_of(terms)
    acting = [*verdict.effects, *verdict.at_start]
    if not acting and not beyond:
        return tomlkit.dumps(document)
    if "effects" not in document:
        document["effects"] = tomlkit.table()
    effects: Any = document["effects"]
    for effect, params in acting:
        had = nominal.machine.effects.get(effect, {})
        table = effects.get(effect, tomlkit.table())
        for key, value in params.items():
            table[key] = float(f"{_joined(effect, key, had, float(value)):.6g}")
        effects[effect] = table
    for effect, params in beyond.items():
        table = effects.get(effect, tomlkit.table())
        for key, value in params.items():
            table[key] = value + (float(table.get(key, 0.0)) if effect == "coulomb_friction" else 0.0)
        effects[effect] = table
    return tomlkit.dumps(document)


def _joined(effect: str, key: str, had: Any, value: float) -> float:
    """A factor multiplies that of the model, a single torque adds to it; anything else takes its place."""
    if key not in had:
        return value
    role = tables().effects[effect].params[key].role
    if role == "factor":
        return float(had[key]) * value
    single = sum(field.role == "amplitude" for field in tables().effects[effect].params.values()) == 1
    phased = any(field.role == "phase" for field in tables().effects[effect].params.values())
    return float(had[key]) + value if role == "amplitude" and single and not phased else value
