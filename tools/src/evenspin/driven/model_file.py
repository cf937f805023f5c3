"""model.toml: the model that was given, with the effects that were named."""

from __future__ import annotations

from typing import Any

from evenspin.driven.judge import Verdict
from evenspin.driven.read import Nominal
from evenspin.native import tables


def model_text(nominal: Nominal, verdict: Verdict) -> str:
    import tomlkit

    document = tomlkit.parse(nominal.machine.document.path.read_text(encoding="utf-8"))
    document["name"] = f"{nominal.machine.name}-gap"
    if not verdict.effects:
        return tomlkit.dumps(document)
    if "effects" not in document:
        document["effects"] = tomlkit.table()
    effects: Any = document["effects"]
    for effect, params in verdict.effects:
        had = nominal.machine.effects.get(effect, {})
        table = effects.get(effect, tomlkit.table())
        for key, value in params.items():
            table[key] = float(f"{_joined(effect, key, had, float(value)):.6g}")
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
