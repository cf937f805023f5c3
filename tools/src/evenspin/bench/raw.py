"""The raw container of a recording: MCAP, written so that what was recorded survives a crash.

Every block of rows is a message as it came from the drive, every change of its state another; the file is flushed twice
a second. A file whose end is missing is read up to where it breaks off.
"""

from __future__ import annotations

import contextlib
import json
import os
import struct
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from mcap.exceptions import McapError
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from evenspin.bench.stream import Block
from evenspin.errors import InputError
from evenspin.sim.record import Record

TOPIC, ENCODING, SCHEMA = "/rows", "evenspin-rows", "evenspin.Rows"
LAYOUT = "little endian: counter u64, lost_before u32, rows u32, then rows x signals float32; names: see the channel"
EVENTS, JSON, EVENT_SCHEMA = "/events", "json", "evenspin.Event"
HEAD = struct.Struct("<QII")
FLUSH_S = 0.5


class RawWriter:
    """Write blocks of one stream, and what happened meanwhile. A file that exists is never written over.

    `zero`: the period from which time is counted; None: that of the first row.
    """

    def __init__(
        self,
        path: Path,
        names: Sequence[str],
        units: Sequence[str],
        decimation: int,
        pwm_hz: float,
        source: str,
        zero: int | None = None,
    ) -> None:
        self.path = path
        self._pwm_hz = float(pwm_hz)
        self._failed = False
        self._file = path.open("xb")
        self._writer = Writer(self._file, compression=CompressionType.NONE, use_chunking=False)
        self._writer.start(profile="evenspin", library="evenspin")
        schema = self._writer.register_schema(SCHEMA, "text", LAYOUT.encode())
        metadata = {
            "signals": json.dumps(list(names)),
            "units": json.dumps(list(units)),
            "decimation": str(decimation),
            "pwm_hz": repr(float(pwm_hz)),
            "source": source,
        }
        if zero is not None:
            metadata["zero"] = str(zero)
        self._channel = self._writer.register_channel(TOPIC, ENCODING, schema, metadata)
        schema_id = self._writer.register_schema(EVENT_SCHEMA, "jsonschema", b'{"type": "object"}')
        self._events = self._writer.register_channel(EVENTS, JSON, schema_id)
        self._count = 0
        self._flushed_s = time.monotonic()

    def write(self, block: Block) -> None:
        data = HEAD.pack(block.counter, block.lost_before, len(block)) + block.values.astype("<f4").tobytes()
        self._add(self._channel, block.counter, data)

    def event(self, counter: int, content: Mapping[str, Any]) -> None:
        """A change of the drive's state, with its period."""
        self._add(self._events, counter, json.dumps({"counter": counter, **content}).encode())

    def _add(self, channel: int, counter: int, data: bytes) -> None:
        at_ns = round(counter / self._pwm_hz * 1e9)
        with self._noticing():
            self._writer.add_message(channel, at_ns, data, at_ns, self._count)
            self._count += 1
            if time.monotonic() - self._flushed_s > FLUSH_S:
                self._flushed_s = time.monotonic()
                self._file.flush()

    @contextlib.contextmanager
    def _noticing(self) -> Iterator[None]:
        """After an error nothing more is written: what is there stays readable up to there."""
        try:
            yield
        except OSError as error:
            self._failed = True
            raise OSError(error.errno, error.strerror, str(self.path)) from None

    def __enter__(self) -> RawWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        """Onto the disk. A file without a row is no recording and is removed when something went wrong."""
        try:
            if self._failed:
                with contextlib.suppress(OSError):
                    self._file.close()
            else:
                with self._noticing():
                    self._finish()
        finally:
            if kind is not None and rows_in(self.path) == 0:
                self.path.unlink(missing_ok=True)

    def _finish(self) -> None:
        try:
            self._writer.finish()
            self._file.flush()
            os.fsync(self._file.fileno())
        finally:
            self._file.close()


@dataclass(frozen=True, slots=True)
class RawRecording:
    """`record` has a column t_s, from the first row; lost rows are left out. `whole`: the file has its end."""

    record: Record
    lost_rows: int
    pwm_hz: float
    decimation: int
    source: str
    whole: bool
    events: tuple[Mapping[str, Any], ...] = ()  # changes of the drive's state: counter, t_s, state, fault, text


def read_raw(path: Path) -> RawRecording:
    try:
        with path.open("rb") as file:
            metadata, blocks, events, whole = _read(StreamReader(file).records)
    except FileNotFoundError:
        raise InputError(path, "file", "(missing)", "an existing file", "`evenspin bench record` writes one") from None
    except (OSError, McapError, EOFError, struct.error, AssertionError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not MCAP"
        raise InputError(path, "file", reason, "an MCAP file", "`evenspin bench record` writes one") from None
    if metadata is None or not blocks:
        raise InputError(path, "rows", 0, "at least 1", "it broke off before the first row, or is not of evenspin")
    names, units = json.loads(metadata["signals"]), json.loads(metadata["units"])
    pwm_hz, decimation = float(metadata["pwm_hz"]), int(metadata["decimation"])
    counters, values, lost = [], [], 0
    for data in blocks:
        counter, lost_before, rows = HEAD.unpack_from(data)
        counters.append(counter + decimation * np.arange(rows, dtype=np.int64))
        values.append(np.frombuffer(data, "<f4", offset=HEAD.size).reshape(rows, len(names)))
        lost += lost_before
    every = np.concatenate(counters)
    zero = int(metadata["zero"]) if "zero" in metadata else int(every[0])
    t_s = (every - zero) / pwm_hz
    table = np.column_stack((t_s, np.concatenate(values).astype(np.float64)))
    record = Record(("t_s", *names), ("s", *units), table)
    timed = tuple({**event, "t_s": (event["counter"] - zero) / pwm_hz} for event in events)
    return RawRecording(record, lost, pwm_hz, decimation, metadata["source"], whole, timed)


def rows_in(path: Path) -> int:
    """How many rows a recording holds, as far as it can be read; 0 also when there is none, or it is something else."""
    try:
        with path.open("rb") as file:
            _, blocks, _, _ = _read(StreamReader(file).records)
    except (OSError, McapError, EOFError, struct.error, AssertionError, ValueError):
        return 0
    return sum(HEAD.unpack_from(data)[2] for data in blocks)


def _read(records: Iterator[Any]) -> tuple[dict[str, str] | None, list[bytes], list[dict[str, Any]], bool]:
    metadata, channels = None, {}
    blocks: list[bytes] = []
    events: list[dict[str, Any]] = []
    try:
        for record in records:
            kind = type(record).__name__
            if kind == "Channel":
                channels[record.id] = record.topic
                if record.message_encoding == ENCODING:
                    metadata = dict(record.metadata)
            elif kind == "Message" and channels.get(record.channel_id) == TOPIC:
                blocks.append(record.data)
            elif kind == "Message" and channels.get(record.channel_id) == EVENTS:
                events.append(json.loads(record.data))
            elif kind == "Footer":
                return metadata, blocks, events, True
    except (McapError, EOFError, struct.error, AssertionError, ValueError):
        if metadata is None:
            raise
    return metadata, blocks, events, False
