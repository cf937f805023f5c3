"""The messages of docs/protocol.md as Python values. Nothing here talks to anybody."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from evenspin.bench.errors import NoDeviceError, ReadOnlyError, RefusedError
from evenspin.bench.numbers import CaptureStatus, Flag, Mode, Numeric, State, Trigger, unknown
from evenspin.bench.schema import AT_REST, KINDS, NO_FAULT, Schema
from evenspin.native import Fault, Field

VERSION = 1
ANSWER = 0x80
REFUSAL = 0xFF
COUNTER_MODULUS = 1 << 32


class Ask(IntEnum):
    """Requests."""

    HELLO = 0x01
    LIST = 0x02
    TEXT = 0x03
    STATE = 0x04
    READ = 0x05
    GET = 0x10
    SET = 0x11
    COMMAND = 0x20
    SETPOINT = 0x21
    ALIVE = 0x22
    TIMEOUT = 0x23
    EXCITE = 0x24
    STREAM_CONFIGURE = 0x30
    CAPTURE_CONFIGURE = 0x31
    CAPTURE_STATUS = 0x32
    CAPTURE_READ = 0x33
    CAPTURE_CONTROL = 0x34
    FAULT = 0x35
    TIMING = 0x36


STREAM, EVENT = 0x40, 0x41  # what the drive sends by itself


class Reader:
    """Reads a payload field by field, from its start to its end."""

    def __init__(self, payload: bytes) -> None:
        self._payload = payload
        self._at = 0

    def take(self, layout: str) -> tuple[Any, ...]:
        layout = f"<{layout}"
        if self._at + struct.calcsize(layout) > len(self._payload):
            raise NoDeviceError(f"an answer of {len(self._payload)} octets ends early; is it an evenspin drive?")
        values = struct.unpack_from(layout, self._payload, self._at)
        self._at += struct.calcsize(layout)
        return values

    def text(self) -> str:
        (length,) = self.take("B")
        octets = self._payload[self._at : self._at + length]
        self._at += length
        return octets.decode("ascii", "replace")

    def rest(self) -> bytes:
        return self._payload[self._at :]


@dataclass(frozen=True, slots=True)
class Info:
    """What the drive reports about itself on connection."""

    version: int
    schema: int
    may_write: bool
    numeric: str
    pwm_hz: int
    cpu_hz: int
    counts: tuple[int, int, int, int]  # parameters, signals, faults, commands
    stream_signals: int
    recorder_signals: int
    recorder_values: tuple[int, ...]
    has_storage: bool
    timeout_ms: int
    counter: int
    name: str
    firmware: str

    @classmethod
    def parse(cls, payload: bytes) -> Info:
        read = Reader(payload)
        version, schema, may_write, numeric, pwm_hz, cpu_hz, _ = read.take("HIBBIIH")
        counts = read.take("HHHH")
        stream_signals, recorder_signals, recorders = read.take("BBB")
        values = read.take(f"{recorders}I")
        stored, timeout_ms, counter = read.take("BHI")
        return cls(
            version, schema, bool(may_write), Numeric(numeric).name.lower(), pwm_hz, cpu_hz, counts, stream_signals,
            recorder_signals, values, bool(stored), timeout_ms, counter, read.text(), read.text(),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class DriveState:
    counter: int
    state: State
    mode: Mode
    fault: int
    detail: int
    flags: Flag
    rejected: int
    stream_lost: int
    frames_bad: int
    octets_lost: int

    @classmethod
    def parse(cls, payload: bytes) -> DriveState:
        counter, state, mode, fault, detail, flags, *counts = Reader(payload).take("IBBHHHIIII")
        return cls(counter, State(state), Mode(mode), fault, detail, Flag(flags), *counts)


@dataclass(frozen=True, slots=True)
class Event:
    """State or fault has changed."""

    counter: int
    state: State
    fault: int
    detail: int
    flags: Flag

    @classmethod
    def parse(cls, payload: bytes) -> Event:
        counter, state, fault, detail, flags = Reader(payload).take("IBHHH")
        return cls(counter, State(state), fault, detail, Flag(flags))


@dataclass(frozen=True, slots=True)
class CaptureState:
    recorder: int
    config: int
    status: CaptureStatus
    trigger: Trigger
    decimation: int
    pre: int
    rows: int
    done: int
    first: int
    trigger_counter: int
    signals: tuple[int, ...]

    @classmethod
    def parse(cls, payload: bytes) -> CaptureState:
        read = Reader(payload)
        recorder, config, status, trigger, decimation, pre, rows, done = read.take("BBBBHHHH")
        first, at, count = read.take("IIB")
        signals = read.take(f"{count}H")
        return cls(
            recorder, config, CaptureStatus(status), Trigger(trigger), decimation, pre, rows, done, first, at, signals
        )


@dataclass(frozen=True, slots=True)
class PastRun:
    """What the run before a reset ended with, from memory that outlives it."""

    resets: int  # since then
    fault: int
    detail: int
    state: State
    periods: int  # that it lasted
    rows: bool  # the black box still has its last ones

    @classmethod
    def parse(cls, read: Reader) -> PastRun | None:
        resets, fault, detail, state, periods, rows = read.take("BHHBIB")
        return cls(resets, fault, detail, State(state), periods, rows != 0) if resets > 0 else None


@dataclass(frozen=True, slots=True)
class FaultState:
    fault: int
    detail: int
    state: State
    since: int
    status: CaptureStatus
    rows: int
    past: PastRun | None  # None: nothing is known of a run before a reset

    @classmethod
    def parse(cls, payload: bytes) -> FaultState:
        read = Reader(payload)
        fault, detail, state, since, status, rows = read.take("HHBIBH")
        past = PastRun.parse(read) if read.rest() else None  # a firmware from before this has nothing more
        return cls(fault, detail, State(state), since, CaptureStatus(status), rows, past)


@dataclass(frozen=True, slots=True)
class Timing:
    """CPU cycles of the current interrupt and of the main loop."""

    cpu_hz: int
    period_cyc: int
    isr_last_cyc: int
    isr_max_cyc: int
    record_last_cyc: int
    record_max_cyc: int
    pass_max_cyc: int

    @classmethod
    def parse(cls, payload: bytes) -> Timing:
        return cls(*Reader(payload).take("7I"))


def parse_list(kind: int, count: int, payload: bytes) -> list[Field | Fault | str]:
    """Records of a `list` answer, behind its head."""
    read = Reader(payload)
    found: list[Field | Fault | str] = []
    for _ in range(count):
        if kind == 0:
            type_, flags, low, high, default = read.take("BBfff")
            if type_ >= len(KINDS):
                raise unknown("Kind", type_, len(KINDS) - 1)
            name, unit, choices = read.text(), read.text(), read.text()
            words = tuple(choices.split("|")) if choices else ()
            at_rest = bool(flags & AT_REST)
            found.append(Field(name, unit, KINDS[type_], "", words, low, high, default, at_rest))
        elif kind == 1:
            name, unit = read.text(), read.text()
            found.append(Field(name, unit, "float", "", (), float("-inf"), float("inf"), 0.0))
        elif kind == 2:
            found.append(Fault(read.text(), "", ""))
        else:
            found.append(read.text())
    return found


_REFUSALS = {
    1: ("unknown", "this request; use a client of the version of the firmware"),
    2: ("length", "a message of this length; use a client of the version of the firmware"),
    3: ("index", "this number"),
    6: ("busy", "anything while an earlier change is in progress; ask again"),
    7: ("state", "this now"),
    8: ("schema", "writing: this firmware was built from other lists of parameters and signals; install the package "
                  "of the firmware's version, or flash the firmware of this package"),
    9: ("not_armed", "a start that was not armed; a fault or a lost link disarms: check, then start again"),
    10: ("unsupported", "this: the board does not have it"),
    11: ("storage", "that: reading or writing the storage failed; the older save is still there"),
    12: ("nothing_stored", "that: nothing was saved with this firmware's lists; save first"),
}  # fmt: skip


MODE_POSITION = 2.0
SETPOINT_FIELDS = ("mode", "speed_ref_rad_s", "id_ref_a", "iq_ref_a", "target_turns", "target_rad")
EXCITE_FIELDS = ("place", "amplitude", "hz")


def refusal(payload: bytes, what: str, schema: Schema | None) -> RefusedError:
    """A refusal as an error with its reason; `schema` names parameters."""
    request, code, field, low, high = Reader(payload).take("BBHff")
    fields = list(schema.parameters.values()) if schema is not None else []
    about = fields[int(field)] if int(field) < len(fields) else None
    if about is not None and (code in (5, 14, 15) or (code == 4 and request == Ask.SET)):
        error = RefusedError(_about_parameter(int(code), about, low, high), what)
        error.parameter = about.name if code == 5 else ""  # of a relation: the client finds the other parameter
        return error
    if code == 4:
        at = int(field)
        names = {Ask.SETPOINT: SETPOINT_FIELDS, Ask.EXCITE: EXCITE_FIELDS}.get(request, ())
        name = names[at] if at < len(names) else f"field {at}"
        if name == "place" and high < low + 3.0:
            return RefusedError(_place(high), what)
        if name == "mode" and high < MODE_POSITION:
            return RefusedError(
                "mode = position does not go with the drive's method: repetitive control (crc, forc, fal-forc) "
                "corrects the speed loop; stop and set method = pi, or position_method = src",
                what,
            )
        return RefusedError(f"{name}: must be within {low:g} .. {high:g}, the limits in force", what)
    if code == 13:
        return RefusedError(f"{field} is more than there is room for: at most {high:g}", what)
    if code == 7:
        state = State(int(field)).name.lower() if field < len(State) else str(field)
        return RefusedError(f"the drive refuses that while its state is {state}", what)
    name, text = _REFUSALS.get(int(code), (f"code {code}", "this"))
    kind = ReadOnlyError if code == 8 else RefusedError
    refused = kind(f"the drive refuses {text} ({name})", what)
    refused.busy = name == "busy"
    return refused


def _place(high: float) -> str:
    if high > 0.0:
        return "place: there is a speed reference in speed mode only; excite the torque, or run in speed mode"
    return (
        "place: something learns and would play the sine back (crc, forc, fal-forc, ro, aro, silc, src, "
        "rdc_learn_gain); set observer_hold = 1, or method = pi"
    )


def _about_parameter(code: int, field: Field, low: float, high: float) -> str:
    """Why a parameter was refused; what `low` and `high` say depends on the code (docs/protocol.md)."""
    unit = f" {field.unit}" if field.unit else ""
    if code == 4:
        return f"{field.name}: the drive takes {field.allowed()}"
    if code == 14:
        return f"{field.name} = {low:g}{unit}: the board allows at most {high:g}{unit}"
    if code == 15:
        asked, now = field.to_text(low), field.to_text(high)
        return f"{field.name} = {asked}: cannot change from {now} while the bridge is on; stop first"
    return (
        f"{field.name} does not fit the other parameters, which leave {low:g} .. {high:g}{unit}, or cannot change "
        "without a restart; see docs/parameters.md"
    )


def fault_detail(parameters: Sequence[str], fault: str, detail: int) -> str:
    """What the detail of a fault says, or ""."""
    if fault == "configuration" and detail < len(parameters):
        return parameters[detail]
    if fault == "align_pole_pairs" and detail > 0:
        return f"the motion shows pole_pairs = {detail}"
    if fault == "encoder_index" and detail > 0:
        return f"off by {detail} counts"
    if fault == "temperature_sensor":
        return "that of the bridge" if detail > 1 else "that of the motor"
    if fault == "safe_torque_off":
        now = ("closed again", "channel 1", "channel 2", "both channels")[detail % 4]
        return f"{now}; channel {detail // 4} did not open" if detail > 3 else now
    if fault == "sto_discrepancy":
        return f"channel {detail}"
    if fault == "restart_lockout":
        return f"again in {detail} s" if detail > 0 else "again now"
    return ""


def fault_text(schema: Schema, number: int, detail: int) -> str:
    """Name, cause and first thing to check, in one line."""
    fault = schema.fault(number)
    if number == 0 or fault.name == NO_FAULT:
        return "no fault"
    names = list(schema.parameters)
    culprit = fault_detail(names, fault.name, detail)
    culprit = f" ({culprit})" if culprit else ""
    advice = f" {fault.cause} Check first: {fault.check}" if fault.cause else ""
    return f"{fault.name}{culprit}:{advice or ' no advice is known'}"
