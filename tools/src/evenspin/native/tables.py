"""The one list of everything, read from the library: parameters, signals, model, inputs, effects, faults."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from evenspin.native.library import Library, load


@dataclass(frozen=True, slots=True)
class Field:
    """One named number. For kind "choice" the value is the position of the word in `choices`."""

    name: str
    unit: str
    kind: str
    doc: str
    choices: tuple[str, ...]
    minimum: float
    maximum: float
    default: float
    at_rest: bool = False  # of a drive's parameter: only changes while the bridge is off

    def allowed(self) -> str:
        """What the value has to be, in words."""
        if self.kind == "choice":
            return " or ".join(f'"{word}"' for word in self.choices)
        if self.kind == "flag":
            return "true or false"
        what = "a whole number" if self.kind == "integer" else "a number"
        unit = f" {self.unit}" if self.unit else ""
        return f"{what} in {self.minimum:g} .. {self.maximum:g}{unit}"

    def to_text(self, value: float) -> str:
        """The value as a person writes it."""
        if self.kind == "choice":
            return self.choices[int(value)]
        if self.kind == "flag":
            return "true" if value else "false"
        return f"{value:g}"

    def to_number(self, value: bool | float | str) -> float:
        """The value as the library takes it."""
        return float(self.choices.index(value)) if isinstance(value, str) else float(value)


@dataclass(frozen=True, slots=True)
class EffectParam(Field):
    """A parameter of an effect, with what whoever searches or reports it has to know (sim_host/plant/effect.h)."""

    role: str = "amplitude"  # or "phase", "factor", "order", "sign", "share", "quantity", "detail"
    example: float = 0.0  # shows clearly in a drive of some hundred watts
    vector: bool = False  # together with the others that are: only the length of all says how large one is
    optional: bool = False  # may be nothing although the effect acts

    @property
    def reported(self) -> bool:
        """Details of a model are fitted along, and no verdict names them."""
        return self.role != "detail"


@dataclass(frozen=True, slots=True)
class Effect:
    """A non-ideal effect of the plant."""

    name: str
    acts_on: str
    doc: str
    signature: str
    told_apart: str  # what separates it from similar effects
    confused_with: tuple[str, ...]
    shown_by: Mapping[str, str]  # experiments of the log format that make it identifiable, and the condition ("": any)
    scenario_only: bool  # never the explanation of a log
    params: Mapping[str, EffectParam]


@dataclass(frozen=True, slots=True)
class Fault:
    """A reason for which the drive switches off."""

    name: str
    cause: str
    check: str


@dataclass(frozen=True, slots=True)
class Combination:
    """Two drive parameters of which some values are refused together."""

    name: str
    param: str
    other: str
    why: str


@dataclass(frozen=True, slots=True)
class Action:
    """What can be done with a block: numbers in, numbers out, named with their units."""

    name: str
    doc: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BlockParam(Field):
    """A parameter of a control block."""

    above: bool = False  # the minimum itself is not allowed
    below: bool = False
    rule: str = ""  # what else it must be


@dataclass(frozen=True, slots=True)
class Block:
    """A control block (sim_host/capi/blocks), see evenspin.blocks."""

    name: str
    doc: str
    params: Mapping[str, BlockParam]
    actions: Mapping[str, Action]


@dataclass(frozen=True, slots=True)
class Tables:
    """Every table of the library, in its order, by name."""

    params: Mapping[str, Field]
    signals: Mapping[str, Field]
    model: Mapping[str, Field]
    inputs: Mapping[str, Field]
    effects: Mapping[str, Effect]
    faults: tuple[Fault, ...]
    combinations: tuple[Combination, ...]
    commands: tuple[str, ...]  # of the bench link
    blocks: Mapping[str, Block]


@functools.cache
def tables() -> Tables:
    """The tables; they are the same for both numerics."""
    library = load()
    lib = library.lib
    return Tables(
        params=_fields(library, lib.es_param_count(), lib.es_param_info),
        signals=_fields(library, lib.es_signal_count(), lib.es_signal_info),
        model=_fields(library, lib.es_model_count(), lib.es_model_info),
        inputs=_fields(library, lib.es_input_count(), lib.es_input_info),
        effects=MappingProxyType({effect.name: effect for effect in _effects(library)}),
        faults=tuple(_faults(library)),
        combinations=tuple(_combinations(library)),
        commands=tuple(_fields(library, lib.es_command_count(), lib.es_command_info)),
        blocks=MappingProxyType({block.name: block for block in _blocks(library)}),
    )


def _fields(library: Library, count: int, info: Callable[[int, Any], bool]) -> Mapping[str, Field]:
    raw = library.ffi.new("es_field_t *")
    found = {}
    for index in range(count):
        if info(index, raw):
            field = _field(library, raw)
            found[field.name] = field
    return MappingProxyType(found)


def _field(library: Library, raw: Any) -> Field:
    return Field(
        name=library.text(raw.name),
        unit=library.text(raw.unit),
        kind=library.text(raw.kind),
        doc=library.text(raw.doc),
        choices=_words(library.text(raw.choices)),
        minimum=raw.min,
        maximum=raw.max,
        default=raw.value,
        at_rest=bool(raw.at_rest),
    )


def _effects(library: Library) -> Iterator[Effect]:
    raw = library.ffi.new("es_effect_t *")
    for index in range(library.lib.es_effect_count()):
        if library.lib.es_effect_info(index, raw):
            effect_params = functools.partial(library.lib.es_effect_param_info, index)
            found = _fields(library, raw.param_count, effect_params)
            yield Effect(
                name=library.text(raw.name),
                acts_on=library.text(raw.acts_on),
                doc=library.text(raw.doc),
                signature=library.text(raw.signature),
                told_apart=library.text(raw.told_apart),
                confused_with=tuple(_neighbours(library, index)),
                shown_by=MappingProxyType(dict(_shown_by(library, index))),
                scenario_only=bool(raw.scenario_only),
                params=MappingProxyType(
                    {field.name: _effect_param(library, field, index, k) for k, field in enumerate(found.values())}
                ),
            )


def _effect_param(library: Library, field: Field, effect: int, param: int) -> EffectParam:
    raw = library.ffi.new("es_role_t *")
    library.lib.es_effect_param_role(effect, param, raw)
    own: dict[str, Any] = {"role": library.text(raw.role), "example": raw.example}
    own |= {"vector": bool(raw.vector), "optional": bool(raw.optional)}
    return EffectParam(**{each.name: getattr(field, each.name) for each in fields(Field)}, **own)


def _combinations(library: Library) -> Iterator[Combination]:
    raw = library.ffi.new("es_combination_t *")
    for index in range(library.lib.es_combination_count()):
        if library.lib.es_combination_info(index, raw):
            yield Combination(*(library.text(part) for part in (raw.name, raw.param, raw.other, raw.why)))


def _neighbours(library: Library, effect: int) -> Iterator[str]:
    index = 0
    while (name := library.lib.es_effect_neighbour(effect, index)) != library.ffi.NULL:
        yield library.text(name)
        index += 1


def _shown_by(library: Library, effect: int) -> Iterator[tuple[str, str]]:
    experiment, condition = library.ffi.new("const char **"), library.ffi.new("const char **")
    index = 0
    while library.lib.es_effect_shown_by(effect, index, experiment, condition):
        yield library.text(experiment[0]), library.text(condition[0])
        index += 1


def _blocks(library: Library) -> Iterator[Block]:
    raw = library.ffi.new("es_block_info_t *")
    for index in range(library.lib.es_block_count()):
        if library.lib.es_block_info(index, raw):
            yield Block(
                name=library.text(raw.name),
                doc=library.text(raw.doc),
                params=MappingProxyType({each.name: each for each in _block_params(library, index, raw.param_count)}),
                actions=MappingProxyType({each.name: each for each in _actions(library, index, raw.action_count)}),
            )


def _block_params(library: Library, block: int, count: int) -> Iterator[BlockParam]:
    raw = library.ffi.new("es_field_t *")
    for index in range(count):
        if library.lib.es_block_param_info(block, index, raw):
            field = _field(library, raw)
            own: dict[str, Any] = {"above": bool(raw.above), "below": bool(raw.below), "rule": library.text(raw.rule)}
            yield BlockParam(**{each.name: getattr(field, each.name) for each in fields(Field)}, **own)


def _actions(library: Library, block: int, count: int) -> Iterator[Action]:
    raw = library.ffi.new("es_action_t *")
    for index in range(count):
        if library.lib.es_block_action_info(block, index, raw):
            inputs, outputs = (library.text(each) for each in (raw.inputs, raw.outputs))
            yield Action(library.text(raw.name), library.text(raw.doc), _words(inputs), _words(outputs))


def _words(text: str) -> tuple[str, ...]:
    return tuple(text.split("|")) if text else ()


def _faults(library: Library) -> Iterator[Fault]:
    raw = library.ffi.new("es_fault_t *")
    for index in range(library.lib.es_fault_count()):
        if library.lib.es_fault_info(index, raw):
            yield Fault(library.text(raw.name), library.text(raw.cause), library.text(raw.check))
