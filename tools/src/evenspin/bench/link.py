"""Requests and answers over a transport, and what the drive sends by itself.

Real transports are read by a thread of the link; requests may then come from any thread, one at a time. Over a lockstep
transport there is no thread: whoever waits reads, and time passes only then.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator, Sequence

from evenspin.bench.errors import LinkLostError, NoDeviceError
from evenspin.bench.frames import Decoder, Frame, encode
from evenspin.bench.messages import ANSWER, EVENT, REFUSAL, STREAM, Ask
from evenspin.bench.transport import Transport

ANSWER_S = 0.25
SLOW_ANSWER_S = 2.0
TRIES = 4
UNDER_WAY = 3  # of 4 requests that the drive takes at once; one is left for the sign of life
ALIVE_S = 0.1
POLL_S = 0.02

Listener = Callable[[bytes], None]  # is called by whoever reads, and must not ask the drive


class Link:
    """`on_stream` and `on_event` get payloads."""

    def __init__(self, transport: Transport, on_stream: Listener, on_event: Listener) -> None:
        self.transport = transport
        self.keep_alive = False
        self._on_stream, self._on_event = on_stream, on_event
        self._decoder = Decoder()
        self._asking = threading.RLock()
        self._writing = threading.Lock()
        self._news = threading.Condition()
        self._answers: dict[int, Frame | None] = {}  # by number; None: not here yet
        self._seq = 0
        self._last_sent_s = transport.clock()
        self._lost: LinkLostError | None = None
        self._closing = False
        self._reader: threading.Thread | None = None
        self._write(b"\x00")  # what stood on the line before must not spoil the first frame
        if not transport.lockstep:
            self._reader = threading.Thread(target=self._read_on, name=f"link {transport.name}", daemon=True)
            self._reader.start()

    @property
    def bad_frames(self) -> int:
        return self._decoder.bad

    @property
    def lost(self) -> bool:
        return self._lost is not None

    def ask(self, kind: Ask, payload: bytes = b"", timeout_s: float = ANSWER_S) -> Frame:
        """One request; the answer, which may be a refusal."""
        return next(iter(self.ask_all([(kind, payload)], timeout_s)))

    def ask_at_once(self, kind: Ask, payload: bytes = b"", timeout_s: float = ANSWER_S) -> Frame:
        """`ask` past the requests of other threads: for what must not wait, such as a stop. It is one
        request more in flight than the drive promises to hold; if it finds no room it is asked again."""
        return self._answer(self._send(kind, payload), kind, payload, timeout_s)

    def ask_all(self, requests: Sequence[tuple[Ask, bytes]], timeout_s: float = ANSWER_S) -> Iterator[Frame]:
        """Several requests, as many in flight as the drive takes; the answers in the order of the requests."""
        with self._asking:
            under_way: list[tuple[int, Ask, bytes]] = []
            for kind, payload in requests:
                if len(under_way) == UNDER_WAY:
                    yield self._answer(*under_way.pop(0), timeout_s)
                under_way.append((self._send(kind, payload), kind, payload))
            while under_way:
                yield self._answer(*under_way.pop(0), timeout_s)

    def wait(self, arrived: Callable[[], bool], timeout_s: float) -> bool:
        """Until something is true that a listener changes; whether it is."""
        clock = self.transport.clock
        until_s = clock() + timeout_s
        while not arrived():
            remaining_s = until_s - clock()
            if self._lost is not None:
                raise self._lost
            if remaining_s <= 0.0:
                return False
            if self._reader is None:
                self._read_once(min(remaining_s, POLL_S))
            else:
                with self._news:
                    if not arrived() and self._lost is None:
                        self._news.wait(min(remaining_s, 0.5))
        return True

    def close(self) -> None:
        self._closing = True
        if self._reader is not None and self._reader is not threading.current_thread():
            self._reader.join(1.0)
        with contextlib.suppress(OSError, LinkLostError):
            self.transport.close()

    # ---- sending

    def _send(self, kind: Ask, payload: bytes) -> int:
        with self._news:
            self._seq = (self._seq + 1) & 0xFF
            seq = self._seq
            self._answers[seq] = None
        self._write(encode(Frame(kind, seq, payload)))
        return seq

    def _write(self, octets: bytes) -> None:
        if self._lost is not None:
            raise self._lost
        with self._writing:
            self.transport.write(octets)
            self._last_sent_s = self.transport.clock()

    def _answer(self, seq: int, kind: Ask, payload: bytes, timeout_s: float) -> Frame:
        """Ask again when nothing comes; an answer that was only late is as good."""
        asked = [seq]

        def arrived() -> Frame | None:
            return next((frame for seq in asked if (frame := self._answers.get(seq)) is not None), None)

        try:
            for tries in range(TRIES):
                if self.wait(lambda: arrived() is not None, timeout_s):
                    frame = arrived()
                    assert frame is not None
                    return frame
                if tries + 1 < TRIES:
                    asked.append(self._send(kind, payload))
        finally:
            for seq in asked:
                self._answers.pop(seq, None)
        raise NoDeviceError(
            f"{self.transport.name}: no answer to {kind.name.lower()}, asked {TRIES} times; is it an evenspin drive, "
            "switched on, at the right baud rate, and the line not overloaded?"
        )

    # ---- reading

    def _read_on(self) -> None:
        while not self._closing:
            try:
                self._read_once(POLL_S)
            except LinkLostError as error:
                self._lose(error)
                return
            except Exception as error:  # a transport that breaks in an unknown way is a broken transport
                if not self._closing:
                    self._lose(LinkLostError(f"{self.transport.name}: the link is lost ({error})"))
                return

    def _lose(self, error: LinkLostError) -> None:
        with self._news:
            self._lost = error
            self._news.notify_all()

    def _read_once(self, timeout_s: float) -> None:
        try:
            octets = self.transport.read(timeout_s)
            if self.keep_alive and self.transport.clock() - self._last_sent_s >= ALIVE_S:
                with self._news:
                    self._seq = (self._seq + 1) & 0xFF
                    seq = self._seq
                self._write(encode(Frame(Ask.ALIVE, seq, b"")))
        except LinkLostError as error:
            self._lost = error
            raise
        if octets:
            self._sort(self._decoder.feed(octets))

    def _sort(self, frames: Sequence[Frame]) -> None:
        for frame in frames:
            if frame.type == STREAM:
                self._on_stream(frame.payload)
            elif frame.type == EVENT:
                self._on_event(frame.payload)
            elif (frame.type == REFUSAL or frame.type & ANSWER) and frame.seq in self._answers:
                self._answers[frame.seq] = frame
        with self._news:
            self._news.notify_all()
