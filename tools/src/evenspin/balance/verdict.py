"""The verdict as it is put together: names with parameters, what they may be instead, what excludes others."""

from __future__ import annotations

from dataclasses import dataclass, field

from evenspin.balance.effect_facts import separation, table_parameter
from evenspin.native import tables

Numbers = dict[str, float]

OR = " or "  # between the names of effects that the log does not separate
MOST = 0.97  # confidence: a torque balance does not see every effect of the table
FACTOR = "factor"


@dataclass(slots=True)
class Verdict:
    """Names, strongest first. A name is an effect of the table, or several that this log does not separate."""

    names: list[str] = field(default_factory=list)
    parameters: dict[str, Numbers] = field(default_factory=dict)
    confidence: Numbers = field(default_factory=dict)
    alternatives: list[tuple[str, float, str]] = field(default_factory=list)
    against: list[tuple[str, str]] = field(default_factory=list)  # (effect, why not)
    unexplained: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    takes_a: Numbers = field(default_factory=dict)
    cannot_separate: dict[str, list[str]] = field(default_factory=dict)

    def name(self, effect: str, parameters: Numbers, confidence: float, takes_a: float) -> None:
        for each in effect.split(OR):
            assert each in tables().effects, each
        self.parameters[effect] = parameters
        self.confidence[effect] = round(min(max(confidence, 0.0), MOST), 3)
        self.takes_a[effect] = takes_a
        self.names = sorted(self.takes_a, key=lambda name: -self.takes_a[name])
        self.apart(effect)

    def alternative(self, effect: str, other: str, weight: float, reason: str) -> None:
        """`other` may be the cause instead of `effect`; the table of effects says what separates them."""
        self.alternatives.append((other, weight, f"{reason}; {separation(effect, other)}"))

    def apart(self, group: str) -> None:
        """No name of a group is separable from the others."""
        names = group.split(OR)
        for each in names:
            others = [other for other in names if other != each]
            if others:
                known = self.cannot_separate.setdefault(each, [])
                known += [other for other in others if other not in known]


def out_of_range(effect: str, parameters: Numbers) -> str | None:
    """Why these values are none that the table of effects allows."""
    if OR in effect:
        return None
    for key in ("torque_a_equiv", FACTOR):
        name = table_parameter(effect, key)
        if key not in parameters or name is None:
            continue
        value, field_ = parameters[key], tables().effects[effect].params[name]
        if not field_.minimum <= value <= field_.maximum:
            return f"{key} = {value:.4g} is impossible: {field_.allowed()}"
    return None
