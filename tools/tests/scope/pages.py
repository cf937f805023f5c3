"""A scope that serves, and pages made of websockets in front of it."""

from __future__ import annotations

import asyncio
import json
import struct
import time
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from typing import Any

import aiohttp
import numpy as np
from aiohttp import WSMsgType
from aiohttp.test_utils import TestClient, TestServer
from evenspin.scope import Feed, make_app
from evenspin.scope.feed import opener
from evenspin.scope.messages import CAPTURE
from evenspin.scope.server import SCOPE

WAIT_S = 20.0  # the longest that anything here may take; a wait ends when the thing has happened


class Page:
    """What a page does, without a browser."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self.socket = socket
        self._last: dict[str, dict[str, Any]] = {}  # by type; `got` waits for one
        self.frames: list[tuple[int, int, np.ndarray]] = []  # kind, layout, times
        self._answers: dict[int, dict[str, Any]] = {}
        self._number = 0
        self._reader = asyncio.create_task(self._read())

    async def _read(self) -> None:
        async for got in self.socket:
            if got.type == WSMsgType.BINARY:
                kind, layout, rows, _ = struct.unpack_from("<IIII", got.data)
                self.frames.append((kind, layout, np.frombuffer(got.data, "<f8", rows, 16)))
            elif got.type == WSMsgType.TEXT:
                message = json.loads(got.data)
                if message["type"] == "answer":
                    self._answers[message["id"]] = message
                else:
                    self._last[message["type"]] = message

    async def ask(self, what: str, **fields: Any) -> dict[str, Any]:
        self._number += 1
        number = self._number
        await self.socket.send_json({"id": number, "do": what, **fields})
        await self.until(lambda: number in self._answers)
        return self._answers.pop(number)

    async def until(self, true: Callable[[], Any]) -> None:
        until_s = time.monotonic() + WAIT_S
        while not true():
            assert time.monotonic() < until_s, f"still not so: {self._last.get('state')} {self._last.get('link')}"
            await asyncio.sleep(0.01)

    async def got(self, kind: str, true: Callable[[dict[str, Any]], Any] = lambda _: True) -> dict[str, Any]:
        """The newest message of this type, as soon as there is one of which this is true.

        Each type has a way of its own: that one has come says nothing about another, and the next may replace it.
        """
        found: list[dict[str, Any]] = []

        def there() -> bool:
            message = self._last.get(kind)
            if message is not None and true(message):
                found.append(message)
            return bool(found)

        await self.until(there)
        return found[0]

    @property
    def rows(self) -> int:
        """Live rows that have come."""
        return sum(len(t_s) for kind, _, t_s in self.frames if kind != CAPTURE)

    async def more_rows(self, count: int) -> None:
        """So much later by the clock of the drive, however slow this machine is."""
        rows = self.rows + count
        await self.until(lambda: self.rows >= rows)

    async def state(self, name: str) -> None:
        await self.got("state", lambda state: state["state"] == name)

    async def turn(self, speed_rad_s: float = 30.0) -> None:
        assert "error" not in await self.ask("arm")
        assert "error" not in await self.ask("start", speed_rad_s=speed_rad_s)
        await self.state("run")

    async def close(self) -> None:
        await self.socket.close()
        await self._reader


class Served:
    """A scope that serves."""

    def __init__(self, feed: Feed, http: TestClient) -> None:
        self.feed = feed
        self.http = http
        self.host = f"127.0.0.1:{http.port}"
        self.scope = http.app[SCOPE]
        self.scope.server = http.server.runner.server
        self.token = self.scope.access.token

    def with_token(self, path: str) -> str:
        return f"{path}{'&' if '?' in path else '?'}token={self.token}"

    async def get(self, path: str, **options: Any) -> aiohttp.ClientResponse:
        """As a page does it that was opened with the printed address."""
        return await self.http.get(self.with_token(path), **options)

    async def connect(self, path: str, **options: Any) -> aiohttp.ClientWebSocketResponse:
        return await self.http.ws_connect(self.with_token(path), headers={"Origin": f"http://{self.host}"}, **options)

    async def page(self, token: str = "") -> Page:
        """`token`: what a page keeps when it is loaded again."""
        page = Page(await self.connect(f"/socket?page={token}"))
        await page.got("role")
        return page


@asynccontextmanager
async def scope_on(port: str | None) -> AsyncIterator[Served]:
    feed = Feed(opener(port))
    async with TestClient(TestServer(make_app(feed))) as http:
        yield Served(feed, http)


def with_scope(port: str | None, work: Callable[[Served], Coroutine[Any, Any, None]]) -> None:
    async def run() -> None:
        async with scope_on(port) as served:
            await work(served)

    asyncio.run(run())
