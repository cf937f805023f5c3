"""What a drive can be asked for: parameters, signals, faults, commands. The hash shows whether two ends agree."""

from __future__ import annotations

import functools
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from evenspin.bench.frames import crc32c
from evenspin.errors import InputError, did_you_mean
from evenspin.native import Fault, Field, tables

KINDS = ("float", "integer", "flag", "choice")
AT_REST = 1  # flag of a parameter
NO_FAULT = "none"
FIRST_TRUTH = "t_s"  # in the list of the simulator this and all behind it is what no drive can measure


@dataclass(frozen=True)
class Schema:
    """The lists in the order of their numbers. Compared by their hash."""

    parameters: Mapping[str, Field]
    signals: Mapping[str, Field]
    faults: Sequence[Fault]
    commands: Sequence[str]

    @functools.cached_property
    def hash(self) -> int:
        octets = bytearray()
        for kind, records in enumerate(self._records()):
            for record in records:
                octets += bytes((kind,)) + record
        return crc32c(bytes(octets))

    def _records(self) -> tuple[list[bytes], ...]:
        return (
            [_parameter(field) for field in self.parameters.values()],
            [text(field.name) + text(field.unit) for field in self.signals.values()],
            [text(fault.name) for fault in self.faults],
            [text(name) for name in self.commands],
        )

    @functools.cached_property
    def parameter_index(self) -> Mapping[str, int]:
        return {name: index for index, name in enumerate(self.parameters)}

    @functools.cached_property
    def signal_index(self) -> Mapping[str, int]:
        return {name: index for index, name in enumerate(self.signals)}

    def parameter(self, name: str) -> Field:
        if name not in self.parameters:
            hint = did_you_mean(name, self.parameters)
            raise InputError("bench", "parameter", name, "a parameter of this drive", hint)
        return self.parameters[name]

    def signal_numbers(self, names: Sequence[str]) -> list[int]:
        for name in names:
            if name not in self.signals:
                hint = did_you_mean(name, self.signals)
                raise InputError("bench", "signal", name, "a signal of this drive", hint)
        return [self.signal_index[name] for name in names]

    def fault(self, number: int) -> Fault:
        return self.faults[number] if number < len(self.faults) else Fault(f"fault {number}", "", "")


@functools.cache
def own_schema() -> Schema:
    """The lists that this package was built with."""
    known = tables()
    signals = {}
    for name, field in known.signals.items():
        if name == FIRST_TRUTH:
            break
        signals[name] = field
    return Schema(known.params, MappingProxyType(signals), known.faults, known.commands)


def text(content: str) -> bytes:
    """`str` of the protocol."""
    octets = content.encode("ascii", "replace")[:255]
    return bytes((len(octets),)) + octets


def _parameter(field: Field) -> bytes:
    flags = AT_REST if field.at_rest else 0
    numbers = struct.pack("<BBfff", KINDS.index(field.kind), flags, field.minimum, field.maximum, field.default)
    return numbers + text(field.name) + text(field.unit) + text("|".join(field.choices))
