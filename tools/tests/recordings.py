"""Recordings of runs, for tests: made in memory of the disk, replayed, changed on purpose."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from evenspin.model.setup import Setup
from evenspin.native import tables
from evenspin.recording import Head, Part, Player, Recorder, RecordingFile, Writer
from evenspin.sim import Record, complete, prepare

SIGNALS = tuple(tables().signals)


def record_run(
    setup: Setup, path: Path, numeric: str = "float", memory: Sequence[float] | None = None, rows_every: int = 10
) -> Record:
    """The run, recorded to `path`; its log."""
    with path.open("wb") as file:
        recorder = Recorder(
            file, numeric=numeric, what=setup.name, seed=setup.seed, pwm_hz=setup.pwm_hz, rows_every=rows_every
        )
        log = complete(prepare(setup, SIGNALS, numeric, memory, recorder), setup, SIGNALS, None, recorder)
        recorder.close()
    return log


def play(path: Path) -> tuple[Player, np.ndarray]:
    """All of it: every signal of the firmware at the end of every period."""
    file = RecordingFile(path)
    player = Player(path, file.head)
    rows = []
    for part in file.parts():
        player.feed(part)
        while not player.ended and len(more := player.run(part.periods)):
            rows.append(more)
    return player, np.concatenate(rows)


def rewritten(
    path: Path,
    target: Path,
    head: Callable[[Head], Head] = lambda head: head,
    part: Callable[[Part], Part] = lambda part: part,
) -> Path:
    """The recording with another head or other parts, and check sums that fit."""
    file = RecordingFile(path)
    with target.open("wb") as out:
        writer = Writer(out, head(file.head))
        for each in file.parts():
            changed = part(each)
            writer.part(changed.periods, changed.streams)
        writer.close()
    return target


def with_parameter(part: Part, name: str, was: float, value: float) -> Part:
    """The first part of a run without a link, as if the drive had started with another value of a parameter.

    The parameters are the first words of the trace: each is stored as the bits in which it differs from the one before
    it, octet by octet in the streams 1 to 4."""
    if part.first:
        return part
    index = list(tables().params).index(name)
    bits = [int(np.float32(each).view(np.uint32)) for each in (was, value)]
    change = (bits[0] ^ bits[1]).to_bytes(4, "big")
    streams = [bytearray(stream) for stream in part.streams]
    for stream, octet in zip(streams[1:5], change, strict=True):
        stream[index] ^= octet
        stream[index + 1] ^= octet
    return replace(part, streams=tuple(bytes(stream) for stream in streams))
