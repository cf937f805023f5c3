"""The table of effects with the modules that belong to it."""

from __future__ import annotations

import importlib
import importlib.util
from types import ModuleType

from evenspin.effects.hypothesis import Hypothesis, Scale, by_roles
from evenspin.native import tables


def module_of(effect: str) -> ModuleType | None:
    """The module of this package that is named like an effect of the table; None where there is none."""
    name = f"evenspin.effects.{effect}"
    return importlib.import_module(name) if importlib.util.find_spec(name) is not None else None


def hypotheses(scale: Scale) -> dict[str, Hypothesis]:
    """Every effect that may explain a log of this machine, by name, in the order of the table."""
    out: dict[str, Hypothesis] = {}
    for name, effect in tables().effects.items():
        if not effect.scenario_only:
            module = module_of(name)
            out[name] = by_roles(name, scale) if module is None else module.hypothesis(scale)
    return out


def known_orders(scale: Scale) -> tuple[float, ...]:
    """Mechanical orders at which an effect shows: those of the poles first, ascending, then those of the slots."""
    fixed: set[int] = set()
    of_slots: list[int] = []
    for name, effect in tables().effects.items():
        module = module_of(name)
        found = getattr(module, "orders", lambda scale: ())(scale)
        if any(p.role == "order" for p in effect.params.values()):
            of_slots += found
        else:
            fixed.update(found)
    return tuple(dict.fromkeys(float(k) for k in (*sorted(fixed), *of_slots)))
