"""Numbers of docs/protocol.md that stand for a word. A later firmware may report some that are not known here."""

from __future__ import annotations

from enum import IntEnum, IntFlag

from evenspin.bench.errors import NoDeviceError


def unknown(what: str, number: object, most: int) -> NoDeviceError:
    hint = "install the package of the firmware's version"
    return NoDeviceError(f"the drive reports {what} {number}; this package knows 0 to {most}: {hint}")


class Reported(IntEnum):
    """What a drive reports, counted from 0 without a gap."""

    @classmethod
    def _missing_(cls, value: object) -> None:
        raise unknown(cls.__name__, value, len(cls) - 1)


class State(Reported):
    INIT = 0
    OFFSET_CALIBRATION = 1
    ALIGN = 2
    READY = 3
    RUN = 4
    FAULT = 5
    SHORT = 6


class Mode(Reported):
    CURRENT = 0
    SPEED = 1
    POSITION = 2
    TORQUE = 3


class Excite(IntEnum):
    """Where the drive adds a sine, from which a frequency response is measured."""

    NONE = 0
    TORQUE = 1
    CURRENT = 2
    SPEED = 3


class Numeric(Reported):
    FLOAT = 0
    FIXED = 1


RESET_CAUSE_BIT = 9


class Flag(IntFlag):
    ARMED = 1
    STARTED_UP = 2
    TIMEOUT_RUNS = 4
    TIMED_OUT = 8
    SET_WAITS = 16
    HOMED = 32
    STREAMING = 64
    STORING = 128
    RESTORED = 256


class ResetCause(IntEnum):
    """Why the board last started: bits 9 to 11 of the flags."""

    UNKNOWN = 0
    POWER_UP = 1
    PIN = 2
    WATCHDOG = 3
    OTHER = 4

    @classmethod
    def of(cls, flags: int) -> ResetCause:
        number = int(flags) >> RESET_CAUSE_BIT & 7
        return cls(number) if number <= cls.OTHER else cls.UNKNOWN


class Trigger(Reported):
    IMMEDIATE = 0
    RISING = 1
    FALLING = 2
    EITHER = 3
    FAULT = 4
    MANUAL = 5


class CaptureStatus(Reported):
    NEVER = 0
    FILLING_PRE = 1
    WAITING = 2
    FILLING_POST = 3
    COMPLETE = 4
    STOPPED = 5
