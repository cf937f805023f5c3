"""One open page: what waits for it, and whether it is still there."""

from __future__ import annotations

import asyncio
from typing import Any

from aiohttp import web

TICK_S = 0.05
PING_S = 0.15  # the browser answers by itself, also for a page in the background
GONE_S = 0.7  # without an answer of the page in control: closed, killed, or cut off
WATCHER_GONE_S = 6.0
HUNG_S = 3.0  # the browser answers, the page does not: its stop button is dead, too
ANSWERS_WAITING = 4096

Message = dict[str, Any]


class Page:
    """What waits for it is at most the newest message of each kind: a slow page gets fewer.

    Silence is counted in ticks of the loop that serves all pages: time in which no message could arrive does not count.
    """

    def __init__(
        self, socket_: web.WebSocketResponse, token: str, transport: asyncio.BaseTransport | None = None
    ) -> None:
        self.socket = socket_
        self._transport = transport
        self.token = token  # the same after the page was loaded again
        self.cursor = 0
        self.layout = 0
        self.capture = 0
        self.requests = 0
        self._waiting: dict[Any, Message] = {}
        self._silent_ticks = 0
        self._mute_ticks: int | None = None  # None: it never sent a sign of life, so it need not
        self._until_ping_ticks = 0

    # ---- messages

    def put(self, message: Message) -> None:
        key = (message["type"], message.get("id")) if message["type"] == "answer" else message["type"]
        self._waiting.pop(key, None)
        self._waiting[key] = message

    @property
    def overrun(self) -> bool:
        """It asks on and on and does not take the answers."""
        return len(self._waiting) > ANSWERS_WAITING

    def take(self) -> list[Message]:
        taken = list(self._waiting.values())
        self._waiting.clear()
        return taken

    async def ping(self) -> None:
        """When it is time. Waits for the page, as everything that is sent to it."""
        if self._until_ping_ticks <= 0:
            self._until_ping_ticks = round(PING_S / TICK_S)
            await self.socket.ping()
            self.put({"type": "alive"})

    # ---- signs of life

    def note_message(self) -> None:
        self._silent_ticks = 0

    def note_alive(self) -> None:
        self._mute_ticks = 0

    def tick(self) -> None:
        self._silent_ticks += 1
        self._until_ping_ticks -= 1
        if self._mute_ticks is not None:
            self._mute_ticks += 1

    @property
    def silent_s(self) -> float:
        """How long nothing was received; a page that hangs is silent, too, although its browser answers."""
        mute_s = (self._mute_ticks or 0) * TICK_S
        return mute_s if mute_s > HUNG_S else self._silent_ticks * TICK_S

    def abort(self) -> None:
        """Hang up without a farewell: nobody is there to receive it."""
        if isinstance(self._transport, asyncio.Transport):
            self._transport.abort()
