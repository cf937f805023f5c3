"""The firmware on a recording: sim_host/replay, one library for each numeric."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import NativeError
from evenspin.native.library import NUMERICS, REINSTALL, declarations, library_folder
from evenspin.recording.file import WITH_MAKER, Head, Part, RecordingError

HEADER = "evenspin_replay.h"
SUPPORTED_ABI = 1
STREAMS = 6  # of a trace, see sim_host/trace/trace.h
PHASES = ("a", "b", "c")
PREFIX = "ER_"

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Difference:
    """The first thing that the firmware does otherwise than it did when it was recorded.

    `kind`: SIGNALS, DUTY, SENT, ORDER or BROKEN. `values`: (signal, recorded, replayed) of all that differ in period
    `row_period`, the first period from `period` on whose signals are stored and differ; a duty stands there with
    `period` itself.
    """

    kind: str
    period: int
    t_s: float
    text: str
    row_period: int | None
    values: tuple[tuple[str, float, float], ...]

    def as_json(self) -> dict[str, Any]:
        return {
            "kind": self.kind.lower(),
            "period": self.period,
            "t_s": self.t_s,
            "text": self.text,
            "row_period": self.row_period,
            "values": [
                {"signal": name, "recorded": _plain(then), "replayed": _plain(now)} for name, then, now in self.values
            ],
        }


class Player:
    """Feed it parts, run them. It stops by itself behind the first difference."""

    def __init__(self, path: Path, head: Head, *, other_firmware: bool = False) -> None:
        if head.numeric not in NUMERICS:
            raise RecordingError(path, "numeric", head.numeric, " or ".join(NUMERICS), WITH_MAKER)
        self._ffi, self._lib = _load(head.numeric)
        _check(path, head, self._lib, self._ffi, other_firmware)
        handle = self._lib.er_new()
        if handle == self._ffi.NULL:
            raise NativeError("no memory for a replay; close other programs")
        self._handle = self._ffi.gc(handle, self._lib.er_free)
        self._kept: list[Any] = []  # what the library reads from has to stay
        self._fed: tuple[bytes, ...] = ()
        self._pwm_hz = head.pwm_hz
        self.path = path
        self.signals = signal_names(head.numeric)

    def feed(self, part: Part) -> None:
        if len(part.streams) != STREAMS:
            raise RecordingError(
                self.path, "recording", f"{len(part.streams)} streams", f"{STREAMS}", "record it again"
            )
        buffers = [self._ffi.from_buffer("uint8_t[]", octets) for octets in part.streams]
        pointers = self._ffi.new("uint8_t *[]", buffers)
        counts = self._ffi.new("int64_t[]", [len(octets) for octets in part.streams])
        self._kept, self._fed = buffers, part.streams
        self._lib.er_feed(self._handle, pointers, counts)

    def run(self, periods: int) -> Array:
        """Up to so many periods, a row of all signals for each; fewer at the end of what was fed, at a difference, and
        behind one in which the drive trips."""
        out = np.empty((periods, len(self.signals)))
        done = self._lib.er_run(self._handle, periods, self._ffi.from_buffer("double[]", out, require_writable=True))
        return out[:done]

    def skip(self, periods: int) -> int:
        """Up to so many periods, faults or not."""
        done = step = 0
        while done < periods and (step := int(self._lib.er_run(self._handle, periods - done, self._ffi.NULL))):
            done += step
        return done

    def taken(self) -> tuple[bytes, ...]:
        """Of the part that was fed last: the octets up to the period that was run last."""
        positions = [int(self._lib.er_position(self._handle, k)) for k in range(STREAMS)]
        return tuple(bytes(octets[:at]) for octets, at in zip(self._fed, positions, strict=True))

    @property
    def periods(self) -> int:
        return int(self._lib.er_periods(self._handle))

    @property
    def ended(self) -> bool:
        return bool(self._lib.er_ended(self._handle))

    def difference(self) -> Difference | None:
        found = self._ffi.new("er_difference_t *")
        if not self._lib.er_first(self._handle, found):
            return None
        kind = self._ffi.string(self._ffi.cast("er_kind_t", found.kind)).removeprefix(PREFIX)
        period = int(found.period)
        row_period, values = self._row()
        if kind == "DUTY":
            values = ((f"duty_{PHASES[found.index]}", found.recorded, found.replayed), *values)
        text = _TEXT[kind](self._name(found.recorded_event), self._name(found.replayed_event))
        return Difference(kind, period, period / self._pwm_hz, text, row_period, values)

    def _row(self) -> tuple[int | None, tuple[tuple[str, float, float], ...]]:
        recorded, replayed = np.empty(len(self.signals)), np.empty(len(self.signals))
        buffers = [self._ffi.from_buffer("double[]", each, require_writable=True) for each in (recorded, replayed)]
        period = self._lib.er_row(self._handle, *buffers)
        if period < 0:
            return None, ()
        differ = [i for i in range(len(recorded)) if recorded[i : i + 1].tobytes() != replayed[i : i + 1].tobytes()]
        return int(period), tuple((self.signals[i], float(recorded[i]), float(replayed[i])) for i in differ)

    def _name(self, text: Any) -> str:
        return self._ffi.string(text).decode()


_TEXT = {
    "SIGNALS": lambda then, now: "signals differ at the end of the period",
    "DUTY": lambda then, now: "the duties differ",
    "SENT": lambda then, now: f"what the firmware hands to {then} differs",
    "ORDER": lambda then, now: f"the firmware {_did(now)}, and {_did(then)} when it was recorded",
    "BROKEN": lambda then, now: "what is recorded makes no sense here",
}


def _did(event: str) -> str:
    if not event:
        return "ends its call"
    return f"calls {event}" if event.startswith("hal_") else "ends its call"


def _plain(value: float) -> float | str:
    return value if np.isfinite(value) else str(value)


def signal_names(numeric: str) -> tuple[str, ...]:
    ffi, lib = _load(numeric)
    return tuple(ffi.string(lib.er_signal_name(k)).decode() for k in range(lib.er_signal_count()))


def firmware_id(numeric: str) -> str:
    """Of the firmware that replays here; it changes with every source of the firmware."""
    ffi, lib = _load(numeric)
    return str(ffi.string(lib.er_firmware_id()).decode())


def _check(path: Path, head: Head, lib: Any, ffi: Any, other_firmware: bool) -> None:
    if head.trace != lib.er_trace_version():
        raise RecordingError(
            path,
            "trace",
            f"version {head.trace}",
            f"version {lib.er_trace_version()}",
            WITH_MAKER,
        )
    if head.schema != lib.er_schema_hash() or head.signals != signal_names(head.numeric):
        raise RecordingError(
            path, "schema", f"{head.schema:08x} of another firmware",
            f"{lib.er_schema_hash():08x}, with the same parameters and signals", f"{WITH_MAKER}: {head.made_by}",
        )  # fmt: skip
    here = ffi.string(lib.er_firmware_id()).decode()
    if head.firmware != here and not other_firmware:
        raise RecordingError(
            path, "firmware", head.firmware, f"{here}, the one that is here",
            f"made by {head.made_by}; --other-firmware says where the first difference is",
        )  # fmt: skip


@functools.cache
def _load(numeric: str) -> tuple[Any, Any]:
    from cffi import FFI

    folder = library_folder(HEADER)
    names = [
        f"libevenspin_replay_{numeric}.so",
        f"libevenspin_replay_{numeric}.dylib",
        f"evenspin_replay_{numeric}.dll",
    ]
    found = [folder / name for name in names if (folder / name).is_file()]
    if not found:
        raise NativeError(f"{folder}/{names[0]} is not installed; {REINSTALL}")
    ffi = FFI()
    try:
        ffi.cdef(declarations((folder / HEADER).read_text()))
        lib = ffi.dlopen(str(found[0]))
    except OSError as error:
        raise NativeError(f"{found[0]}: cannot be loaded ({error}); {REINSTALL}") from None
    if lib.er_abi_version() != SUPPORTED_ABI:
        raise NativeError(f"{found[0]}: another interface than {SUPPORTED_ABI}; {REINSTALL}")
    return ffi, lib
