"""How the commands of `evenspin bench` find a drive, and let go of it."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from evenspin.bench import Drive

PortOption = Annotated[
    str | None,
    typer.Option(
        "--port", metavar="PORT", help="Serial device, socket://HOST:PORT or sim:MODEL; default: the only one there is."
    ),
]


@contextlib.contextmanager
def connected(port: str | None, *, reconnect_s: float = 0.0) -> Iterator[Drive]:
    """A drive that stops whatever happens: also when the program is asked to end."""
    from evenspin.bench import Drive

    def end(*_: object) -> None:
        raise KeyboardInterrupt

    before = {number: signal.signal(number, end) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        with Drive.connect(port, reconnect_s=reconnect_s) as drive:
            yield drive
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
