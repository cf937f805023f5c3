"""Seeds for the fuzzers, from the frames of tests/vectors.

make_corpus.py DIRECTORY    writes DIRECTORY/frame/* and DIRECTORY/session/*
"""

from __future__ import annotations

import json
import struct
import sys
from pathlib import Path

VECTORS = Path(__file__).resolve().parents[1] / "vectors" / "protocol.json"
HELLO, PERIODS = 0xFF, 0xC8


def request(kind: int, payload: bytes = b"") -> bytes:
    return bytes([kind, len(payload)]) + payload


def command(number: int) -> bytes:
    return request(0x20, struct.pack("<H", number))


def main(arguments: list[str]) -> int:
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    frames = json.loads(VECTORS.read_text(encoding="utf-8"))["frames"]
    out = Path(arguments[0])
    for name in ("frame", "session"):
        (out / name).mkdir(parents=True, exist_ok=True)
    requests = []
    for frame in frames:
        (out / "frame" / frame["name"]).write_bytes(bytes.fromhex(frame["wire"]))
        if frame["type"] < 0x40:
            requests.append(request(frame["type"], bytes.fromhex(frame["payload"])))
    for number, one in enumerate(requests):
        (out / "session" / f"request_{number}").write_bytes(bytes([HELLO]) + one + bytes([PERIODS]))
    setpoint = request(0x21, struct.pack("<Bfffif", 1, 20.0, 0.0, 0.0, 0, 0.0))
    talks = {
        "everything": b"".join(one + bytes([PERIODS]) for one in requests),
        "run": bytes([HELLO]) + command(1) + setpoint + command(3) + bytes([PERIODS]) * 3 + command(0),
        "save": bytes([HELLO]) + command(6) + bytes([PERIODS]) + command(7) + bytes([254]) + command(6),
        "stream": bytes([HELLO])
        + request(0x30, struct.pack("<HBB2H", 1, 0, 2, 1, 2))
        + bytes([PERIODS])
        + request(0x31, struct.pack("<BHHHBHfB2H", 0, 1, 10, 10, 1, 1, 0.5, 2, 1, 2))
        + bytes([PERIODS])
        + request(0x34, b"\0\1")
        + request(0x33, struct.pack("<BIB", 0, 0, 60)),
        "raw": bytes([191]) + bytes.fromhex(frames[0]["wire"]) * 5,
    }
    for name, talk in talks.items():
        (out / "session" / name).write_bytes(talk)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
