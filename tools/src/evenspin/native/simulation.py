"""The simulated drive as an object. Each method is one call of the library."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import NativeError
from evenspin.native.library import load
from evenspin.native.refusal import Refusal, RefusedValueError, read_refusal

Values = Sequence[float] | NDArray[np.floating[Any]]

LINK_OCTETS = 1 << 14  # more than the link of the virtual board holds


class Simulation:
    """Firmware on plant. Configure, `start`, then `run` as often as wanted."""

    def __init__(self, numeric: str = "float") -> None:
        self._library = load(numeric)
        lib, ffi = self._library.lib, self._library.ffi
        handle = lib.es_sim_new()
        if handle == ffi.NULL:
            raise NativeError("no memory for a simulation; close other programs")
        self._handle = ffi.gc(handle, lib.es_sim_free)
        self._signal_count = 0
        self._started = False
        self._octets = ffi.new("uint8_t[]", LINK_OCTETS)

    def set_model(self, name: str, value: float) -> None:
        self._need(self._library.lib.es_sim_set_model(self._handle, name.encode(), value))

    def set_param(self, name: str, value: float) -> None:
        self._need(self._library.lib.es_sim_set_param(self._handle, name.encode(), value))

    def set_effect(self, effect: str, param: str, value: float) -> None:
        self._need(self._library.lib.es_sim_set_effect(self._handle, effect.encode(), param.encode(), value))

    def set_seed(self, seed: int) -> None:
        self._need(self._library.lib.es_sim_set_seed(self._handle, seed))

    def set_noise(self, seed: int, pairs: NDArray[np.float64]) -> None:
        """The seed, with its noise drawn ahead by `noise_of` for several simulations; the run is the same."""
        self._noise = self._library.ffi.from_buffer("double[]", pairs)  # has to stay as long as the simulation
        self._need(self._library.lib.es_sim_set_noise(self._handle, seed, self._noise, len(pairs)))

    def set_input(self, name: str, t_s: Values, value: Values, *, linear: bool = False) -> None:
        """Value over time: held between the points, or a ramp."""
        ffi = self._library.ffi
        times, values = (np.ascontiguousarray(x, dtype=np.float64) for x in (t_s, value))
        self._need(
            self._library.lib.es_sim_set_input(
                self._handle,
                name.encode(),
                ffi.from_buffer("double[]", times),
                ffi.from_buffer("double[]", values),
                len(times),
                linear,
            )
        )

    def open_link(self) -> None:
        """Before the start: the drive talks on the bench link, and nothing else commands it."""
        self._need(self._library.lib.es_sim_link_open(self._handle))

    def link_write(self, octets: bytes) -> int:
        """Octets for the drive; how many it had room for."""
        return self._library.lib.es_sim_link_write(self._handle, octets, len(octets))

    def link_read(self, room: int) -> bytes:
        """Octets that the drive has sent, at most so many."""
        room = min(room, LINK_OCTETS)
        count = self._library.lib.es_sim_link_read(self._handle, self._octets, room) if room > 0 else 0
        return bytes(self._library.ffi.buffer(self._octets, count))

    def reset(self, cause: int) -> None:
        """The processor of a drive on the link starts again; `cause` as `Reset` of the bench has it."""
        if not self._library.lib.es_sim_reset(self._handle, cause):
            raise NativeError(f"reset {cause}: needs an open link, a run that has begun, and a cause of 0 to 4")

    def regions(self) -> dict[str, int]:
        """Parts of the state of the drive in which a bit can be made to flip, with their bits. After the start."""
        lib, ffi = self._library.lib, self._library.ffi
        names = [ffi.string(lib.es_region_name(k)).decode() for k in range(lib.es_region_count())]
        return {name: lib.es_sim_region_bits(self._handle, k) for k, name in enumerate(names)}

    def flip(self, region: str, bit: int) -> None:
        """A bit of the state changes by itself."""
        index = list(self.regions()).index(region)
        if not self._library.lib.es_sim_flip(self._handle, index, bit):
            raise NativeError(f"{region}: has no bit {bit}")

    def open_trace(self, rows_every: int) -> None:
        """Before the start: take down everything that the firmware takes in, and all signals every so many periods."""
        self._need(self._library.lib.es_sim_trace_open(self._handle, rows_every))

    def take_trace(self) -> list[bytes]:
        """What was taken down since the last call, stream by stream."""
        lib, ffi = self._library.lib, self._library.ffi
        streams = []
        for stream in range(lib.es_trace_streams()):
            octets = bytearray(lib.es_sim_trace_size(self._handle, stream))
            if octets:
                lib.es_sim_trace_read(self._handle, stream, ffi.from_buffer("uint8_t[]", octets), len(octets))
            streams.append(bytes(octets))
        self._need(lib.es_sim_trace_taken(self._handle))
        return streams

    def start(self) -> None:
        self._started = False
        self._need(self._library.lib.es_sim_start(self._handle))
        self._started = True

    def record(self, signals: Sequence[str]) -> None:
        """Choose what `run` returns."""
        names = [self._library.ffi.new("char[]", name.encode()) for name in signals]
        self._need(self._library.lib.es_sim_record(self._handle, names, len(names)))
        self._signal_count = len(names)

    def run(self, periods: int, decimate: int = 1) -> NDArray[np.float64]:
        """Go on for so many PWM periods; one row for each `decimate`-th of them."""
        self._need_start()
        rows = -(-periods // decimate)
        out = np.empty((rows, self._signal_count))
        buffer = self._library.ffi.from_buffer("double[]", out, require_writable=True)
        written = self._library.lib.es_sim_run(self._handle, periods, decimate, buffer, rows)
        return out[:written]

    def skip(self, periods: int) -> None:
        """Go on without recording."""
        self._need_start()
        self._library.lib.es_sim_run(self._handle, periods, 1, self._library.ffi.NULL, 0)

    def time_s(self) -> float:
        return self._library.lib.es_sim_time(self._handle)

    def read(self, signal: str) -> float:
        return self._library.lib.es_sim_read(self._handle, signal.encode())

    def tune(self, param: str, value: float) -> None:
        self._need(self._library.lib.es_sim_tune(self._handle, param.encode(), value))

    def memory(self) -> NDArray[np.float64]:
        """What the angle observer has learned, A of q current over one mechanical turn; empty without one."""
        lib, ffi = self._library.lib, self._library.ffi
        amps = np.zeros(lib.es_sim_memory_read(self._handle, ffi.NULL, 0))
        lib.es_sim_memory_read(self._handle, ffi.from_buffer("double[]", amps, require_writable=True), len(amps))
        return amps

    def set_memory(self, amps: Values) -> None:
        """What it knows from the start; only for a drive that does not run."""
        values = np.ascontiguousarray(amps, dtype=np.float64)
        buffer = self._library.ffi.from_buffer("double[]", values)
        self._need(self._library.lib.es_sim_memory_write(self._handle, buffer, len(values)))

    def refusal(self) -> Refusal:
        """Why the last call was refused."""
        return read_refusal(self._library, self._library.lib.es_sim_error(self._handle))

    def _need_start(self) -> None:
        if not self._started:
            raise NativeError("the simulation does not run: start it first")

    def _need(self, done: bool) -> None:
        if not done:
            raise RefusedValueError(self.refusal())


def noise_of(seed: int, periods: int) -> NDArray[np.float64]:
    """The noise that a simulation with this seed draws: a row of two normal numbers a period."""
    library = load()
    pairs = np.empty((periods, 2))
    library.lib.es_noise(seed, library.ffi.from_buffer("double[]", pairs, require_writable=True), periods)
    pairs.setflags(write=False)
    return pairs
