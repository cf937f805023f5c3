"""`evenspin scope`: the drive in a browser."""

from __future__ import annotations

import sys
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
    stops when the command ends or the last page is closed.

    Example: `evenspin scope --port "sim:guo2024?cogging.amplitude_nm=0.01&cogging.order=12" --open`
    """
    import asyncio

    from evenspin.bench.ports import check_port
    from evenspin.scope import Feed, make_app
    from evenspin.scope.feed import opener
    from evenspin.scope.local import by_the_clock

    check_port(port)
    with by_the_clock(port, _say) as place:
        app = make_app(Feed(opener(place)), host)
        asyncio.run(_serve(app, host, http_port, open_))


async def _serve(app: web.Application, host: str, http_port: int, open_: bool) -> None:
    import asyncio
    import signal
    import webbrowser

    from aiohttp import web

    from evenspin.errors import InputError

    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    runner = web.AppRunner(app, access_log=None, shutdown_timeout=1.0)
    await runner.setup()
    try:
        site = web.TCPSite(runner, host, http_port)
        try:
            await site.start()
        except OSError as error:
            hint = f"{error.strerror or error}; --http-port 0 takes a free one"
            must = "an address of this machine that is free"
            raise InputError("scope", "--host, --http-port", f"{host}:{http_port}", must, hint) from None
        bound = runner.addresses[0]
        url = f"http://{f'[{bound[0]}]' if ':' in bound[0] else bound[0]}:{bound[1]}/"
        print(url, flush=True)
        _say("Ctrl-C ends it and stops the motor")
        if not _is_local(bound[0]):
            _say(f"everyone who reaches {bound[0]} can move the motor; there is no password")
        if open_:
            webbrowser.open(url)
        await ended.wait()
    finally:
        await runner.cleanup()


def _is_local(address: str) -> bool:
    import ipaddress

    return ipaddress.ip_address(address).is_loopback


def _say(text: str) -> None:
    print(f"evenspin scope: {text}", file=sys.stderr, flush=True)
