"""One control block of the library: parameters and actions by name, as its file in sim_host/capi/blocks lists them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from evenspin.errors import BlockError, did_you_mean
from evenspin.native.library import Library, load
from evenspin.native.refusal import Refusal, read_refusal
from evenspin.native.tables import Action, BlockParam, tables

Given = float | str


class Block:
    """A block by its name; what is not given has its default. `tables().blocks` lists them all.

    >>> pi = Block("pi", kp=0.4, ki_ts=0.01, out_min=-10.0, out_max=10.0)
    >>> (output,) = pi.do("output", 1.5)
    """

    def __init__(self, name: str, /, *, numeric: str = "float", **params: Given) -> None:
        self._library = library = load(numeric)
        error = library.ffi.new("es_error_t *")
        handle = library.lib.es_block_new(name.encode(), error)
        if handle == library.ffi.NULL:
            raise block_error(read_refusal(library, error))
        self._handle = library.ffi.gc(handle, library.lib.es_block_free)
        self._kind = kind = tables().blocks[name]
        for param, value in params.items():
            number = _number(kind.params.get(param), param, value)
            if not library.lib.es_block_set(self._handle, param.encode(), number, error):
                raise block_error(read_refusal(library, error))
        if not library.lib.es_block_start(self._handle, error):
            raise block_error(read_refusal(library, error))
        self._actions = {
            action.name: (index, _buffer(library, action.inputs), _buffer(library, action.outputs))
            for index, action in enumerate(kind.actions.values())
        }

    def do(self, action: str, *inputs: float) -> tuple[float, ...]:
        """Do this with the block; inputs and outputs are those that the list of the block names, in its order."""
        if action not in self._actions:
            raise BlockError("action", action, f"must be one of the block; {did_you_mean(action, self._actions)}")
        index, given, found = self._actions[action]
        if len(inputs) != len(given):
            names = ", ".join(self.actions[action].inputs)
            raise BlockError(action, len(inputs), f"must have {len(given)} inputs: {names}")
        given[0 : len(inputs)] = inputs
        self._library.lib.es_block_do(self._handle, index, given, found)
        return tuple(found)

    @property
    def actions(self) -> Mapping[str, Action]:
        return self._kind.actions

    @property
    def table(self) -> list[float]:
        """The table of the block: its taps, or what it has learned; empty without one."""
        length = self._library.lib.es_block_table(self._handle, self._library.ffi.NULL, 0)
        out = self._library.ffi.new("double[]", length)
        self._library.lib.es_block_table(self._handle, out, length)
        return list(out)


def _buffer(library: Library, names: tuple[str, ...]) -> Any:
    return library.ffi.new("double[]", len(names))


def _number(field: BlockParam | None, name: str, value: Given) -> float:
    """The value as the library takes it; a name that is not known is for the library to refuse."""
    words = field.choices if field is not None else ()
    if words and value not in words:
        hint = did_you_mean(str(value), words)
        raise BlockError(name, value, f"must be {' or '.join(words)}; {hint}")
    if words:
        return float(words.index(str(value)))
    if isinstance(value, str) or not isinstance(value, int | float):
        raise BlockError(name, value, "must be a number")
    if field is not None and field.kind == "integer" and isinstance(value, bool):
        raise BlockError(name, value, "must be a whole number")
    return float(value)


def block_error(refusal: Refusal) -> BlockError:
    if refusal.list == "block":
        return BlockError("block", refusal.name, refusal.reason)
    whole = refusal.code == "NOT_WHOLE" and refusal.given.is_integer()
    return BlockError(refusal.name, int(refusal.given) if whole else refusal.given, refusal.reason)
