"""A virtual drive that others can reach: a pseudo terminal or a TCP port for the link, a TCP port for the operator.

--speed real: chunks of some milliseconds follow the clock. When the machine is too slow, the lost time is dropped and
counted; it is never caught up by a burst that no real drive would make.
--speed max: lockstep. Time moves only when a client asks for it on the control connection, and the client says how many
octets it has sent before: the same client gives the same run, bit for bit, however the two processes are scheduled.
"""

from __future__ import annotations

import contextlib
import errno
import os
import pty
import re
import selectors
import socket
import time
import tty
from collections.abc import Callable
from typing import Any

from evenspin.drive.control import Control
from evenspin.drive.control_connections import ControlConnection, ControlConnections, number_of
from evenspin.drive.virtual import VirtualDrive
from evenspin.errors import InputError

CHUNK_S = 0.002
BEHIND_S = 0.1  # later than this, the clock is set again
BACKLOG_OCTETS = 1 << 20  # what waits for a client that does not read; beyond it the link overruns, as a real one would
READ_OCTETS = 1 << 16
UNPLUG_S = 3600.0  # the longest
ADVANCE_MS = 10_000  # at once, the longest

HTTP = re.compile(rb"[A-Z]{3,8} ")  # how a browser begins, and no frame

Say = Callable[[str], None]


class PtyLink:
    """The drive's end of a pseudo terminal. It is always there; whether somebody listens is not known."""

    def __init__(self) -> None:
        self._ours, self._theirs = pty.openpty()
        tty.setraw(self._ours)
        tty.setraw(self._theirs)
        os.set_blocking(self._ours, False)
        self.name = os.ttyname(self._theirs)
        self.file: Any = self._ours

    def read(self) -> bytes | None:
        try:
            return os.read(self._ours, READ_OCTETS)
        except OSError as error:
            return b"" if error.errno in (errno.EAGAIN, errno.EIO) else None

    def write(self, octets: bytes) -> int:
        try:
            return os.write(self._ours, octets)
        except OSError:
            return 0

    def close(self) -> None:
        os.close(self._ours)
        os.close(self._theirs)


class TcpLink:
    """One client's connection."""

    def __init__(self, connection: socket.socket) -> None:
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.file: Any = connection
        self.name = "tcp"

    def read(self) -> bytes | None:
        """None: the client has gone."""
        try:
            return self.file.recv(READ_OCTETS) or None
        except BlockingIOError:
            return b""
        except OSError:
            return None

    def write(self, octets: bytes) -> int:
        try:
            return self.file.send(octets)
        except OSError:
            return 0

    def close(self) -> None:
        self.file.close()


