"""HTTP and websockets. It serves its own files, and talks to pages that it served, on addresses that it was told.

A browser sends requests on behalf of any page that it shows, so Host and Origin are checked: a foreign page must not
move a motor, and a foreign name that resolves to this machine must not read from it.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import json
import socket
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from typing import Any
from urllib.parse import urlsplit

from aiohttp import WSCloseCode, WSMsgType, web

from evenspin.errors import EvenspinError
from evenspin.scope import messages
from evenspin.scope.desk import Desk
from evenspin.scope.feed import Feed, Live
from evenspin.scope.history import REDUCE_ABOVE_ROWS, reduce_rows

PUMP_S = 1.0 / 60.0
ALONE_S = 2.0  # a page that is loaded again is back by then
HEARTBEAT_S = 3.0
REQUESTS_AT_ONCE = 16
REDUCED_PAIRS = 1024

HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'; "
    "base-uri 'none'; form-action 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}

Message = dict[str, Any]


class Page:
    """One open page. What waits for it is at most the newest message of each kind: a slow page gets fewer."""

    def __init__(self, socket_: web.WebSocketResponse, number: int) -> None:
        self.socket = socket_
        self.number = number
        self.cursor = 0
        self.layout = 0
        self.capture = 0
        self.requests = 0
        self._waiting: dict[Any, Message] = {}
        self.news = asyncio.Event()

    def put(self, message: Message) -> None:
        key = (message["type"], message.get("id")) if message["type"] == "answer" else message["type"]
        self._waiting.pop(key, None)
        self._waiting[key] = message
        self.news.set()

    def take(self) -> list[Message]:
        taken = list(self._waiting.values())
        self._waiting.clear()
        self.news.clear()
        return taken


class Scope:
    """The pages of one drive."""

    def __init__(self, feed: Feed, host: str) -> None:
        self.feed = feed
        self.desk = Desk(feed, self._tell_from_any_thread)
        self.pages: list[Page] = []
        self.controller: Page | None = None
        self._hosts = allowed_names(host)
        self._numbers = 0
        self._loop: asyncio.AbstractEventLoop | None = None
        self._answering: set[asyncio.Task[None]] = set()
        self._work = ThreadPoolExecutor(4, "scope work")
        self._stopping = ThreadPoolExecutor(2, "scope stop")  # a stop never waits for a worker
        feed.notify = self._notify

    # ---- life

    async def run(self, _: web.Application) -> AsyncIterator[None]:
        self._loop = asyncio.get_running_loop()
        self.feed.start()
        yield
        for page in list(self.pages):
            with contextlib.suppress(ConnectionError):
                await page.socket.close(code=WSCloseCode.GOING_AWAY, message=b"the scope was closed")
        await self._loop.run_in_executor(None, self.desk.close)
        await self._loop.run_in_executor(None, self.feed.close)
        self._work.shutdown(wait=False, cancel_futures=True)
        self._stopping.shutdown(wait=False)

    # ---- news for pages

    def _tell_from_any_thread(self, message: Message | None) -> None:
        loop = self._loop
        if message and loop is not None and not loop.is_closed():
            with contextlib.suppress(RuntimeError):  # closed in between
                loop.call_soon_threadsafe(self.tell, message)

    def tell(self, message: Message) -> None:
        for page in self.pages:
            page.put(message)

    def _notify(self, what: str) -> None:
        make = {
            "link": self.desk.link_message, "drive": self.desk.drive_message, "state": self.desk.state_message,
            "layout": self.desk.layout_message,
        }[what]  # fmt: skip
        self._tell_from_any_thread(make())
        if what == "drive":
            self._tell_from_any_thread(self.desk.values_message())

    def _tell_roles(self) -> None:
        for page in self.pages:
            role = "control" if page is self.controller else "watch"
            page.put({"type": "role", "role": role, "pages": len(self.pages), "free": self.controller is None})

    # ---- a page

    async def websocket(self, request: web.Request) -> web.StreamResponse:
        origin = urlsplit(request.headers.get("Origin", ""))
        if origin.scheme != "http" or origin.netloc != request.host:
            raise web.HTTPForbidden(text="this page was not served by this scope\n")
        socket_ = web.WebSocketResponse(
            heartbeat=HEARTBEAT_S, max_msg_size=messages.MESSAGE_OCTETS, compress=False, writer_limit=1 << 16
        )
        await socket_.prepare(request)
        self._numbers += 1
        page = Page(socket_, self._numbers)
        self.pages.append(page)
        if self.controller is None:
            self.controller = page
        for message in (
            self.desk.link_message(), self.desk.drive_message(), self.desk.values_message(),
            self.desk.layout_message(), self.desk.state_message(),
        ):  # fmt: skip
            if message is not None:
                page.put(message)
        self._tell_roles()
        pump = asyncio.create_task(self._pump(page))
        try:
            async for got in socket_:
                if got.type == WSMsgType.TEXT:
                    self._receive(page, got.data)
        finally:
            pump.cancel()
            self._leave(page)
        return socket_

    def _leave(self, page: Page) -> None:
        self.pages.remove(page)
        if self.controller is page:
            self.controller = None
        self._tell_roles()
        if not self.pages:
            asyncio.get_running_loop().call_later(ALONE_S, self._stop_if_alone)

    def _stop_if_alone(self) -> None:
        """The hand on the stop button has gone: the motor must not run on."""
        if not self.pages and self.feed.drive is not None:
            self._stopping.submit(self.desk.do, messages.Simple(do="stop"))

    def _receive(self, page: Page, text: str) -> None:
        try:
            request = messages.parse(text)
        except messages.BadRequestError as error:
            page.put({"type": "answer", "id": _id_of(text), "error": str(error)})
            return
        if request.do == "take_control":
            self.controller = page
            self._tell_roles()
            page.put({"type": "answer", "id": request.id})
        elif request.do in messages.NEEDS_CONTROL and page is not self.controller:
            error = "this page only watches; take control first"
            page.put({"type": "answer", "id": request.id, "error": error})
        elif request.do != "stop" and page.requests >= REQUESTS_AT_ONCE:
            page.put({"type": "answer", "id": request.id, "error": "too many requests at once; wait"})
        else:
            page.requests += 1
            task = asyncio.create_task(self._answer(page, request))
            self._answering.add(task)  # the loop itself holds tasks only weakly
            task.add_done_callback(self._answering.discard)

    async def _answer(self, page: Page, request: Any) -> None:
        pool = self._stopping if request.do == "stop" else self._work
        try:
            result = await asyncio.get_running_loop().run_in_executor(pool, self.desk.do, request)
        finally:
            page.requests -= 1
        page.put({"type": "answer", "id": request.id, **result})

    async def _pump(self, page: Page) -> None:
        """Messages first, then the rows that are new. Waits for the page, and only this page waits."""
        with contextlib.suppress(ConnectionError):
            while not page.socket.closed:
                for message in page.take():
                    await page.socket.send_str(json.dumps(message))
                    if message["type"] == "layout":
                        page.layout, page.cursor = message["id"], 0
                if page.capture != self.desk.captured_number:
                    await self._send_capture(page)
                live = self.feed.live
                if live is not None and live.number == page.layout:
                    await self._send_rows(page, live)
                await asyncio.sleep(PUMP_S)

    async def _send_rows(self, page: Page, live: Live) -> None:
        if live.history.written == page.cursor:
            return
        page.cursor, rows = live.history.since(page.cursor)
        if len(rows) > REDUCE_ABOVE_ROWS:
            rows = reduce_rows(rows, REDUCED_PAIRS)
        kind = messages.LIVE_REDUCED if rows.reduced else messages.LIVE
        await page.socket.send_bytes(messages.frame(kind, live.number, rows.t_s, rows.values))

    async def _send_capture(self, page: Page) -> None:
        page.capture = self.desk.captured_number
        message, frame = self.desk.capture_message(), self.desk.capture_frame()
        if message is not None and frame is not None:
            await page.socket.send_str(json.dumps(message))
            await page.socket.send_bytes(frame)

    # ---- files

    async def index(self, _: web.Request) -> web.StreamResponse:
        return web.FileResponse(str(files("evenspin.scope") / "static" / "index.html"))

    async def export(self, request: web.Request) -> web.StreamResponse:
        source = request.match_info["source"]
        try:
            seconds = float(request.query.get("seconds", "10"))
            octets = await asyncio.get_running_loop().run_in_executor(self._work, self.desk.csv, source, seconds)
        except (EvenspinError, ValueError) as error:
            raise web.HTTPConflict(text=f"{error}\n") from None
        headers = {"Content-Disposition": f'attachment; filename="{source}.csv"'}
        return web.Response(body=octets, content_type="text/csv", headers=headers)

    @web.middleware
    async def guard(self, request: web.Request, handler: Any) -> web.StreamResponse:
        if not self.may_serve(request.host):
            raise web.HTTPForbidden(text=f"the scope does not answer to the name {request.host!r}\n")
        return await handler(request)

    def may_serve(self, host: str) -> bool:
        """Addresses cannot be rebound to this machine by somebody else's name server; names can."""
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if name in self._hosts:
            return True
        with contextlib.suppress(ValueError):
            return ipaddress.ip_address(name).is_loopback or "*" in self._hosts
        return False


def allowed_names(host: str) -> frozenset[str]:
    """Names that the scope answers to; "*": any address in figures."""
    names = {"localhost", host.lower()}
    try:
        local = host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        local = False
    return frozenset(names if local else names | {"*", socket.gethostname().lower()})


async def _harden(_: web.Request, response: web.StreamResponse) -> None:
    response.headers.update(HEADERS)


def make_app(feed: Feed, host: str = "127.0.0.1") -> web.Application:
    """The application; it starts and closes the feed."""
    scope = Scope(feed, host)
    app = web.Application(middlewares=[scope.guard])
    app[SCOPE] = scope
    app.cleanup_ctx.append(scope.run)
    app.on_response_prepare.append(_harden)
    app.router.add_get("/", scope.index)
    app.router.add_get("/socket", scope.websocket)
    app.router.add_get("/export/{source:live|capture}.csv", scope.export)
    app.router.add_static("/static/", str(files("evenspin.scope") / "static"))
    return app


SCOPE = web.AppKey("scope", Scope)


def _id_of(text: str) -> int:
    try:
        number = json.loads(text).get("id", 0)
    except (ValueError, AttributeError):
        return 0
    return number if isinstance(number, int) else 0
