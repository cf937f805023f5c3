"""Frames of the link: against the vectors that the C side shares, and against damage of every kind."""

from __future__ import annotations

import json
import random
from itertools import combinations
from pathlib import Path

import pytest
from evenspin.bench.frames import MAX_PAYLOAD, Decoder, Frame, crc32c, decode, encode
from hypothesis import given
from hypothesis import strategies as st

VECTORS = json.loads((Path(__file__).parents[2] / "tests" / "vectors" / "protocol.json").read_text())["frames"]

frames = st.builds(Frame, st.integers(0, 255), st.integers(0, 255), st.binary(max_size=MAX_PAYLOAD))


@pytest.mark.parametrize("vector", VECTORS, ids=[vector["name"] for vector in VECTORS])
def test_a_shared_vector_is_made_and_read_as_it_stands(vector: dict) -> None:
    frame = Frame(vector["type"], vector["seq"], bytes.fromhex(vector["payload"]))

    assert encode(frame).hex() == vector["wire"]
    assert Decoder().feed(bytes.fromhex(vector["wire"])) == [frame]


def test_the_check_sum_is_that_of_rfc_3720() -> None:
    assert crc32c(b"123456789") == 0xE3069283  # check value of the catalogue
    assert crc32c(bytes(32)) == 0x8A9136AA  # RFC 3720, B.4: 32 octets of zeroes


@given(st.lists(frames, max_size=5), st.integers(1, 40))
def test_frames_come_back_however_the_stream_is_cut(sent: list[Frame], size: int) -> None:
    wire = b"\x00" + b"".join(encode(frame) for frame in sent)
    decoder = Decoder()

    found = [frame for at in range(0, len(wire), size) for frame in decoder.feed(wire[at : at + size])]

    assert found == sent
    assert decoder.bad == 0


@given(st.binary(max_size=2000), frames)
def test_rubbish_never_passes_for_long_and_the_next_frame_is_read(rubbish: bytes, frame: Frame) -> None:
    decoder = Decoder()

    decoder.feed(rubbish)

    assert decoder.feed(b"\x00" + encode(frame))[-1] == frame
    assert len(decoder._open) <= 256  # one frame at most is held


def test_every_error_of_one_or_two_bits_is_seen() -> None:
    wire = encode(Frame(0x84, 7, bytes(range(1, 13))))[:-1]
    bits = range(8 * len(wire))

    for flipped in [(bit,) for bit in bits] + list(combinations(bits, 2)):
        damaged = bytearray(wire)
        for bit in flipped:
            damaged[bit // 8] ^= 1 << (bit % 8)
        assert Decoder().feed(bytes(damaged) + b"\x00") == [], flipped


def test_every_single_bit_error_of_the_longest_frame_is_seen() -> None:
    wire = encode(Frame(0x40, 255, random.Random(1).randbytes(MAX_PAYLOAD)))[:-1]

    for bit in range(8 * len(wire)):
        damaged = bytearray(wire)
        damaged[bit // 8] ^= 1 << (bit % 8)
        assert Decoder().feed(bytes(damaged) + b"\x00") == [], bit


def test_a_flood_without_a_delimiter_counts_as_one_bad_frame() -> None:
    decoder = Decoder()
    for _ in range(50):
        assert decoder.feed(b"\x55" * 100) == []

    assert decoder.feed(b"\x00" + encode(Frame(1, 2, b"x"))) == [Frame(1, 2, b"x")]
    assert decoder.bad == 1


def test_what_is_too_short_or_too_long_is_no_frame() -> None:
    assert decode(b"") is None
    assert decode(b"\x01" * 3) is None
    with pytest.raises(ValueError, match="at most 248"):
        encode(Frame(1, 1, bytes(MAX_PAYLOAD + 1)))
