"""Make the frames that both ends of the bench link must agree on, with packages that are neither end.

    make_vectors.py                  write protocol.json beside this file
    make_vectors.py --check          exit status 1 when protocol.json is not that, 77 when a package is missing
    make_vectors.py --header FILE    write protocol.json as a C header; needs no package

COBS by `cobs`, check sums by `crc` (it does not name CRC-32/ISCSI, so the parameters stand here, with the published
check value as proof), numbers by `struct`.
"""

from __future__ import annotations

import json
import random
import struct
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
JSON = HERE / "protocol.json"
PAYLOAD_MAX = 248
MISSING = 77


def reference():
    """CRC of octets, and COBS of octets."""
    from cobs import cobs
    from crc import Calculator, Configuration

    iscsi = Calculator(
        Configuration(32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, reverse_input=True, reverse_output=True), optimized=True
    )
    assert iscsi.checksum(b"123456789") == 0xE3069283
    return iscsi.checksum, cobs.encode


def text(value: str) -> bytes:
    return bytes([len(value)]) + value.encode("ascii")


def examples() -> dict[str, tuple[int, int, bytes]]:
    """Name: type, sequence, payload. One of every message, and the corners of the framing."""
    pack = struct.pack
    inf, nan = float("inf"), struct.unpack("<f", b"\x01\x00\xc0\x7f")[0]
    shuffled = random.Random(20260).randbytes(PAYLOAD_MAX)
    return {
        "hello": (0x01, 1, pack("<HI", 1, 0xDEADBEEF)),
        "hello_answer": (
            0x81,
            1,
            pack(
                "<HIBBIIHHHHHBBBIIBHI",
                1,
                0x12345678,
                1,
                0,
                10000,
                200000000,
                248,
                133,
                27,
                18,
                12,
                12,
                8,
                2,
                6140,
                2048,
                1,
                500,
                0x89ABCDEF,
            )
            + text("simulator")
            + text("0.1.0"),
        ),
        "list": (0x02, 2, pack("<BH", 0, 7)),
        "list_answer_parameter": (
            0x82,
            2,
            pack("<BHB", 0, 0, 1) + pack("<Bfff", 1, 1.0, 50.0, 4.0) + text("pole_pairs") + text("") + text(""),
        ),
        "list_answer_signals": (
            0x82,
            3,
            pack("<BHB", 1, 7, 2) + text("ia_a") + text("A") + text("ib_a") + text("A"),
        ),
        "text": (0x03, 3, pack("<BHBH", 2, 1, 1, 0)),
        "text_answer": (0x83, 3, pack("<BHBHH", 2, 1, 1, 0, 11) + b"Supply, fuse"[:11]),
        "state": (0x04, 4, b""),
        "state_answer": (0x84, 4, pack("<IBBHHHIIII", 70000, 4, 1, 0, 0, 0b0101_0111, 3, 2, 1, 0)),
        "read": (0x05, 5, pack("<B3H", 3, 0, 256, 26)),
        "read_answer": (0x85, 5, pack("<IB3f", 4294967295, 3, 1.5, -0.0, 1e-40)),
        "get": (0x10, 6, pack("<HB", 0, 60)),
        "get_answer": (0x90, 6, pack("<HB2f", 10, 2, 0.6, 1080.0)),
        "set": (0x11, 7, pack("<BBHfHf", 3, 2, 10, 0.25, 300, inf)),
        "set_answer": (0x91, 7, pack("<BB2f", 3, 2, 0.25, 3.4028234663852886e38)),
        "command_stop": (0x20, 8, pack("<H", 0)),
        "command_answer": (0xA0, 8, pack("<HB", 0, 3)),
        "setpoint": (0x21, 9, pack("<Bfffif", 2, -31.4159, 0.0, 2.5, -2147483648, 6.28)),
        "setpoint_answer": (0xA1, 9, pack("<I", 1)),
        "alive": (0x22, 10, b""),
        "alive_answer": (0xA2, 10, pack("<IBHH", 5, 3, 17, 0)),
        "timeout": (0x23, 11, pack("<H", 60000)),
        "excite": (0x24, 20, pack("<Bff", 1, 0.5, 123.25)),
        "excite_answer": (0xA4, 20, pack("<If", 123456, 123.25)),
        "stream_configure": (0x30, 12, pack("<HBB8H", 10, 0, 8, *range(8))),
        "stream_configure_answer": (0xB0, 12, pack("<BBH", 255, 7, 1024)),
        "stream": (0x40, 255, pack("<BBHI6f", 255, 3, 65535, 0xFFFFFFF6, 1.0, 2.0, 3.0, 4.0, 5.0, nan)),
        "capture_configure": (0x31, 13, pack("<BHHHBHfB2H", 0, 1, 100, 400, 1, 5, -0.5, 2, 5, 6)),
        "capture_status": (0x32, 14, b"\x01"),
        "capture_status_answer": (0xB2, 14, pack("<BBBBHHHHIIB2H", 1, 3, 4, 4, 1, 240, 256, 256, 1000, 1240, 2, 5, 6)),
        "capture_read": (0x33, 15, pack("<BIB", 0, 65536, 60)),
        "capture_control": (0x34, 16, b"\x00\x02"),
        "fault": (0x35, 17, b""),
        "timing": (0x36, 18, b"\x01"),
        "learned": (0x37, 19, pack("<HB", 120, 60)),
        "event": (0x41, 0, pack("<IBHHH", 123456, 5, 1, 0, 8)),
        "refused_range": (0xFF, 7, pack("<BBHff", 0x11, 4, 300, 0.0, 1000.0)),
        "shortest": (0x04, 0, b""),
        "zeros": (0x00, 0, bytes(PAYLOAD_MAX)),
        "no_zeros": (0x7F, 0x7F, bytes([0xFF]) * PAYLOAD_MAX),
        "longest_random": (0x55, 0xAA, shuffled),
        "zero_last": (0x01, 0x02, b"\x03\x00"),
        "one_zero_in_the_middle": (0x11, 0x22, bytes([1] * 120 + [0] + [2] * 127)),
    }


