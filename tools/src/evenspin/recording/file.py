"""The file: a line that says what it is, then frames, each with its check sum.

    "evenspin recording\\n"                         19 octets
    frame    kind (4 letters), length (u32), that many octets, CRC-32 over all of it (u32); numbers little-endian
    HEAD     once, first: JSON with format, trace, numeric, schema, firmware, signals, ... (Head)
    PART     whole PWM periods: first period (u64), periods (u32), then for each stream its length (u32), its
             length packed (u32) and the octets, packed by zlib
    DONE     once, last: periods (u64)

What a trace holds is in sim_host/trace/trace.h. A file without DONE is one whose writer was killed, or that was cut.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO

from evenspin.errors import InputError

ENDING = ".replay"
MAGIC = b"evenspin recording\n"
FORMAT = 1
HEAD, PART, DONE = b"HEAD", b"PART", b"DONE"
FRAME = struct.Struct("<4sI")
CRC = struct.Struct("<I")
PERIODS = struct.Struct("<QI")
STREAM = struct.Struct("<II")
TOTAL = struct.Struct("<Q")
MOST_OCTETS = 1 << 28  # of a frame, and of a stream unpacked: a length beyond is damage
STREAMS_MAX = 16
LEVEL = 1  # of zlib: noise packs no better at a higher one
AGAIN = "record it again"
WITH_MAKER = "replay it with the evenspin that made it"


class RecordingError(InputError):
    """A file that is no recording, or none that can be replayed here."""


@dataclass(frozen=True, slots=True)
class Head:
    """What a recording is of. `firmware` changes with every source of the firmware, `schema` with its parameters,
    signals, faults and commands."""

    trace: int  # version of what stands in the streams
    numeric: str
    firmware: str
    schema: int
    signals: tuple[str, ...]
    pwm_hz: float
    rows_every: int  # periods between two stored rows of all signals
    linked: bool
    what: str  # scenario or model
    seed: int
    made_by: str  # version and commit
    command: str

    def as_json(self) -> dict[str, Any]:
        return {"format": FORMAT, **asdict(self), "signals": list(self.signals)}


@dataclass(frozen=True, slots=True)
class Part:
    """Whole periods of a trace."""

    first: int
    periods: int
    streams: tuple[bytes, ...]


class Writer:
    """Writes a recording part by part; `close` makes it whole."""

    def __init__(self, file: BinaryIO, head: Head) -> None:
        self._file = file
        self.periods = 0
        file.write(MAGIC)
        self._frame(HEAD, json.dumps(head.as_json()).encode())

    def part(self, periods: int, streams: Sequence[bytes]) -> None:
        content = [PERIODS.pack(self.periods, periods)]
        for octets in streams:
            packed = zlib.compress(octets, LEVEL)
            content += [STREAM.pack(len(octets), len(packed)), packed]
        self._frame(PART, b"".join(content))
        self.periods += periods

    def close(self) -> None:
        self._frame(DONE, TOTAL.pack(self.periods))

    def _frame(self, kind: bytes, content: bytes) -> None:
        begin = FRAME.pack(kind, len(content))
        self._file.write(begin)
        self._file.write(content)
        self._file.write(CRC.pack(zlib.crc32(content, zlib.crc32(begin))))


class RecordingFile:
    """A recording on disk: its head at once, its parts one by one. What is damaged is refused where it stands."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with path.open("rb") as file:
            magic = file.read(len(MAGIC))
            if magic != MAGIC:
                raise self._bad("none", f"a file {ENDING} that `evenspin run --record` wrote", AGAIN)
            self.head = self._head(self._frame(file, "the head"))
            self._begin = file.tell()

    def length_s(self) -> float:
        """Its length by its last frame, unchecked: for a progress bar; 0 where there is none."""
        size = FRAME.size + TOTAL.size + CRC.size
        with self.path.open("rb") as file:
            file.seek(max(self._begin, self.path.stat().st_size - size))
            end = file.read(size)
        known = len(end) == size and end.startswith(DONE)
        return TOTAL.unpack_from(end, FRAME.size)[0] / self.head.pwm_hz if known else 0.0

    def parts(self) -> Iterator[Part]:
        """Every part in order, checked; the end is checked, too."""
        periods = 0
        with self.path.open("rb") as file:
            file.seek(self._begin)
            while True:
                kind, content = self._frame(file, f"what follows period {periods}")
                if kind == DONE:
                    self._check_end(content, periods, file)
                    return
                if kind != PART:
                    raise self._damaged(f"an unknown frame behind period {periods}")
                part = self._part(content, periods)
                periods += part.periods
                yield part

    def _frame(self, file: BinaryIO, what: str) -> tuple[bytes, bytes]:
        begin = file.read(FRAME.size)
        if len(begin) < FRAME.size:
            raise self._cut(what)
        kind, length = FRAME.unpack(begin)
        if length > MOST_OCTETS:
            raise self._damaged(what)
        content, crc = file.read(length), file.read(CRC.size)
        if len(content) < length or len(crc) < CRC.size:
            raise self._cut(what)
        if CRC.unpack(crc)[0] != zlib.crc32(content, zlib.crc32(begin)):
            raise self._damaged(what)
        return kind, content

    def _head(self, frame: tuple[bytes, bytes]) -> Head:
        kind, content = frame
        try:
            value = json.loads(content)
            if kind != HEAD or not isinstance(value, dict):
                raise ValueError
            if value["format"] != FORMAT:
                raise self._bad(f"format {value['format']}", f"of format {FORMAT}", WITH_MAKER)
            fields = {name: value[name] for name in Head.__dataclass_fields__}
            return Head(**(fields | {"signals": tuple(str(name) for name in value["signals"])}))
        except (ValueError, KeyError, TypeError, RecursionError):
            raise self._damaged("the head") from None

    def _part(self, content: bytes, expected: int) -> Part:
        where = f"what follows period {expected}"
        streams: list[bytes] = []
        try:
            first, periods = PERIODS.unpack_from(content, 0)
            at = PERIODS.size
            while at < len(content) and len(streams) < STREAMS_MAX:
                length, packed = STREAM.unpack_from(content, at)
                at += STREAM.size
                streams.append(_unpacked(content[at : at + packed], length))
                at += packed
        except (struct.error, zlib.error, ValueError):
            raise self._damaged(where) from None
        if first != expected or at != len(content):
            raise self._damaged(where)
        return Part(first, periods, tuple(streams))

    def _check_end(self, content: bytes, periods: int, file: BinaryIO) -> None:
        if len(content) != TOTAL.size or TOTAL.unpack(content)[0] != periods or file.read(1):
            raise self._damaged("the end")

    def _damaged(self, what: str) -> RecordingError:
        return self._bad("damaged", f"as it was written; {what} does not match its check sum", AGAIN)

    def _cut(self, what: str) -> RecordingError:
        return self._bad("truncated", f"whole; {what} is missing", "let the command that records come to its end")

    def _bad(self, found: str, must: str, hint: str) -> RecordingError:
        return RecordingError(self.path, "recording", found, must, hint)


def _unpacked(packed: bytes, length: int) -> bytes:
    if length > MOST_OCTETS:
        raise ValueError
    machine = zlib.decompressobj()
    octets = machine.decompress(packed, length + 1)
    if len(octets) != length or not machine.eof or machine.unused_data:
        raise ValueError
    return octets
