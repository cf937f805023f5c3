"""The control port of a virtual drive: connections, lines, answers. What the lines ask for is done by `drive.server`.

Nobody who connects can end the drive or hold its clock: nothing here waits, what has no end is cut off, and a client
that does not read its answers is hung up. A web page may make a browser connect to any port of this machine: what the
browser sends first is not a JSON object, and then the connection is closed before anything is done.
"""

from __future__ import annotations

import json
import math
import selectors
import socket
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

READ_OCTETS = 1 << 16
LINE_OCTETS = 1 << 16
WAITING_OCTETS = 1 << 18  # requests that wait for their turn, and answers that wait for the client
LINES_AT_ONCE = 32  # of one client; then it is the turn of the drive again
CONNECTIONS = 64  # connections at once

Request = Mapping[str, Any]


@dataclass(eq=False)
class ControlConnection:
    """A connection, what has arrived of its next requests, and what it has not taken of the answers."""

    connection: socket.socket
    text: bytearray = field(default_factory=bytearray)
    out: bytearray = field(default_factory=bytearray)
    greeted: bool = False  # its first line began as a JSON object does
    closed: bool = False
    waiting: Request | None = None  # an advance that waits for octets


class ControlConnections:
    """`do` is called with each request and answers with `reply`, at once or later."""

    def __init__(
        self, listener: socket.socket, select: selectors.BaseSelector, do: Callable[[ControlConnection, object], None]
    ) -> None:
        self._listener, self._select, self._do = listener, select, do
        listener.setblocking(False)
        self.all: list[ControlConnection] = []
        select.register(listener, selectors.EVENT_READ, self._accept)

    def close(self) -> None:
        for client in list(self.all):
            self.drop(client)
        self._listener.close()

    @property
    def busy(self) -> bool:
        """Requests are here that had no turn yet."""
        return any(client.waiting is None and b"\n" in client.text for client in self.all)

    def serve(self) -> None:
        """A turn for everybody."""
        for client in list(self.all):
            self._work(client)

    def reply(self, client: ControlConnection, answer: Request) -> None:
        if len(client.out) > WAITING_OCTETS:
            self.drop(client)  # it does not read
            return
        client.out += json.dumps(answer).encode() + b"\n"
        self._send(client)

    def drop(self, client: ControlConnection) -> None:
        if not client.closed:
            client.closed = True
            self._select.unregister(client.connection)
            client.connection.close()
            self.all.remove(client)

    # ---- octets

    def _accept(self) -> None:
        try:
            connection, _ = self._listener.accept()
        except OSError:
            return  # it has gone again, or there are too many
        if len(self.all) >= CONNECTIONS:
            connection.close()
            return
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client = ControlConnection(connection)
        self.all.append(client)
        self._select.register(connection, selectors.EVENT_READ, lambda: self._ready(client))

    def _ready(self, client: ControlConnection) -> None:
        if client.closed:
            return
        self._send(client)
        if client.closed:
            return
        try:
            octets = client.connection.recv(READ_OCTETS)
        except BlockingIOError:
            return
        except OSError:
            octets = b""
        client.text += octets
        if not client.greeted and client.text.lstrip()[:1] not in (b"{", b""):
            self._refuse(client, "the first line is not a JSON object; the connection is closed")
        elif not octets or len(client.text) > WAITING_OCTETS:
            self.drop(client)
        elif len(client.text) - client.text.rfind(b"\n") > LINE_OCTETS:
            self._refuse(client, f"a line is longer than {LINE_OCTETS} octets; the connection is closed")

    def _refuse(self, client: ControlConnection, text: str) -> None:
        self.reply(client, {"error": text})
        self.drop(client)

    def _send(self, client: ControlConnection) -> None:
        if client.closed or not client.out:
            return
        try:
            sent = client.connection.send(client.out)
            del client.out[:sent]
        except BlockingIOError:
            pass
        except OSError:
            self.drop(client)
            return
        events = selectors.EVENT_READ | (selectors.EVENT_WRITE if client.out else 0)
        if self._select.get_key(client.connection).events != events:
            self._select.modify(client.connection, events, lambda: self._ready(client))

    # ---- lines

    def _work(self, client: ControlConnection) -> None:
        for _ in range(LINES_AT_ONCE):
            if client.closed or client.waiting is not None or b"\n" not in client.text:
                return
            end = client.text.index(b"\n")
            line = bytes(client.text[:end])
            del client.text[: end + 1]
            if not line.strip():
                continue
            client.greeted = True
            try:
                self._do(client, parse(line))
            except Exception as error:  # a mistake of ours must not end the drive of everybody
                self.reply(client, {"error": f"failed: {error!r}"})


def parse(line: bytes) -> object:
    """The value of a line of JSON; None for what is none, or is nested so deeply that nobody can mean it."""
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None


def number_of(request: Request, key: str, low: float = -math.inf, high: float = math.inf) -> float:
    """A finite number of a request, within limits; a KeyError when it is missing, a ValueError for anything else."""
    value = request[key]
    good = isinstance(value, int | float) and not isinstance(value, bool)
    if not good or not math.isfinite(value) or not low <= value <= high:
        limits = "a finite number" if math.isinf(low) else f"a number in {low:g} .. {high:g}"
        raise ValueError(f"{key} = {str(value)[:40]}: must be {limits}")
    return float(value)
