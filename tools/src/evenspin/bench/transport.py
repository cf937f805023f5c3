"""Octets to and from a drive, and the clock by which it is waited for.

    /dev/ttyUSB0, /dev/pts/3     a serial port or pseudo terminal
    socket://HOST:PORT           TCP, as `evenspin drive --tcp` offers it
    sim:MODEL?effect.param=1     a virtual drive in this process, in lockstep: as fast as it goes, always the same

Real transports wait by the clock of the machine. Lockstep transports make time pass by reading: their clock is the
drive's own, and a timeout is a time of the drive.
"""

from __future__ import annotations

import json
import math
import os
import select
import socket
import time
from typing import Any, Protocol

from evenspin.bench.errors import LinkLostError, NoDeviceError
from evenspin.drive.virtual import BITS_PER_OCTET, VirtualDrive

BAUD = 625_000
POLL_S = 0.02
READ_OCTETS = 1 << 16
OPEN_S = 2.0


class Transport(Protocol):
    """`lockstep`: time stands still unless `read` is called. `octets_per_s`: what the line carries; None: no limit."""

    name: str
    lockstep: bool
    octets_per_s: float | None

    def write(self, octets: bytes) -> None: ...

    def read(self, timeout_s: float) -> bytes:
        """What has arrived; waits for the first octet, and returns b"" when none came."""
        ...

    def clock(self) -> float: ...

    def close(self) -> None: ...


class SerialTransport:
    """A serial device."""

    lockstep = False

    def __init__(self, name: str, baud: int = BAUD, octets_per_s: float | None = BAUD / BITS_PER_OCTET) -> None:
        import serial

        self.name = name
        self.octets_per_s = octets_per_s
        try:
            self._port = serial.Serial(name, baud, timeout=POLL_S, write_timeout=1.0, exclusive=True)
            self._port.reset_input_buffer()
        except (OSError, ValueError) as error:
            if _locked(error):
                raise NoDeviceError(f"{name}: another program uses it; end that one, or stop the drive there") from None
            raise NoDeviceError(f"{name}: cannot be opened ({_reason(error)}); check cable, name and rights") from None

    def write(self, octets: bytes) -> None:
        try:
            self._port.write(octets)
        except (OSError, TypeError) as error:
            raise LinkLostError(f"{self.name}: the link is lost ({_reason(error)}); check the cable") from None

    def read(self, timeout_s: float) -> bytes:
        until_s = time.monotonic() + timeout_s
        try:
            while True:
                octets = self._port.read(1)
                if octets:
                    return octets + self._port.read(self._port.in_waiting)
                if time.monotonic() >= until_s:
                    return b""
        except (OSError, TypeError) as error:
            raise LinkLostError(f"{self.name}: the link is lost ({_reason(error)}); check the cable") from None

    def clock(self) -> float:
        return time.monotonic()

    def close(self) -> None:
        self._port.close()


class SocketTransport:
    """TCP."""

    lockstep = False

    def __init__(self, name: str, address: tuple[str, int], octets_per_s: float | None = None) -> None:
        self.name = name
        self.octets_per_s = octets_per_s
        self._socket = connect(name, address)

    def write(self, octets: bytes) -> None:
        try:
            self._socket.sendall(octets)
        except OSError as error:
            raise LinkLostError(f"{self.name}: the link is lost ({_reason(error)}); does the drive run?") from None

    def read(self, timeout_s: float) -> bytes:
        try:
            if not select.select([self._socket], [], [], max(0.0, timeout_s))[0]:
                return b""
            octets = self._socket.recv(READ_OCTETS)
        except (OSError, ValueError) as error:
            raise LinkLostError(f"{self.name}: the link is lost ({_reason(error)}); does the drive run?") from None
        if not octets:
            raise LinkLostError(f"{self.name}: the link is lost (the other end closed it); does the drive run?")
        return octets

    def clock(self) -> float:
        return time.monotonic()

    def close(self) -> None:
        self._socket.close()


class LocalTransport:
    """A virtual drive in this process, in lockstep."""

    lockstep = True

    def __init__(self, name: str, drive: VirtualDrive) -> None:
        self.name = name
        self.octets_per_s = drive.octets_per_s
        self.drive = drive

    def write(self, octets: bytes) -> None:
        self.drive.send(octets)

    def read(self, timeout_s: float) -> bytes:
        for _ in range(max(1, math.ceil(timeout_s * 1000.0))):
            self.drive.advance(1)
            if self.drive.has_octets:
                break
        return self.drive.receive()

    def clock(self) -> float:
        return self.drive.time_s

    def close(self) -> None:
        self.drive.forget_octets()


class LockstepTransport:
    """A virtual drive of another process that was started with --speed max."""

    lockstep = True

    def __init__(
        self, name: str, address: tuple[str, int], control: ControlClient, octets_per_s: float | None = None
    ) -> None:
        self.name = name
        self.octets_per_s = octets_per_s
        self._socket = connect(name, address)
        self._control = control
        self._sent = self._got = 0
        self._time_s = float(control.ask({"do": "status"})["t_s"])

    def write(self, octets: bytes) -> None:
        try:
            self._socket.sendall(octets)
        except OSError as error:
            raise LinkLostError(f"{self.name}: the link is lost ({_reason(error)}); does the drive run?") from None
        self._sent += len(octets)

    def read(self, timeout_s: float) -> bytes:
        milliseconds = max(1, math.ceil(timeout_s * 1000.0))
        request = {"do": "advance", "ms": milliseconds, "octets": self._sent, "until_octets": True}
        answer = self._control.ask(request)
        self._time_s = float(answer["t_s"])
        octets = bytearray()
        while self._got < answer["octets"]:
            try:
                more = self._socket.recv(answer["octets"] - self._got)
            except OSError:
                more = b""
            if not more:
                raise LinkLostError(f"{self.name}: the link is lost; does the drive run?")
            self._got += len(more)
            octets += more
        return bytes(octets)

    def clock(self) -> float:
        return self._time_s

    def close(self) -> None:
        self._socket.close()


class ControlClient:
    """The control connection of a virtual drive in another process (see drive.control)."""

    def __init__(self, address: str) -> None:
        self.address = address
        host, _, port = address.rpartition(":")
        self._socket = connect(address, (host.strip("[]"), int(port)))
        self._file = self._socket.makefile("rb")

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        try:
            self._socket.sendall(json.dumps(request).encode() + b"\n")
            line = self._file.readline()
        except OSError:
            line = b""
        if not line:
            raise LinkLostError(f"{self.address}: the virtual drive has gone; start it again")
        answer = json.loads(line)
        if "error" in answer:
            raise NoDeviceError(f"{self.address}: {answer['error']}")
        return answer

    def close(self) -> None:
        self._file.close()
        self._socket.close()


def connect(name: str, address: tuple[str, int]) -> socket.socket:
    try:
        made = socket.create_connection(address, timeout=OPEN_S)
    except OSError as error:
        raise NoDeviceError(f"{name}: nothing answers there ({_reason(error)}); start `evenspin drive --tcp`") from None
    made.settimeout(None)
    made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return made


def _locked(error: BaseException) -> bool:
    """pyserial reports a port that another program has locked as an OSError with this text."""
    return "exclusively lock" in str(error) or "[Errno 16]" in str(error)


def _reason(error: Exception) -> str:
    """What the system says, without the number of it; pyserial wraps that in a text of its own."""
    number = getattr(error, "errno", None)
    return os.strerror(number) if number else getattr(error, "strerror", None) or str(error)
