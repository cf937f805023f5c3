"""`evenspin scope`: the drive in a browser."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from evenspin.cli.bench_port import PortOption

if TYPE_CHECKING:
    from aiohttp import web

HTTP_PORT = 7010


def register(app: typer.Typer) -> None:
    app.command("scope")(scope)


def scope(
    port: PortOption = None,
    host: Annotated[str, typer.Option(help="Address to serve on. Others than the default let the network in.")] = (
        "127.0.0.1"
    ),
    http_port: Annotated[int, typer.Option(min=0, max=65535, help="Where the page is; 0: a free one.")] = HTTP_PORT,
    open_: Annotated[bool, typer.Option("--open", help="Show the page in the browser.")] = False,
) -> None:
    """Live plots, full-rate captures, spectrum and tuning of a drive, on a page in the browser.

    Waits for a drive that is not there yet, and for one that was unplugged; never starts the motor by itself. The motor
    stops when the command ends or the page in control is closed. Whoever has the printed address can move the motor;
    its token is new with every start.

    Example: `evenspin scope --port "sim:guo2024?cogging.amplitude_nm=0.01&cogging.order=12" --open`
    """
    import asyncio

    from evenspin.bench.ports import check_port
    from evenspin.cli.origin import origin
    from evenspin.scope import Feed, make_app
    from evenspin.scope.feed import opener
    from evenspin.scope.local import by_the_clock

    check_port(port)
    with by_the_clock(port, _say) as place:
        app = make_app(Feed(opener(place)), host, origin())
        asyncio.run(_serve(app, host, http_port, open_))


async def _serve(app: web.Application, host: str, http_port: int, open_: bool) -> None:
    import asyncio
    import signal

    from aiohttp import web

    from evenspin.errors import InputError
    from evenspin.scope.server import SCOPE

    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    runner = web.AppRunner(app, access_log=None, shutdown_timeout=1.0)
    await runner.setup()
    app[SCOPE].server = runner.server
    try:
        site = web.TCPSite(runner, host, http_port)
        try:
            await site.start()
        except OSError as error:
            hint = f"{error.strerror or error}; --http-port 0 takes a free one"
            must = "an address of this machine that is free"
            raise InputError("scope", "--host, --http-port", f"{host}:{http_port}", must, hint) from None
        bound = runner.addresses[0]
        place = f"{f'[{bound[0]}]' if ':' in bound[0] else bound[0]}:{bound[1]}"
        url = f"http://{place}/?token={app[SCOPE].access.token}"
        print(url, flush=True)
        _say("whoever has this address can move the motor; Ctrl-C ends the scope and stops the motor")
        if not _is_local(bound[0]):
            _say(f"on the network of {bound[0]} the address can be read by others: there is no encryption")
        with contextlib.ExitStack() as shown:
            if open_:
                shown.enter_context(_shown(url))
            await ended.wait()
    finally:
        await runner.cleanup()


@contextlib.contextmanager
def _shown(url: str) -> Iterator[None]:
    """In the browser, by a file that only this user can read: every account sees the words of a command."""
    import tempfile
    import webbrowser
    from pathlib import Path

    with tempfile.TemporaryDirectory(prefix="evenspin-scope-") as folder:
        file = Path(folder) / "scope.html"
        go = f'<meta http-equiv="refresh" content="0; url={url}">'
        file.write_text(f"<!doctype html><title>evenspin scope</title>{go}\n")
        if not webbrowser.open(file.as_uri()):
            _say("there is no browser to open; open the address above")
        yield


def _is_local(address: str) -> bool:
    import ipaddress

    return ipaddress.ip_address(address).is_loopback


def _say(text: str) -> None:
    print(f"evenspin scope: {text}", file=sys.stderr, flush=True)
