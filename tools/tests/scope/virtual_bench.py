"""A virtual drive by the clock, and the hand at its cable and its supply."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from evenspin.bench.ports import virtual_drive
from evenspin.bench.transport import ControlClient
from evenspin.drive.server import Server


@dataclass(frozen=True)
class Bench:
    """A virtual drive that lives by the clock, and the hand at its cable and its supply."""

    server: Server

    @property
    def port(self) -> str:
        return self.server.port

    def do(self, what: str, **fields: object) -> None:
        hand = ControlClient(self.server.control)
        try:
            hand.ask({"do": what, **fields})
        finally:
            hand.close()


@contextmanager
def running_bench(model: str = "sim:guo2024") -> Iterator[Bench]:
    server = Server(virtual_drive(model), address=("127.0.0.1", 0), lockstep=False, say=lambda _: None)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    try:
        yield Bench(server)
    finally:
        server.stop()
        thread.join(5.0)
