"""What the table of effects says about the effects of a torque balance, so that it stands in one place."""

from __future__ import annotations

from collections.abc import Iterator

from evenspin.native import tables

TORQUE = "N m"
EMPIRICAL = ("empirical",)  # a sum of terms, not one cause
IN_AMPERES = (
    "torque_a_equiv",
    "amplitude_a_equiv",
)  # keys of a verdict whose value is a torque over the torque constant


def torque_effects() -> Iterator[str]:
    """Effects that act as torque or friction, with a torque among their parameters."""
    for name, effect in tables().effects.items():
        if name in EMPIRICAL:
            continue
        if effect.acts_on in ("torque", "friction") and any(p.unit == TORQUE for p in effect.params.values()):
            yield name


def table_parameter(effect: str, key: str) -> str | None:
    """The parameter of the table that a key of the verdict stands for; None where the effect has none."""
    params = tables().effects[effect].params
    if key in IN_AMPERES:
        return next((name for name, p in params.items() if p.unit == TORQUE and p.role == "amplitude"), None)
    return key if key in params else None


def smallest_torque_nm(effect: str) -> float:
    """The smallest value that the table allows: friction does not drive, and a load may."""
    name = table_parameter(effect, "torque_a_equiv")
    assert name is not None, effect
    return tables().effects[effect].params[name].minimum


def separation(effect: str, other: str) -> str:
    """What separates two effects that the table says are confused."""
    for holder, confused in ((effect, other), (other, effect)):
        facts = tables().effects[holder]
        if confused in facts.confused_with:
            return f"{holder}: {facts.told_apart}"
    raise ValueError(f"{effect} and {other}: the table of effects does not confuse them")
