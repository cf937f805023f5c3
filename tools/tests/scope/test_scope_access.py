"""Who may talk to the scope, and that nobody who hammers at it keeps a stop from the drive."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import stat
import subprocess
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import aiohttp
import pytest
from busy import Stopwatch, slowness
from evenspin.bench import client
from evenspin.scope.access import STRANGERS, Access
from pages import WAIT_S, Served, with_scope

STOP_S = 0.1  # from the message at the server to the request at the drive
UPGRADE = {
    "Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}  # fmt: skip


@pytest.mark.parametrize("place", ["/", "/socket", "/stop", "/export/live.csv", "/export/capture.csv"])
def test_without_the_token_of_this_run_everything_is_refused_in_one_line(bench, place: str) -> None:
    async def work(served: Served) -> None:
        headers = {"Origin": f"http://{served.host}", **UPGRADE}
        another = Access("127.0.0.1").token
        for shown in ("", "?token=", f"?token={another}", f"?token={served.token[:-1]}", f"?token={served.token}x",
                      "?token=%ff%00", f"?page={served.token}", f"?token=x&token={served.token}"):  # fmt: skip
            answer = await served.http.get(place + shown, headers=headers)
            text = await answer.text()
            assert (answer.status, text.count("\n")) == (403, 1), shown
            assert "open the address that `evenspin scope` printed" in text
            assert served.token not in text
        await asyncio.sleep(0.05)
        assert served.scope.pages == []

    with_scope(bench.port, work)


def test_every_run_has_a_token_of_its_own_that_nobody_guesses() -> None:
    tokens = {Access("127.0.0.1").token for _ in range(100)}
    assert len(tokens) == 100
    assert min(map(len, tokens)) >= 22  # 128 bits in base64


def test_a_foreign_origin_is_refused_although_it_has_the_token(bench) -> None:
    async def work(served: Served) -> None:
        for place in ("/socket", "/stop"):
            answer = await served.get(place, headers={"Origin": "http://evil.example", **UPGRADE})
            assert (answer.status, await answer.text()) == (403, "this page was not served by this scope\n")

    with_scope(bench.port, work)


def test_open_puts_the_token_on_no_command_line(tmp_path: Path) -> None:
    """Every account sees the words of a command. The browser gets a file that only this user can read."""
    seen = tmp_path / "seen"
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\nprintf "%s" "$*" > {seen}.part; mv {seen}.part {seen}\n')
    browser.chmod(0o700)
    words = [sys.executable, "-c", "from evenspin.cli import main; main()", "scope", "--port", "sim:guo2024"]
    environment = {**os.environ, "BROWSER": f"{browser} %s"}
    process = subprocess.Popen(
        [*words, "--http-port", "0", "--open"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        env=environment,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        token = parse_qs(urlsplit(address).query)["token"][0]
        until_s = time.monotonic() + 4.0 * WAIT_S
        while not seen.exists():
            assert time.monotonic() < until_s
            time.sleep(0.05)
        opened = seen.read_text()
        file = Path(urlsplit(opened).path)
        assert token not in opened and opened.startswith("file:///")
        assert f"url={address}" in file.read_text()
        assert stat.S_IMODE(file.parent.stat().st_mode) == 0o700
    finally:
        process.terminate()
        process.wait(10.0)
    assert not file.exists()


@asynccontextmanager
async def hostile(served: Served, kind: str) -> AsyncIterator[None]:
    """Clients on this machine that mean no good; `flood` and `huge` have the token."""
    port, own = served.http.port, f"http://{served.host}"
    writers: list[asyncio.StreamWriter] = []
    sockets: list[aiohttp.ClientWebSocketResponse] = []
    tasks: list[asyncio.Task[None]] = []

    async def connect() -> asyncio.StreamWriter:
        _, writer = await asyncio.open_connection("127.0.0.1", port)
        writers.append(writer)
        return writer

    async def drip(writer: asyncio.StreamWriter) -> None:
        for octet in f"GET / HTTP/1.1\r\nHost: {served.host}\r\nX: {'a' * 10_000}":
            writer.write(octet.encode())
            await asyncio.sleep(0.02)

    async def guess() -> None:
        async with aiohttp.ClientSession() as session:
            while True:
                async with session.get(f"{own}/socket?token=guess", headers={"Origin": own}) as answer:
                    assert answer.status == 403

    if kind == "silent":
        for _ in range(400):
            await connect()
    elif kind == "slow":
        tasks = [asyncio.create_task(drip(await connect())) for _ in range(50)]
    elif kind == "guessing":
        tasks = [asyncio.create_task(guess()) for _ in range(4)]
    elif kind == "deep":
        sockets = [await served.connect("/socket") for _ in range(4)]
        for socket in sockets:
            for _ in range(50):
                await socket.send_str('{"do":"set","values":' + '{"a":' * 10_000)
    elif kind == "huge":
        for _ in range(8):
            sockets.append(socket := await served.connect("/socket"))
            with contextlib.suppress(ConnectionError):  # cut in the middle
                await socket.send_str("x" * 4_000_000)
    elif kind == "reads nothing":
        sockets = [await served.connect("/socket", autoping=False) for _ in range(20)]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        for writer in writers:
            writer.transport.abort()
        for socket in sockets:
            connection = socket._response.connection
            if connection is not None and connection.transport is not None:
                connection.transport.abort()


@pytest.mark.parametrize("kind", ["silent", "slow", "guessing", "deep", "huge", "reads nothing"])
def test_whoever_hammers_at_it_keeps_no_stop_from_the_drive(bench, monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    came: list[float] = []
    went: list[float] = []
    stop = client.Drive.stop_at_once
    monkeypatch.setattr(client.Drive, "stop_at_once", lambda self: (went.append(time.monotonic()), stop(self))[1])

    async def work(served: Served) -> None:
        page = await served.page("mine")
        await page.state("ready")
        stopper = served.scope._stopper
        ask = stopper.stop

        def noted() -> object:
            came.append(time.monotonic())
            return ask()

        monkeypatch.setattr(stopper, "stop", noted)
        stops = await served.connect("/stop?page=mine")
        await page.turn()
        async with hostile(served, kind):
            await asyncio.sleep(0.3)
            assert (await page.got("state"))["state"] == "run"  # they have not stopped it, either
            watch = Stopwatch()
            began_s = time.monotonic()
            await stops.send_json({"id": 7, "do": "stop"})
            assert "error" not in json.loads((await stops.receive(WAIT_S)).data)
            took_s = watch.quiet_s()
            print(f"{kind}: {1e3 * (went[0] - began_s):.1f} ms to the drive, answered after {1e3 * took_s:.0f} ms")
            assert went[0] - came[0] < STOP_S * slowness()
            assert took_s < 0.5
            again = await served.page("another")  # and the scope still lets pages in
            await again.state("ready")

    with_scope(bench.port, work)


def test_connections_that_say_nothing_are_hung_up_and_those_of_pages_are_not(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        held = [await asyncio.open_connection("127.0.0.1", served.http.port) for _ in range(3 * STRANGERS)]
        server = served.scope.server
        assert server is not None
        await page.until(lambda: len(server.connections) <= STRANGERS + 2)
        await page.state("ready")
        assert "error" not in await page.ask("stop")
        for _, writer in held:
            writer.transport.abort()

    with_scope(bench.port, work)
