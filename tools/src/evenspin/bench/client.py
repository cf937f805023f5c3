"""A drive as an object: connect, read, tune, run, record. What a person at a bench does, one call each.

    with Drive.connect("/dev/ttyUSB0") as drive:
        drive.set({"speed_kp_a_per_unit": 0.04})
        with drive.stream(("speed_rad_s", "iq_a"), rate_hz=1000.0) as stream:
            drive.run_speed(30.0)
            for block in stream:
                ...

Leaving the `with` stops the motor, whatever the reason was. Requests may come from several threads; a stream is read by
one. The first thing that is not as it should be is an EvenspinError of `bench.errors`.
"""

from __future__ import annotations

import contextlib
import signal
import struct
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.bench import messages
from evenspin.bench.errors import DriveFaultError, LinkLostError, NoDeviceError, ReadOnlyError, RefusedError
from evenspin.bench.frames import Frame
from evenspin.bench.link import SLOW_ANSWER_S, Link
from evenspin.bench.messages import REFUSAL, Ask, CaptureState, DriveState, Event, FaultState, Info, Reader, Timing
from evenspin.bench.numbers import CaptureStatus, Excite, Flag, Mode, ResetCause, State, Trigger
from evenspin.bench.ports import choose_port, open_transport
from evenspin.bench.schema import Schema, own_schema
from evenspin.bench.stream import Stream
from evenspin.bench.transport import Transport
from evenspin.errors import EvenspinError, InputError, NativeError
from evenspin.native import Fault, Field

GET_AT_ONCE = 60
SET_AT_ONCE = 40
READ_AT_ONCE = 48
VALUES_AT_ONCE = 60
BEGIN, COMMIT = 1, 2
BUSY_S = 1.0
STORAGE_COMMANDS = frozenset({"save", "restore", "defaults", "learn_clear", "learn_save", "learn_restore"})
START_S = 120.0  # calibration, a shaft that runs out and the alignment may come first
AGAIN_S = 0.2
CAPTURES, BLACK_BOX = 0, 1  # recorders

OnEvent = Callable[[Event], None]