def floats() -> list[dict[str, object]]:
    """Bits of numbers, so that both ends mean the same by them."""
    rows = [0.0, -0.0, 1.0, -1.0, 0.1, 3.4028234663852886e38, 1.1754943508222875e-38, 1e-45, 2.0**24]
    return [{"value": x, "bits": struct.unpack("<I", struct.pack("<f", x))[0]} for x in rows]


def build() -> str:
    checksum, stuff = reference()
    frames = []
    for name, (kind, seq, payload) in examples().items():
        body = bytes([kind, seq]) + payload
        crc = checksum(body)
        wire = stuff(body + struct.pack("<I", crc)) + b"\0"
        frames.append(
            {"name": name, "type": kind, "seq": seq, "payload": payload.hex(), "crc": crc, "wire": wire.hex()}
        )
    good = bytes.fromhex(frames[0]["wire"])
    body = bytes([0x01, 0x01]) + bytes(PAYLOAD_MAX + 1)
    long_body = body + struct.pack("<I", checksum(body))
    short = bytes([0x01])
    dropped = {
        "cut_short": good[:-3] + b"\0",
        "one_octet_more": good[:-1] + b"\x55\0",
        "wrong_check": good[:-2] + bytes([good[-2] ^ 1]) + b"\0",
        "code_beyond_the_end": bytes([good[0] + 200]) + good[1:],
        "too_long_by_one": stuff(long_body) + b"\0",
        "type_alone_with_check": stuff(short + struct.pack("<I", checksum(short))) + b"\0",
        "check_of_nothing": stuff(struct.pack("<I", checksum(b""))) + b"\0",
        "one_octet": b"\x01\0",
        "long_rubbish": bytes([0xFF]) * 600 + b"\0",
    }
    texts = (b"", b"\0", b"123456789", bytes(32), b"\xff" * 32, bytes(range(256)))
    crcs = [{"text": t.hex(), "crc": checksum(t)} for t in texts]
    table = {
        "about": "Made by tests/vectors/make_vectors.py; octets in hexadecimal, wire with the delimiter.",
        "frames": frames,
        "dropped": [{"name": name, "wire": wire.hex()} for name, wire in dropped.items()],
        "crcs": crcs,
        "floats": floats(),
    }
    return json.dumps(table, indent=1) + "\n"


def array(name: str, octets: bytes) -> str:
    body = ", ".join(f"0x{x:02X}U" for x in octets) or "0U"
    return f"static const uint16_t {name}[] = {{{body}}};\n"


def header(table: dict) -> str:
    out = ["/* Made from tests/vectors/protocol.json by the build. */\n#pragma once\n#include <stdint.h>\n\n"]
    out.append("typedef struct {\n    const char *name;\n    uint16_t type, seq;\n    uint32_t crc;\n    const "
               "uint16_t *payload, *wire;\n    uint16_t payload_count, wire_count;\n} vector_frame_t;\n")  # fmt: skip
    rows = []
    for i, f in enumerate(table["frames"]):
        payload, wire = bytes.fromhex(f["payload"]), bytes.fromhex(f["wire"])
        out += [array(f"payload_{i}", payload), array(f"wire_{i}", wire)]
        rows.append(f'    {{"{f["name"]}", 0x{f["type"]:02X}U, 0x{f["seq"]:02X}U, UINT32_C({f["crc"]}), payload_{i}, '
                    f"wire_{i}, {len(payload)}U, {len(wire)}U}},\n")  # fmt: skip
    out += ["static const vector_frame_t VECTOR_FRAMES[] = {\n", *rows, "};\n"]
    out.append("typedef struct {\n    const char *name;\n    const uint16_t *octets;\n    uint16_t count;\n"
               "    uint32_t value;\n} vector_octets_t;\n")  # fmt: skip
    for key, field, value in (("dropped", "wire", None), ("crcs", "text", "crc")):
        rows = []
        for i, f in enumerate(table[key]):
            octets = bytes.fromhex(f[field])
            out.append(array(f"{key}_{i}", octets))
            number = f[value] if value else 0
            rows.append(f'    {{"{f.get("name", i)}", {key}_{i}, {len(octets)}U, UINT32_C({number})}},\n')
        out += [f"static const vector_octets_t VECTOR_{key.upper()}[] = {{\n", *rows, "};\n"]
    out.append("typedef struct {\n    float value;\n    uint32_t bits;\n} vector_float_t;\n")
    rows = [f"    {{{float(f['value'])!r}f, UINT32_C({f['bits']})}},\n" for f in table["floats"]]
    out += ["static const vector_float_t VECTOR_FLOATS[] = {\n", *rows, "};\n"]
    return "".join(out)


def main(arguments: list[str]) -> int:
    if arguments[:1] == ["--header"] and len(arguments) == 2:
        Path(arguments[1]).write_text(header(json.loads(JSON.read_text(encoding="utf-8"))), encoding="utf-8")
        return 0
    try:
        made = build()
    except ImportError as missing:
        print(f"make_vectors: {missing.name} is not installed")
        return MISSING
    if arguments == ["--check"]:
        same = made == JSON.read_text(encoding="utf-8")
        print(f"make_vectors: protocol.json is {'what' if same else 'not what'} the reference makes")
        return 0 if same else 1
    if arguments:
        print(__doc__, file=sys.stderr)
        return 2
    JSON.write_text(made, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
