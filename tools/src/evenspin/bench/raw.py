"""The raw container of a recording: MCAP, written so that what was recorded survives a crash.

Every block of rows is a message as it came from the drive; the file is flushed twice a second. A file whose end is
missing is read up to where it breaks off.
"""

from __future__ import annotations

import json
import struct
import time
from collections.abc import Iterator, Sequence
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
HEAD = struct.Struct("<QII")
FLUSH_S = 0.5


class RawWriter:
    """Write blocks of one stream."""

    def __init__(
        self, path: Path, names: Sequence[str], units: Sequence[str], decimation: int, pwm_hz: float, source: str
    ) -> None:
        self.path = path
        self._file = path.open("wb")
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
        self._channel = self._writer.register_channel(TOPIC, ENCODING, schema, metadata)
        self._count = 0
        self._flushed_s = time.monotonic()

    def write(self, block: Block) -> None:
        data = HEAD.pack(block.counter, block.lost_before, len(block)) + block.values.astype("<f4").tobytes()
        at_ns = round(block.counter / block.pwm_hz * 1e9)
        self._writer.add_message(self._channel, at_ns, data, at_ns, self._count)
        self._count += 1
        if time.monotonic() - self._flushed_s > FLUSH_S:
            self._flushed_s = time.monotonic()
            self._file.flush()

    def __enter__(self) -> RawWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        self._writer.finish()
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


def read_raw(path: Path) -> RawRecording:
    try:
        with path.open("rb") as file:
            metadata, blocks, whole = _read(StreamReader(file).records)
    except FileNotFoundError:
        raise InputError(path, "file", "(missing)", "an existing file", "`evenspin bench record` writes one") from None
    except (OSError, McapError) as error:
        raise InputError(path, "file", str(error), "an MCAP file", "`evenspin bench record` writes one") from None
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
    t_s = (every - every[0]) / pwm_hz
    table = np.column_stack((t_s, np.concatenate(values).astype(np.float64)))
    record = Record(("t_s", *names), ("s", *units), table)
    return RawRecording(record, lost, pwm_hz, decimation, metadata["source"], whole)


def _read(records: Iterator[Any]) -> tuple[dict[str, str] | None, list[bytes], bool]:
    metadata, blocks = None, []
    try:
        for record in records:
            kind = type(record).__name__
            if kind == "Channel" and record.message_encoding == ENCODING:
                metadata = dict(record.metadata)
            elif kind == "Message":
                blocks.append(record.data)
            elif kind == "Footer":
                return metadata, blocks, True
    except (McapError, EOFError, struct.error, AssertionError):
        if metadata is None:
            raise
    return metadata, blocks, False
