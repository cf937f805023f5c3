"""Why a drive did not take parameters: the one that was asked for, the one that stands against it, and what to do.

The drive names one parameter of the rule that was broken. Which other one belongs to it is found by asking the same
firmware, compiled for this computer: the rules stand nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from evenspin.bench.messages import DriveState
from evenspin.bench.numbers import Flag, State
from evenspin.errors import NativeError
from evenspin.native import Field
from evenspin.native.simulation import Simulation

Values = Mapping[str, float]
SHOWN = 3
MOVING = (State.ALIGN, State.RUN)


def why_not(
    fields: Mapping[str, Field], in_force: Values, asked: Values, culprit: str, *, state: DriveState, numeric: str
) -> str:
    """One line for a set that was refused because of `culprit`."""
    judge = _Judge(numeric, in_force)
    changed = {name: value for name, value in asked.items() if in_force.get(name) != value} or dict(asked)
    if judge.fits(changed):
        return _not_now(fields, changed, culprit, state, numeric)
    return _does_not_fit(fields, in_force, changed, culprit, judge)


class _Judge:
    """The firmware's own opinion on whole sets of parameters."""

    def __init__(self, numeric: str, in_force: Values) -> None:
        self._sim = Simulation(numeric)
        self._in_force = in_force
        for name, value in in_force.items():
            self._sim.set_param(name, value)

    def fits(self, changed: Values) -> bool:
        try:
            for name, value in changed.items():
                self._sim.set_param(name, value)
            self._sim.start()
        except NativeError:
            return False
        finally:
            for name in changed:
                self._sim.set_param(name, self._in_force[name])
        return True


def _not_now(fields: Mapping[str, Field], changed: Values, culprit: str, now: DriveState, numeric: str) -> str:
    about = _said(fields, culprit, changed[culprit]) if culprit in changed else culprit
    if now.state in MOVING:
        return f"{about}: cannot change while the motor is driven (state {now.state.name.lower()}); stop first"
    if now.flags & Flag.ARMED:
        return f"{about}: cannot change while the drive is armed; disarm it first"
    if numeric == "fixed":
        return f"{about}: cannot change while fixed-point firmware runs; build the firmware with it as the default"
    return f"{about}: this board does not allow it; choose a value nearer to the one in force"


def _does_not_fit(fields: Mapping[str, Field], in_force: Values, changed: Values, culprit: str, judge: _Judge) -> str:
    if culprit not in changed:
        ours = [name for name in changed if judge.fits({n: v for n, v in changed.items() if n != name})] or list(
            changed
        )
        return _against(fields, {name: changed[name] for name in ours[:SHOWN]}, culprit, in_force[culprit])
    wanted = {culprit: changed[culprit]}
    for name in changed:
        if name != culprit and judge.fits({n: v for n, v in changed.items() if n != name}):
            stands = _said(fields, name, changed[name])
            return f"{_said(fields, culprit, changed[culprit])}: does not fit {stands}; choose others"
    for name in _others(fields, changed, culprit):
        if any(judge.fits({**changed, name: value}) for value in _ends(fields[name], in_force[name])):
            return _against(fields, wanted, name, in_force[name])
    return f"{_said(fields, culprit, changed[culprit])}: fits with no value of another parameter; choose another value"


def _against(fields: Mapping[str, Field], asked: Values, other: str, value: float) -> str:
    wanted = ", ".join(_said(fields, name, number) for name, number in asked.items())
    stands = _said(fields, other, value)
    return f"{wanted}: does not fit {stands}; choose another value, or change {other} first"


def _others(fields: Mapping[str, Field], changed: Values, culprit: str) -> Sequence[str]:
    """Numbers of the same unit first: limits are mostly compared with their like. Choices switch whole rules off."""
    unit = fields[culprit].unit
    others = [name for name in fields if name not in changed]
    return sorted(others, key=lambda name: (fields[name].kind in ("choice", "flag"), fields[name].unit != unit))


def _ends(field: Field, now: float) -> Iterator[float]:
    return (value for value in dict.fromkeys((field.maximum, field.minimum, field.default)) if value != now)


def _said(fields: Mapping[str, Field], name: str, value: float) -> str:
    field = fields[name]
    words = field.to_text(value)
    return f"{name} = {words}{f' {field.unit}' if field.unit else ''}"