@dataclass(frozen=True, slots=True)
class Capture:
    """Rows at the full rate from the RAM of the drive. Row `pre` is at the trigger, or the first one after it."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: NDArray[np.float32]
    first: int  # PWM period of row 0
    trigger: int  # PWM period of the trigger
    decimation: int
    pre: int
    pwm_hz: float

    @property
    def counters(self) -> NDArray[np.int64]:
        return self.first + self.decimation * np.arange(len(self.values), dtype=np.int64)

    @property
    def t_s(self) -> NDArray[np.float64]:
        """Time from the trigger."""
        return (self.counters - self.trigger) / self.pwm_hz

    def __getitem__(self, name: str) -> NDArray[np.float32]:
        return self.values[:, self.names.index(name)]


@dataclass(frozen=True, slots=True)
class FaultReport:
    """Why the drive switched off, and its last samples. `name` is "none" when it never did."""

    number: int
    name: str
    cause: str
    check: str
    detail: str  # the parameter that was refused, the pole pairs that an alignment has seen, the wait, or ""
    period: int  # in which it was found
    text: str
    last_samples: Capture | None
    before_reset: str  # what was before the last reset, in one line; "" when nothing is known of it


class Drive:
    """A connected drive. Made by `connect`."""

    def __init__(self, transport: Transport, port: str, reconnect_s: float, on_event: OnEvent | None) -> None:
        self.port = port
        self.reconnect_s = reconnect_s
        self.streaming: Stream | None = None
        self.on_event = on_event
        self.events: list[Event] = []
        self._guard = threading.RLock()
        self._closed = False
        self._open(transport)

    @classmethod
    def connect(cls, port: str | None = None, *, reconnect_s: float = 0.0, on_event: OnEvent | None = None) -> Drive:
        """Open a port (None: the only one there is) and greet the drive.

        `reconnect_s`: how long to search for a drive that was unplugged; what was asked is then asked again, except
        to start. `on_event` is called when state or fault change, by the thread that reads: it must not ask.
        """
        name = choose_port(port)
        return cls(open_transport(name), name, reconnect_s, on_event)

    def _open(self, transport: Transport) -> None:
        self.link = Link(transport, self._take_rows, self._take_event)
        try:
            self.info = self._hello(own_schema().hash)
            own = self.info.schema == own_schema().hash
            self.schema: Schema = own_schema() if own else self._read_lists()
        except BaseException:
            self.link.close()
            raise
        self.read_only_reason = "" if self.info.may_write else self._why_read_only(own)

    def _hello(self, schema: int) -> Info:
        frame = self.link.ask(Ask.HELLO, struct.pack("<HI", messages.VERSION, schema))
        if frame.type == REFUSAL:
            raise messages.refusal(frame.payload, "hello", None)
        return Info.parse(frame.payload)

    def _why_read_only(self, own: bool) -> str:
        if self.info.version != messages.VERSION:
            return f"the drive talks version {self.info.version} of the protocol, this package {messages.VERSION}"
        if not own:
            return (
                f"the firmware was built from other lists of parameters and signals (hash {self.info.schema:08x}, "
                f"this package has {own_schema().hash:08x}): install the package of the firmware's version, "
                "or flash the firmware of this package"
            )
        return "the drive does not allow it"

    def _read_lists(self) -> Schema:
        entries: list[list[Any]] = []
        for kind, count in enumerate(self.info.counts):
            found: list[Any] = []
            while len(found) < count:
                payload = self._ask(Ask.LIST, struct.pack("<BH", kind, len(found)), "list").payload
                got = messages.parse_list(kind, payload[3], payload[4:])
                if not got:
                    raise NoDeviceError(f"{self.port}: the drive's lists end early; is it an evenspin drive?")
                found += got
            entries.append(found)
        parameters, signals, faults, commands = entries
        faults = [self._explained_fault(number, fault.name) for number, fault in enumerate(faults)]
        return Schema({f.name: f for f in parameters}, {f.name: f for f in signals}, tuple(faults), tuple(commands))

    def _explained_fault(self, number: int, name: str) -> Fault:
        """With the drive's own words; a firmware that carries none is explained in those of this package."""
        try:
            return Fault(name, self._text(2, number, 0), self._text(2, number, 1))
        except RefusedError:
            known = next((fault for fault in own_schema().faults if fault.name == name), None)
            return known or Fault(name, "", "")

    def _text(self, kind: int, index: int, part: int) -> str:
        octets = b""
        while True:
            request = struct.pack("<BHBH", kind, index, part, len(octets))
            read = Reader(self._ask(Ask.TEXT, request, "text").payload)
            *_, total = read.take("BHBHH")
            more = read.rest()
            octets += more
            if len(octets) >= total or not more:
                return octets.decode("ascii", "replace")

    # ---- leaving

    def __enter__(self) -> Drive:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop the motor, then hang up. A second Ctrl-C does not get in between."""
        if self._closed:
            return
        self._closed = True
        with _undisturbed():
            with contextlib.suppress(EvenspinError):
                if self.info.may_write and not self.link.lost:
                    self._command("disarm")
                    if self.streaming is not None:
                        self.stop_stream(self.streaming)
            self.link.close()

    def try_again(self) -> bool:
        """After the link was lost: search for the drive until `reconnect_s` have passed. The motor has stopped by then,
        and nothing starts it again but the caller."""
        if self.reconnect_s <= 0.0 or self._closed:
            return False
        with self._guard:
            if not self.link.lost:
                return True  # another thread was quicker
            self.link.close()
            until_s = time.monotonic() + self.reconnect_s
            while time.monotonic() < until_s:
                try:
                    self._open(open_transport(self.port))
                except (NoDeviceError, OSError):
                    time.sleep(AGAIN_S)
                    continue
                if self.streaming is not None:
                    self._configure(self.streaming)
                return True
            return False

    # ---- asking

    def _ask(self, kind: Ask, payload: bytes, what: str, timeout_s: float = 0.25) -> Frame:
        try:
            frame = self.link.ask(kind, payload, timeout_s)
        except LinkLostError:
            if not self.try_again():
                raise
            frame = self.link.ask(kind, payload, timeout_s)
        if frame.type == REFUSAL:
            raise messages.refusal(frame.payload, what, getattr(self, "schema", None))
        return frame

    def _ask_all(self, requests: Sequence[tuple[Ask, bytes]], what: str) -> Iterator[Frame]:
        for frame in self.link.ask_all(requests):
            if frame.type == REFUSAL:
                raise messages.refusal(frame.payload, what, self.schema)
            yield frame

    def _need_write(self, what: str) -> None:
        if not self.info.may_write:
            raise ReadOnlyError(f"{what}: this drive can only be read: {self.read_only_reason}")

    # ---- reading

    @property
    def parameters(self) -> Mapping[str, Field]:
        """Name, unit, kind, range and default of every parameter."""
        return self.schema.parameters

    @property
    def signals(self) -> Mapping[str, Field]:
        return self.schema.signals

    def state(self) -> DriveState:
        return DriveState.parse(self._ask(Ask.STATE, b"", "state").payload)

    def read(self, names: Sequence[str]) -> dict[str, float]:
        """Signals now, each by itself; values of one instant come from `stream` and `capture`."""
        numbers = self.schema.signal_numbers(names)
        found: list[float] = []
        for part in _parts(numbers, READ_AT_ONCE):
            payload = self._ask(Ask.READ, struct.pack(f"<B{len(part)}H", len(part), *part), "read").payload
            found += Reader(payload[5:]).take(f"{len(part)}f")
        return dict(zip(names, found, strict=True))

    def timing(self, *, reset: bool = False) -> Timing:
        return Timing.parse(self._ask(Ask.TIMING, bytes((reset,)), "timing").payload)

    def document(self, name: str) -> str:
        """What a parameter or signal is, in the words of the firmware."""
        if name in self.schema.parameters:
            return self._text(0, self.schema.parameter_index[name], 0)
        return self._text(1, self.schema.signal_numbers([name])[0], 0)

    # ---- parameters

    def get(self, names: Sequence[str] | None = None) -> dict[str, float]:
        """Parameters in force; None: all of them."""
        if names is None:
            return dict(zip(self.schema.parameters, self._get_range(0, len(self.schema.parameters)), strict=True))
        found = {}
        for name in names:
            self.schema.parameter(name)
            found[name] = self._get_range(self.schema.parameter_index[name], 1)[0]
        return found

    def _get_range(self, first: int, count: int) -> list[float]:
        requests = [
            (Ask.GET, struct.pack("<HB", at, min(GET_AT_ONCE, first + count - at)))
            for at in range(first, first + count, GET_AT_ONCE)
        ]
        found: list[float] = []
        for frame in self._ask_all(requests, "get"):
            number = frame.payload[2]
            found += Reader(frame.payload[3:]).take(f"{number}f")
        return found

    def set(self, values: Mapping[str, float]) -> dict[str, float]:
        """Take over all of them between two samples of the current loop, or none. Returns them as they are held."""
        self._need_write("set")
        for name, value in values.items():
            check_value(self.schema.parameter(name), value)
        if not values:
            return {}
        pairs = [(self.schema.parameter_index[name], float(value)) for name, value in values.items()]
        parts = list(_parts(pairs, SET_AT_ONCE))
        until_s = self.link.transport.clock() + BUSY_S
        while True:
            try:
                held: list[float] = []
                for number, part in enumerate(parts):
                    flags = (BEGIN if number == 0 else 0) | (COMMIT if number + 1 == len(parts) else 0)
                    octets = b"".join(struct.pack("<Hf", *pair) for pair in part)
                    payload = self._ask(Ask.SET, bytes((flags, len(part))) + octets, "set").payload
                    held += Reader(payload[2:]).take(f"{len(part)}f")
                return dict(zip(values, held, strict=True))
            except RefusedError as error:
                if error.parameter:
                    raise self._explained(error, values) from None
                if not error.busy or self.link.transport.clock() > until_s:
                    raise
                self.sleep(0.005)

    def _explained(self, error: RefusedError, values: Mapping[str, float]) -> RefusedError:
        from evenspin.bench.refusals import why_not

        try:
            now, numeric = self.state(), self.info.numeric
            text = why_not(self.parameters, self.get(), values, error.parameter, state=now, numeric=numeric)
        except NativeError:  # firmware of another kind than this computer has
            return error
        refused = RefusedError(text, "set")
        refused.parameter = error.parameter
        return refused

    def save(self) -> None:
        """Keep the parameters over a power cycle."""
        self._command("save")

    def restore(self) -> None:
        self._command("restore")

    def defaults(self) -> None:
        self._command("defaults")

    # ---- moving

    def command(self, name: str) -> State:
        """Any command of the protocol by its name."""
        return self._command(name)

    def _command(self, name: str) -> State:
        number = list(self.schema.commands).index(name)
        if name not in ("stop", "disarm", "clear_fault"):
            self._need_write(name)
        slow = SLOW_ANSWER_S if name in STORAGE_COMMANDS else 0.25
        payload = self._ask(Ask.COMMAND, struct.pack("<H", number), name, slow).payload
        if name in ("stop", "disarm"):
            self.link.keep_alive = False
        return State(payload[2])

    def set_timeout(self, milliseconds: int) -> None:
        """Silence after which the drive stops, for this session; 0: never. 500 after every connect."""
        self._need_write("timeout")
        self._ask(Ask.TIMEOUT, struct.pack("<H", milliseconds), "timeout")

    def setpoint(
        self,
        mode: Mode = Mode.SPEED,
        *,
        speed_rad_s: float = 0.0,
        id_a: float = 0.0,
        iq_a: float = 0.0,
        turns: int = 0,
        angle_rad: float = 0.0,
    ) -> int:
        """What the drive shall do while it runs, taken over as a whole. Returns the counter."""
        self._need_write("setpoint")
        payload = struct.pack("<Bfffif", mode, speed_rad_s, id_a, iq_a, turns, angle_rad)
        return int(Reader(self._ask(Ask.SETPOINT, payload, "setpoint").payload).take("I")[0])

    def torque(self, *, speed_limit_rad_s: float, torque_nm: float | None = None, iq_a: float | None = None) -> int:
        """A torque, in N m of the motor or as the q current that makes it with no d current, as long as the speed stays
        within `speed_limit_rad_s` in both directions. N m count by the drive's pole_pairs and motor_psi_wb. Returns
        the counter.

        Example: `drive.torque(torque_nm=0.05, speed_limit_rad_s=100.0)`
        """
        if (torque_nm is None) == (iq_a is None):
            raise InputError(
                "torque", "torque_nm", torque_nm, "given without iq_a, or iq_a without it", "give one of the two"
            )
        if not speed_limit_rad_s >= 0.0:
            raise InputError(
                "torque", "speed_limit_rad_s", speed_limit_rad_s, "0 or more", "the limit acts in both directions"
            )
        if iq_a is None:
            assert torque_nm is not None
            motor = self.get(("pole_pairs", "motor_psi_wb"))
            iq_a = torque_nm / (1.5 * motor["pole_pairs"] * motor["motor_psi_wb"])
        return self.setpoint(Mode.TORQUE, speed_rad_s=speed_limit_rad_s, iq_a=iq_a)

    def excite(self, place: Excite, amplitude: float = 0.0, hz: float = 0.0) -> float:
        """Add a sine of `amplitude` (A of q current, rad/s) to the torque or the speed reference of the running drive;
        `Excite.NONE` ends it, and so does a set-point, a stop, a fault. Returns the frequency that it has, in Hz."""
        self._need_write("excite")
        payload = struct.pack("<Bff", place, amplitude, hz)
        return float(Reader(self._ask(Ask.EXCITE, payload, "excite").payload).take("If")[1])

    def start(self, *, wait: bool = True, progress: Callable[[State], None] | None = None) -> None:
        """Arm and start. The motor moves from here on. `wait`: until it runs; a fault is a DriveFaultError."""
        self._need_write("start")
        self._command("arm")
        self.link.keep_alive = True  # before the start: the timeout runs from it on
        try:
            self._command("start")
            if wait:
                self._await_run(progress)
        except BaseException:
            self.link.keep_alive = False
            raise

    def _await_run(self, progress: Callable[[State], None] | None) -> None:
        clock = self.link.transport.clock
        until_s, seen = clock() + START_S, False
        while clock() < until_s:
            now = self.state()
            if now.state == State.RUN and seen:
                return
            seen = now.state == State.RUN  # read twice: what protects a running bridge trips in its first period
            if now.state == State.FAULT:
                raise DriveFaultError(messages.fault_text(self.schema, now.fault, now.detail))
            if progress is not None:
                progress(now.state)
            self.sleep(0.002)
        raise DriveFaultError(f"start: not running after {START_S:g} s; the state is {now.state.name.lower()}")

    def find_zero(self) -> None:
        """Where the electrical zero is not known, start once without torque, so that the drive aligns, and stop: the
        shaft may then be locked, or its motion watched."""
        if self.state().flags & Flag.STARTED_UP:
            return
        self.setpoint(Mode.CURRENT)
        self.start()
        self.stop()

    def run_speed(self, speed_rad_s: float) -> None:
        """Start, if it does not run, and turn at this speed."""
        self.setpoint(Mode.SPEED, speed_rad_s=speed_rad_s)
        if self.state().state != State.RUN:
            self.start()

    def stop(self) -> None:
        """End the run as the drive's `stop_action` says, by default at once and coasting; a second stop is at once."""
        self._command("stop")

    def stop_at_once(self) -> None:
        """Stop and disarm, past a request of another thread that takes long, such as fetching a capture; a start that
        in transit then finds the drive disarmed. Over a lost link it is a LinkLostError at once: the drive stops by
        its own timeout."""
        self.link.keep_alive = False
        frame = self.link.ask_at_once(Ask.COMMAND, struct.pack("<H", list(self.schema.commands).index("disarm")))
        if frame.type == REFUSAL:
            raise messages.refusal(frame.payload, "stop", self.schema)

    def clear_fault(self) -> None:
        self._command("clear_fault")

    def sleep(self, seconds: float) -> None:
        """Wait by the clock of the drive; signs of life go on."""
        self.link.wait(lambda: False, seconds)

    # ---- streaming

    def stream(self, names: Sequence[str], *, rate_hz: float = 1000.0) -> Stream:
        """Rows of these signals, evenly spaced at a whole part of the PWM frequency. There is one stream at a time: a
        new one ends the one before."""
        decimation = max(1, round(self.info.pwm_hz / rate_hz)) if rate_hz > 0.0 else 0
        if not decimation or abs(self.info.pwm_hz / decimation - rate_hz) > 0.01 * rate_hz:
            hint = f"for example {self.info.pwm_hz / 10:g} or {self.info.pwm_hz / 5:g}"
            raise InputError("bench", "rate", rate_hz, f"{self.info.pwm_hz} Hz over a whole number", hint)
        if not 1 <= len(names) <= self.info.stream_signals:
            must = f"1 to {self.info.stream_signals} names"
            raise InputError("bench", "signals", len(names), must, "leave some out")
        self.schema.signal_numbers(names)
        stream = Stream(self, tuple(names), decimation, float(self.info.pwm_hz))
        self._configure(stream)
        return stream

    def _configure(self, stream: Stream) -> None:
        numbers = self.schema.signal_numbers(stream.names)
        payload = struct.pack(f"<HBB{len(numbers)}H", stream.decimation, 0, len(numbers), *numbers)
        stream.configuring()
        self.streaming = stream
        stream.configured(self._ask(Ask.STREAM_CONFIGURE, payload, "stream").payload[0])

    def stop_stream(self, stream: Stream) -> None:
        if self.streaming is stream:
            self.streaming = None
            self._ask(Ask.STREAM_CONFIGURE, struct.pack("<HBB", 1, 0, 0), "stream")

    def _take_rows(self, payload: bytes) -> None:
        stream = self.streaming
        if stream is not None:
            stream.take(payload)

    def _take_event(self, payload: bytes) -> None:
        event = Event.parse(payload)
        self.events.append(event)
        if event.state == State.FAULT:
            self.link.keep_alive = False
        if self.on_event is not None:
            self.on_event(event)

    # ---- capture

    def arm_capture(
        self,
        names: Sequence[str],
        *,
        rows: int,
        pre: int = 0,
        trigger: Trigger = Trigger.IMMEDIATE,
        signal_name: str | None = None,
        level: float = 0.0,
        decimation: int = 1,
    ) -> int:
        """Start recording at the full rate; `rows` with `pre` of them before the trigger. Returns the rows.

        Comes back when the rows before the trigger are there: what happens from now on is seen.
        """
        if not 1 <= len(names) <= self.info.recorder_signals:
            must = f"1 to {self.info.recorder_signals} names"
            raise InputError("bench", "signals", len(names), must, "leave some out")
        most = self.capture_rows(len(names))
        if not pre < rows <= most or pre < 0:
            must = f"more than the {pre} before the trigger, and at most {most} for {len(names)} signals"
            raise InputError("bench", "rows", rows, must, "fewer rows, fewer signals, or a larger decimation")
        numbers = self.schema.signal_numbers(names)
        watched = self.schema.signal_numbers([signal_name])[0] if signal_name else 0
        payload = struct.pack("<BHHHBHfB", CAPTURES, decimation, pre, rows - pre, trigger, watched, level, len(numbers))
        payload += struct.pack(f"<{len(numbers)}H", *numbers)
        answer = self._ask(Ask.CAPTURE_CONFIGURE, payload, "capture").payload
        if pre > 0:
            self.sleep(pre * decimation / self.info.pwm_hz)
            while self.capture_state().status == CaptureStatus.FILLING_PRE:
                self.sleep(0.002)
        return int(Reader(answer).take("BBH")[2])

    def capture_rows(self, signals: int) -> int:
        """How many rows of so many signals fit."""
        return min(65535, self.info.recorder_values[CAPTURES] // signals)

    def capture_state(self, recorder: int = CAPTURES) -> CaptureState:
        return CaptureState.parse(self._ask(Ask.CAPTURE_STATUS, bytes((recorder,)), "capture").payload)

    def trigger_capture(self) -> None:
        self._ask(Ask.CAPTURE_CONTROL, bytes((CAPTURES, 1)), "capture")

    def read_capture(
        self, timeout_s: float = 10.0, recorder: int = CAPTURES, progress: Callable[[float], None] | None = None
    ) -> Capture:
        """Wait until it is complete and fetch it; `progress` gets the part that has arrived, 0 to 1."""
        clock = self.link.transport.clock
        until_s = clock() + timeout_s
        state = self.capture_state(recorder)
        while state.status != CaptureStatus.COMPLETE:
            if clock() > until_s or state.status in (CaptureStatus.NEVER, CaptureStatus.STOPPED):
                raise RefusedError(
                    f"capture: not complete after {timeout_s:g} s ({state.status.name.lower()}, {state.done} of "
                    f"{state.rows} rows); is the trigger level ever reached?"
                )
            self.sleep(0.005)
            state = self.capture_state(recorder)
        count = len(state.signals)
        total = state.rows * count
        requests = [
            (Ask.CAPTURE_READ, struct.pack("<BIB", recorder, at, min(VALUES_AT_ONCE, total - at)))
            for at in range(0, total, VALUES_AT_ONCE)
        ]
        octets = bytearray()
        for frame in self._ask_all(requests, "capture"):
            octets += frame.payload[7:]
            if progress is not None:
                progress(len(octets) / (4.0 * total))
        values = np.frombuffer(bytes(octets), "<f4").reshape(state.rows, count)
        every = list(self.schema.signals.values())
        chosen = [every[number] for number in state.signals]
        return Capture(
            tuple(field.name for field in chosen), tuple(field.unit for field in chosen), values, state.first,
            state.trigger_counter, state.decimation, state.pre, float(self.info.pwm_hz),
        )  # fmt: skip

    def capture(self, names: Sequence[str], *, rows: int, timeout_s: float = 10.0, **options: Any) -> Capture:
        """`arm_capture` and `read_capture`."""
        self.arm_capture(names, rows=rows, **options)
        return self.read_capture(timeout_s)

    # ---- faults

    def fault(self, *, samples: bool = True) -> FaultReport:
        """The last fault, also when it was cleared, with the samples before it."""
        found = FaultState.parse(self._ask(Ask.FAULT, b"", "fault").payload)
        known = self.schema.fault(found.fault)
        names = list(self.schema.parameters)
        culprit = messages.fault_detail(names, known.name, found.detail)
        past = found.past
        recorded = found.fault != 0 or (past is not None and past.rows)
        frozen = samples and recorded and found.status == CaptureStatus.COMPLETE
        return FaultReport(
            found.fault, known.name, known.cause, known.check, culprit, found.since,
            messages.fault_text(self.schema, found.fault, found.detail),
            self.read_capture(recorder=BLACK_BOX) if frozen else None,
            self._past_text(past) if past is not None else "",
        )  # fmt: skip

    def _past_text(self, past: messages.PastRun) -> str:
        """What was before the last reset, in one line."""
        cause = ResetCause.of(self.state().flags).name.lower().replace("_", " ")
        count = "the last reset" if past.resets == 1 else f"the {past.resets} last resets"
        after = f"{past.periods / self.info.pwm_hz:.3f} s after it had started"
        fault = messages.fault_text(self.schema, past.fault, past.detail)
        rows = "; the samples are its last ones" if past.rows else ""
        return f"before {count} ({cause}): the drive was in {past.state.name.lower()} {after}, {fault}{rows}"

    def need_no_fault(self) -> None:
        """A DriveFaultError when it has tripped."""
        now = self.state()
        if now.state == State.FAULT:
            raise DriveFaultError(messages.fault_text(self.schema, now.fault, now.detail))


def check_value(field: Field, value: float) -> None:
    """Refuse what the drive would refuse, with its limits."""
    whole = field.kind != "float"
    if not field.minimum <= value <= field.maximum or (whole and value != int(value)):
        raise InputError("bench", field.name, value, field.allowed(), "`evenspin parameters` lists the ranges")


def parse_value(field: Field, word: str) -> float:
    """A value as a person writes it: a number, a word of a choice, true or false."""
    if field.kind == "choice" and word in field.choices:
        return float(field.choices.index(word))
    if field.kind == "flag" and word.lower() in ("true", "false"):
        return float(word.lower() == "true")
    try:
        value = float(word)
    except ValueError:
        hint = "`evenspin parameters` lists the ranges"
        raise InputError("bench", field.name, word, field.allowed(), hint) from None
    check_value(field, value)
    return value


def _parts(items: Sequence[Any], size: int) -> Iterator[Sequence[Any]]:
    for at in range(0, len(items), size):
        yield items[at : at + size]


@contextlib.contextmanager
def _undisturbed() -> Iterator[None]:
    """Ctrl-C waits until the motor has been stopped."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
