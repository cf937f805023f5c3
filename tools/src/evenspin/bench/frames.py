"""Frames of the bench link (docs/protocol.md): type, number, payload, check sum, in COBS up to a zero octet."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import google_crc32c
from cobs import cobs

MAX_PAYLOAD = 248
MIN_FRAME, MAX_FRAME = 6, 254
MAX_WIRE = MAX_FRAME + 1  # without the delimiter
DELIMITER = b"\x00"


@dataclass(frozen=True, slots=True)
class Frame:
    type: int
    seq: int
    payload: bytes


def crc32c(octets: bytes) -> int:
    return google_crc32c.value(octets)


def encode(frame: Frame) -> bytes:
    """A frame as it goes on the wire, with its delimiter."""
    if len(frame.payload) > MAX_PAYLOAD:
        raise ValueError(f"payload of {len(frame.payload)} octets: at most {MAX_PAYLOAD}")
    body = bytes((frame.type, frame.seq)) + frame.payload
    return cobs.encode(body + struct.pack("<I", crc32c(body))) + DELIMITER


def decode(wire: bytes) -> Frame | None:
    """What stands between two delimiters; None: it is no frame."""
    if not MIN_FRAME < len(wire) <= MAX_WIRE:
        return None
    try:
        octets = cobs.decode(wire)
    except cobs.DecodeError:
        return None
    if not MIN_FRAME <= len(octets) <= MAX_FRAME:
        return None
    body, check = octets[:-4], struct.unpack("<I", octets[-4:])[0]
    return Frame(body[0], body[1], body[2:]) if crc32c(body) == check else None


class Decoder:
    """Cuts a stream of octets into frames; what is no frame is dropped and counted. It holds one frame at most."""

    def __init__(self) -> None:
        self._open = b""
        self._flood = False  # longer than any frame: wait for the next delimiter
        self.bad = 0

    def feed(self, octets: bytes) -> list[Frame]:
        *closed, remainder = (self._open + octets).split(DELIMITER)
        found = []
        for number, wire in enumerate(closed):
            flooded, self._flood = self._flood and number == 0, False
            if not wire and not flooded:
                continue
            frame = None if flooded else decode(wire)
            if frame is None:
                self.bad += 1
            else:
                found.append(frame)
        if len(remainder) > MAX_WIRE:
            self._flood, remainder = True, b""
        self._open = remainder
        return found
