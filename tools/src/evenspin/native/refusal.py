"""Why the library refused something: values from C (es_error_t), and the one place where they become a sentence."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from evenspin.errors import NativeError, did_you_mean
from evenspin.native.library import Library
from evenspin.native.tables import tables

PREFIX = "ES_"  # of the codes in the header
MODES = ("current", "speed", "position", "torque")  # control_mode, the one input that a parameter may not go with
LISTS = {
    "model": "model field",
    "param": "drive parameter",
    "effect": "effect",
    "effect_param": "parameter of this effect",
    "input": "input",
    "signal": "signal",
    "block": "block",
    "block_param": "parameter of this block",
}


@dataclass(frozen=True, slots=True)
class Refusal:
    """What was refused and what is allowed. `list`: what `name` is of, a key of LISTS; `other`: a second name."""

    code: str  # of the header, without ES_
    list: str
    name: str
    other: str
    given: float
    minimum: float
    maximum: float
    above: bool  # the minimum itself is not allowed
    below: bool
    unit: str
    rule: str

    @property
    def must(self) -> str:
        """What the value has to be, as it stands behind "must be"; "" where no value would do."""
        found = _MUST.get(self.code)
        return found(self) if found is not None else ""

    @property
    def reason(self) -> str:
        """The sentence behind the colon."""
        return f"must be {self.must}" if self.must else _WHY[self.code](self)

    def __str__(self) -> str:
        if self.code == "TWO_SHAFTS":
            return self.reason
        if self.code == "UNKNOWN":  # whatever was to be done with it
            return f"{self.name}: {self.reason}"
        if self.code == "COMBINATION":
            return f"{self.name} = {_word(self.name, self.given)}: {self.reason}"
        return f"{self.name} = {self.given:g}: {self.reason}" if self.name else self.reason


class RefusedValueError(NativeError):
    """The library refused a value. `refusal` says which, and what is allowed."""

    def __init__(self, refusal: Refusal) -> None:
        super().__init__(str(refusal))
        self.refusal = refusal


def read_refusal(library: Library, error: Any) -> Refusal:
    """From a pointer to es_error_t."""
    return Refusal(
        code=library.ffi.string(library.ffi.cast("es_code_t", error.code)).removeprefix(PREFIX),
        list=library.text(error.list),
        name=library.text(error.name),
        other=library.text(error.other),
        given=error.given,
        minimum=error.min,
        maximum=error.max,
        above=error.above,
        below=error.below,
        unit=library.text(error.unit),
        rule=library.text(error.rule),
    )


def _range(refusal: Refusal) -> str:
    low, high = f"{refusal.minimum:g}", f"{refusal.maximum:g}"
    from_low = f"{'above' if refusal.above else 'at least'} {low}"
    to_high = f"{'below' if refusal.below else 'at most'} {high}"
    if refusal.minimum == refusal.maximum:
        text = low
    elif refusal.maximum == math.inf:
        text = "finite" if refusal.minimum == -math.inf else from_low
    elif refusal.minimum == -math.inf:
        text = to_high
    elif refusal.above or refusal.below:
        text = f"{from_low} and {to_high}"
    else:
        text = f"within {low} .. {high}"
    return f"{text} {refusal.unit}".rstrip()


def _limited(refusal: Refusal) -> str:
    return f"within {refusal.other}, +-{refusal.maximum:g} {refusal.unit}"


def _unknown(refusal: Refusal) -> str:
    hint = did_you_mean(refusal.name, _known(refusal))
    return f"no such {LISTS[refusal.list]}; {hint}"


def _known(refusal: Refusal) -> Iterable[str]:
    known = tables()
    if refusal.list == "effect_param":
        return known.effects[refusal.other].params
    if refusal.list == "block_param":
        return known.blocks[refusal.other].params
    by_list: dict[str, Iterable[str]] = {
        "model": known.model,
        "param": known.params,
        "effect": known.effects,
        "input": known.inputs,
        "signal": known.signals,
        "block": known.blocks,
    }
    return by_list[refusal.list]


def _others(refusal: Refusal) -> str:
    span = f"{refusal.minimum:g} .. {refusal.maximum:g} {refusal.unit}".rstrip()
    return f"the other parameters leave {span}; see docs/parameters.md"


def _word(name: str, value: float) -> str:
    return tables().params[name].to_text(value) if name in tables().params else MODES[int(value)]


def _combination(refusal: Refusal) -> str:
    return f"does not go with {refusal.other} = {_word(refusal.other, refusal.minimum)}: {refusal.rule}"


def _no_fit(refusal: Refusal) -> str:
    return (
        "does not fit the plant"
        if refusal.list == "model"
        else "does not fit the other parameters; see docs/parameters.md"
    )


def _numeric(refusal: Refusal) -> str:
    return f"such that the numeric can hold it{f' over {refusal.other}' if refusal.other else ''}"


_MUST: dict[str, Callable[[Refusal], str]] = {
    "OUT_OF_RANGE": _range,
    "NOT_WHOLE": lambda refusal: f"a whole number {_range(refusal)}",
    "LIMITED": _limited,
    "BREAKS_RULE": lambda refusal: refusal.rule or f"another value; {refusal.other} refuses it",
    "BELOW_OTHER": lambda refusal: f"at least {refusal.other}",
    "NUMERIC": _numeric,
}
_WHY: dict[str, Callable[[Refusal], str]] = {
    "NONE": lambda _: "nothing was refused",
    "NO_OBJECT": lambda _: "nothing to act on",
    "NO_MEMORY": lambda _: "not enough memory; close other programs",
    "UNKNOWN": _unknown,
    "TIMES": lambda _: "needs at least one point, and times that are finite and rise",
    "BOARD": lambda refusal: f"the board allows at most {refusal.maximum:g} {refusal.unit}".rstrip(),
    "OTHERS": _others,
    "COMBINATION": _combination,
    "NO_FIT": _no_fit,
    "RUNNING": lambda _: "cannot change while the drive runs; stop it first",
    "STARTED": lambda _: "cannot change after the start; do it before",
    "WAITING": lambda _: "an earlier change still waits; let it run on and try again",
    "TWO_SHAFTS": lambda refusal: (
        f"effects.{refusal.name} and effects.{refusal.other} are both on, and there is one shaft: leave one of them out"
    ),
    "NO_ANGLE_TABLE": lambda _: (
        "needs method = aro, aro_cells values within +-observer_limit_a, and a drive that does not run"
    ),
}
CODES = frozenset(_MUST) | frozenset(_WHY)