class Server:
    """Serve one virtual drive until `stop` is called or a signal comes."""

    def __init__(self, drive: VirtualDrive, *, address: tuple[str, int] | None, lockstep: bool, say: Say) -> None:
        """`address` None: a pseudo terminal."""
        self.drive = drive
        self.lockstep = lockstep
        self.say = say
        self.behind_s = 0.0  # time that was dropped
        self.overruns = 0  # octets that no client took
        self._control = Control(drive, "max" if lockstep else "real")
        self._select = selectors.DefaultSelector()
        self._out = bytearray()
        self._link: PtyLink | TcpLink | None = None
        self._plug_at = 0.0
        self._running = True
        host = address[0] if address else "127.0.0.1"
        self._listener = _listen(host, address[1]) if address else None
        if self._listener is not None:
            self._select.register(self._listener, selectors.EVENT_READ, self._accept_link)
            bound = self._listener.getsockname()
            self.port = f"socket://{bound[0]}:{bound[1]}"
        else:
            self._take_link(PtyLink())
            self.port = self._link.name if self._link else ""
        listener = _listen(host, 0)
        self._clients = ControlConnections(listener, self._select, self._do)
        bound = listener.getsockname()
        self.control = f"{bound[0]}:{bound[1]}"

    def stop(self) -> None:
        self._running = False

    def close(self) -> None:
        self._clients.close()
        self._drop_link()
        if self._listener is not None:
            self._listener.close()
        self._select.close()

    def run(self) -> None:
        with contextlib.closing(self):
            if self.lockstep:
                while self._running:
                    self._serve(0.001 if self._out else 0.2)
            else:
                self._run_by_the_clock()

    def _run_by_the_clock(self) -> None:
        start_s = time.monotonic() - self.drive.time_s
        told_s = 0.0
        while self._running:
            due_s = time.monotonic() - start_s - self.drive.time_s
            if due_s < CHUNK_S:
                self._serve(CHUNK_S - due_s)
                continue
            if due_s > BEHIND_S:
                lost_s = due_s - CHUNK_S
                self.behind_s += lost_s
                start_s += lost_s
                due_s = CHUNK_S
                if time.monotonic() - told_s > 1.0:
                    told_s = time.monotonic()
                    self.say(f"too slow: {1e3 * lost_s:.0f} ms dropped, {self.behind_s:.2f} s since the start")
            self._serve(0.0)
            self.drive.advance(int(due_s * 1000.0))
            self._flush()

    # ---- what comes and goes

    def _serve(self, wait_s: float) -> None:
        for key, _ in self._select.select(0.0 if self._clients.busy else wait_s):
            key.data()
        self._clients.serve()
        for client in list(self._clients.all):
            if client.waiting is not None:
                self._advance(client)
        self._flush()

    def _accept_link(self) -> None:
        assert self._listener is not None
        try:
            connection, _ = self._listener.accept()
        except OSError:
            return  # it has gone again
        if time.monotonic() < self._plug_at or self._link is not None:
            connection.close()  # unplugged, or somebody else's
            return
        self._take_link(TcpLink(connection))

    def _take_link(self, link: PtyLink | TcpLink) -> None:
        self._link = link
        self._out.clear()
        self.drive.forget_octets()
        self.drive.octets_in = self.drive.octets_out = 0
        self._select.register(link.file, selectors.EVENT_READ, self._read_link)

    def _drop_link(self) -> None:
        if self._link is not None:
            self._select.unregister(self._link.file)
            self._link.close()
            self._link = None
            self._out.clear()
            self.drive.forget_octets()

    def _read_link(self) -> None:
        assert self._link is not None
        octets = self._link.read()
        if octets is None or (self.drive.octets_in == 0 and self._listener and HTTP.match(octets)):
            self._drop_link()
        elif octets:
            self.drive.send(octets)

    def _flush(self) -> None:
        if self.drive.has_octets:
            self._out += self.drive.receive()
        if self._out and self._link is not None:
            sent = self._link.write(bytes(self._out))
            del self._out[:sent]
        if not self.lockstep and len(self._out) > BACKLOG_OCTETS:
            self.overruns += len(self._out)
            self._out.clear()

    # ---- the bench operator

    def _do(self, client: ControlConnection, request: Any) -> None:
        kind = request.get("do") if isinstance(request, dict) else None
        if kind == "advance" and self.lockstep:
            client.waiting = request
            self._advance(client)
        elif kind == "unplug":
            self._clients.reply(client, self._unplug(request))
        else:
            answer = self._control.answer(request)
            if kind == "status":
                answer |= {"behind_s": self.behind_s, "overruns": self.overruns, "port": self.port}
            self._clients.reply(client, answer)

    def _unplug(self, request: dict[str, Any]) -> dict[str, Any]:
        try:
            seconds = number_of({"seconds": 0.0, **request}, "seconds", 0.0, UNPLUG_S)
        except ValueError as error:
            return {"error": str(error)}
        self._plug_at = time.monotonic() + seconds
        if not isinstance(self._link, PtyLink):
            self._drop_link()
        return {"unplugged": not isinstance(self._link, PtyLink)}

    def _advance(self, client: ControlConnection) -> None:
        """Run when every octet that the client has sent before it asked is here."""
        request = client.waiting or {}
        try:
            milliseconds = int(number_of(request, "ms", 0.0, 1e9))
            octets = number_of(request, "octets", 0.0, 1e15)
        except (KeyError, ValueError):
            client.waiting = None
            self._clients.reply(client, {"error": "advance needs ms and octets, whole numbers from 0"})
            return
        if self.drive.octets_in < octets:
            return
        client.waiting = None
        for _ in range(min(milliseconds, ADVANCE_MS)):
            self.drive.advance(1)
            if self.drive.has_octets and request.get("until_octets"):
                break
        self._flush()
        self._clients.reply(client, {"octets": self.drive.octets_out, "t_s": self.drive.time_s})


def _listen(host: str, port: int) -> socket.socket:
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        return socket.create_server((host, port), family=family)
    except OSError as error:
        hint = f"{error.strerror or error}; port 0 takes a free one"
        raise InputError("drive", "--tcp", f"{host}:{port}", "an address of this machine that is free", hint) from None
