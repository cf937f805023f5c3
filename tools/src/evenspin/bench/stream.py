"""Rows that the drive sends by itself, put together again, with every gap known."""

from __future__ import annotations

import struct
import threading
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from evenspin.bench.errors import LinkLostError, LostSamplesError
from evenspin.bench.link import Link
from evenspin.bench.messages import COUNTER_MODULUS

HEAD = struct.Struct("<BBHI")
QUEUE_BLOCKS = 20_000  # some minutes of a stream that nobody takes


@dataclass(frozen=True, slots=True)
class Block:
    """Rows without a gap between them. `counter` is the PWM period of the first one since the start of the drive."""

    counter: int
    decimation: int
    pwm_hz: float
    values: NDArray[np.float32]
    lost_before: int = 0  # rows between this block and the one before

    def __len__(self) -> int:
        return len(self.values)

    @property
    def counters(self) -> NDArray[np.int64]:
        return self.counter + self.decimation * np.arange(len(self.values), dtype=np.int64)

    @property
    def t_s(self) -> NDArray[np.float64]:
        """Time since the start of the drive."""
        return self.counters / self.pwm_hz


class Source(Protocol):
    """What a stream asks of the drive that it comes from."""

    link: Link
    streaming: Stream | None

    def try_again(self) -> bool: ...

    def stop_stream(self, stream: Stream) -> None: ...


class Stream:
    """Open until closed; iterate over its blocks, or `read` them. One thread reads a stream."""

    def __init__(self, drive: Source, names: tuple[str, ...], decimation: int, pwm_hz: float) -> None:
        self.names = names
        self.decimation = decimation
        self.pwm_hz = pwm_hz
        self.rows = 0
        self.lost_rows = 0  # all gaps...
        self.lost_frames = 0  # of which these frames were lost in transit
        self.dropped_blocks = 0  # not taken in time by the program
        self.reconnects = 0
        self._drive = drive
        self._blocks: deque[Block] = deque()
        self._guard = threading.Lock()
        self._config: int | None = None
        self._early: list[bytes] = []  # frames that came before the drive's answer was read
        self._frame: int | None = None
        self._next: int | None = None  # counter that the next row should have
        self._turns = 0  # of the counter

    def __enter__(self) -> Stream:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __iter__(self) -> Iterator[Block]:
        """Blocks until the stream is closed."""
        while self._drive.streaming is self:
            block = self.read()
            if block is not None:
                yield block

    def read(self, timeout_s: float = 0.5) -> Block | None:
        """The next block; None: none came in this time."""
        try:
            if not self._drive.link.wait(lambda: bool(self._blocks), timeout_s):
                return None
        except LinkLostError:
            if not self._drive.try_again():
                raise
            self.reconnects += 1
            return None
        with self._guard:
            return self._blocks.popleft()

    def read_rows(self, rows: int, timeout_s: float = 2.0) -> NDArray[np.float32]:
        """So many rows at least, without a gap, or a LostSamplesError."""
        found: list[NDArray[np.float32]] = []
        count = 0
        while count < rows:
            block = self.read(timeout_s)
            if block is None:
                raise LostSamplesError(f"stream: no rows for {timeout_s:g} s; is it configured?")
            if block.lost_before and found:
                raise LostSamplesError(f"stream: {block.lost_before} rows were lost; lower the rate or the signals")
            found.append(block.values)
            count += len(block)
        return np.concatenate(found)

    def close(self) -> None:
        self._drive.stop_stream(self)

    def configuring(self) -> None:
        """The drive is about to be asked: keep what comes until its answer says which frames are ours."""
        with self._guard:
            self._config, self._frame, self._next = None, None, None
            self._early.clear()

    def configured(self, config: int) -> None:
        """The drive marks its frames with this number from now on."""
        with self._guard:
            self._config = config
            early, self._early = self._early, []
            for payload in early:
                self._sort(payload)

    def take(self, payload: bytes) -> None:
        """A frame of the drive. Called by whoever reads the link."""
        with self._guard:
            if self._config is None:
                self._early.append(payload)
            else:
                self._sort(payload)

    def _sort(self, payload: bytes) -> None:
        if len(payload) < HEAD.size:
            return
        config, rows, frame, counter = HEAD.unpack_from(payload)
        count = len(self.names)
        if config != self._config or len(payload) != HEAD.size + 4 * rows * count:
            return
        if self._frame is not None:
            self.lost_frames += (frame - self._frame - 1) & 0xFFFF
        self._frame = frame
        values = np.frombuffer(payload, "<f4", offset=HEAD.size).reshape(rows, count)
        lost = 0
        if self._next is not None:
            lost = ((counter - self._next) & (COUNTER_MODULUS - 1)) // self.decimation
            if counter < self._next and lost < COUNTER_MODULUS // 2:
                self._turns += 1
        self._next = (counter + rows * self.decimation) & (COUNTER_MODULUS - 1)
        self.rows += rows
        self.lost_rows += lost
        whole = counter + self._turns * COUNTER_MODULUS
        if len(self._blocks) >= QUEUE_BLOCKS:
            gone = self._blocks.popleft()
            self.dropped_blocks += 1
            self.lost_rows += len(gone)
        self._blocks.append(Block(whole, self.decimation, self.pwm_hz, values, lost))
