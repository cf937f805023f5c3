"""`sim:` ports for the scope: a page watches a drive that runs in real time, so the virtual one is served by it."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator

from evenspin.bench.ports import SIM, note_of, virtual_drive
from evenspin.drive.server import Server
from evenspin.errors import InputError


@contextlib.contextmanager
def by_the_clock(port: str | None, say: Callable[[str], None]) -> Iterator[str | None]:
    """The port to open. For `sim:` a virtual drive runs in this process until the end of the `with`."""
    if port is None or not port.startswith(SIM):
        note = note_of(port) if port else None
        if note is not None and note.speed == "max":
            hint = "start it without --speed max"
            raise InputError("scope", "--port", port, "a drive that runs by the clock", hint)
        yield port
        return
    server = Server(virtual_drive(port), address=("127.0.0.1", 0), lockstep=False, say=say)
    thread = threading.Thread(target=server.run, name="virtual drive", daemon=True)
    thread.start()
    say(f"virtual drive {port} at {server.port}, its load machine at {server.control}")
    try:
        yield server.port
    finally:
        server.stop()
        thread.join(5.0)
