"""HTTP and websockets. It serves its own files, and talks to pages that it served, on addresses that it was given."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator, Coroutine
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web

from evenspin.errors import EvenspinError
from evenspin.output.origin import Origin
from evenspin.scope import messages
from evenspin.scope.access import Access
from evenspin.scope.control import Control
from evenspin.scope.feed import Feed, Live
from evenspin.scope.history import REDUCE_ABOVE_ROWS, reduce_rows
from evenspin.scope.page import GONE_S, PING_S, TICK_S, WATCHER_GONE_S, Message, Page
from evenspin.scope.session import Session
from evenspin.scope.stopping import Stopper

PUMP_S = 1.0 / 60.0
REQUESTS_AT_ONCE = 16
REDUCED_PAIRS = 1024
TOKEN_CHARS = 64

HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'; "
    "base-uri 'none'; form-action 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class Scope:
    """The pages of one drive."""

    def __init__(self, feed: Feed, access: Access, made: Origin | None = None) -> None:
        self.feed = feed
        self.access = access
        self.server: web.Server | None = None  # whose connections are watched
        self.session = Session(feed, self._send_from_any_thread, made)
        self.control = Control(self._send_roles, self._stop_abandoned)
        self._loop: asyncio.AbstractEventLoop | None = None
        self._tasks: set[asyncio.Task[Any]] = set()  # the loop itself holds tasks only weakly
        self._work = ThreadPoolExecutor(4, "scope work")
        self._stopper = Stopper(lambda: self.session.do(messages.Simple(do="stop")))
        feed.notify = self._notify

    @property
    def pages(self) -> list[Page]:
        return self.control.pages

    # ---- life

    async def run(self, _: web.Application) -> AsyncIterator[None]:
        self._loop = asyncio.get_running_loop()
        self.feed.start()
        watch = asyncio.create_task(self._watch_pages())
        yield
        watch.cancel()
        for page in list(self.pages):
            with contextlib.suppress(ConnectionError):
                await page.socket.close(code=WSCloseCode.GOING_AWAY, message=b"the scope was closed")
        await self._loop.run_in_executor(None, self.session.close)
        await self._loop.run_in_executor(None, self.feed.close)
        self._work.shutdown(wait=False, cancel_futures=True)
        self._stopper.close()

    # ---- updates of pages

    def _send_from_any_thread(self, message: Message | None) -> None:
        loop = self._loop
        if message and loop is not None and not loop.is_closed():
            with contextlib.suppress(RuntimeError):  # closed in between
                loop.call_soon_threadsafe(self.send, message)

    def send(self, message: Message) -> None:
        for page in self.pages:
            page.put(message)

    def _notify(self, what: str) -> None:
        make = {
            "link": self.session.link_message, "drive": self.session.drive_message, "state": self.session.state_message,
            "layout": self.session.layout_message,
        }[what]  # fmt: skip
        self._send_from_any_thread(make())
        if what == "drive":
            self._send_from_any_thread(self.session.values_message())

    def _send_roles(self) -> None:
        for page in self.pages:
            page.put(self.control.role_of(page))

    # ---- a page

    async def websocket(self, request: web.Request) -> web.StreamResponse:
        self.access.need_own_page(request)
        socket_ = web.WebSocketResponse(
            autoping=False, max_msg_size=messages.MESSAGE_OCTETS, compress=False, writer_limit=1 << 16
        )
        await socket_.prepare(request)
        page = Page(socket_, request.query.get("page", "")[:TOKEN_CHARS], request.transport)
        for message in (
            self.session.link_message(), self.session.drive_message(), self.session.values_message(),
            self.session.layout_message(), self.session.state_message(), self.session.recording.said,
            self.session.calibrating.said,
            self.session.bode.said,
        ):  # fmt: skip
            if message is not None:
                page.put(message)
        self.control.enter(page)
        pump = asyncio.create_task(self._pump(page))
        try:
            async for got in socket_:
                page.note_message()
                if got.type == WSMsgType.TEXT:
                    self._receive(page, got.data)
                    await asyncio.sleep(0)  # what one page has queued must not hold up what another says
                elif got.type == WSMsgType.PING:
                    await socket_.pong(got.data)
        finally:
            pump.cancel()
            self.control.leave(page)
        return socket_

    async def stop_socket(self, request: web.Request) -> web.StreamResponse:
        """A connection for stops alone: nothing that a page has asked for before can stand in front of one."""
        self.access.need_own_page(request)
        socket_ = web.WebSocketResponse(autoping=False, max_msg_size=messages.MESSAGE_OCTETS, compress=False)
        await socket_.prepare(request)
        token = request.query.get("page", "")[:TOKEN_CHARS]
        pinging = asyncio.create_task(_ping_on(socket_))
        try:
            async for got in socket_:
                for page in self.pages:
                    if token and page.token == token:
                        page.note_message()  # rows may be slow in return: what counts is that a stop comes through
                if got.type == WSMsgType.TEXT:
                    self._spawn(self._stop_for(socket_, _id_of(got.data)))
                    await asyncio.sleep(0)
                elif got.type == WSMsgType.PING:
                    await socket_.pong(got.data)
        finally:
            pinging.cancel()
        return socket_

    async def _stop_for(self, socket_: web.WebSocketResponse, number: int) -> None:
        answer = {"type": "answer", "id": number, **await self._stopper.stop()}
        with contextlib.suppress(ConnectionError):
            await socket_.send_str(json.dumps(answer))

    async def _watch_pages(self) -> None:
        while True:
            await asyncio.sleep(TICK_S)
            if self.server is not None:
                self.access.hang_up_on_strangers(self.server)
            for page in list(self.pages):
                page.tick()
                if page.silent_s > (GONE_S if page is self.control.holder else WATCHER_GONE_S) or page.overrun:
                    self.control.leave(page, may_return=False)
                    page.abort()

    def _stop_abandoned(self) -> None:
        """The page with the stop button has gone: the motor must not run on."""
        if self.feed.drive is not None:
            self._spawn(self._stopper.stop())

    def _spawn(self, work: Coroutine[Any, Any, Any]) -> None:
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _receive(self, page: Page, text: str) -> None:
        try:
            request = messages.parse(text)
        except messages.BadRequestError as error:
            page.put({"type": "answer", "id": _id_of(text), "error": str(error)})
            return
        if request.do == "alive":
            page.note_alive()
        elif request.do == "take_control":
            self.control.take(page)
            page.put({"type": "answer", "id": request.id})
        elif request.do in messages.NEEDS_CONTROL and page is not self.control.holder:
            refusal = "this page only watches; take control first"
            page.put({"type": "answer", "id": request.id, "error": refusal})
        elif request.do != "stop" and page.requests >= REQUESTS_AT_ONCE:
            page.put({"type": "answer", "id": request.id, "error": "too many requests at once; wait"})
        else:
            page.requests += request.do != "stop"
            self._spawn(self._answer(page, request))

    async def _answer(self, page: Page, request: Any) -> None:
        if request.do == "stop":
            result = await self._stopper.stop()
        else:
            try:
                result = await asyncio.get_running_loop().run_in_executor(self._work, self.session.do, request)
            finally:
                page.requests -= 1
        page.put({"type": "answer", "id": request.id, **result})

    async def _pump(self, page: Page) -> None:
        """Messages first, then the rows that are new. Waits for the page, and only this page waits."""
        with contextlib.suppress(ConnectionError):
            while not page.socket.closed:
                await page.ping()
                for message in page.take():
                    await page.socket.send_str(json.dumps(message))
                    if message["type"] == "layout":
                        page.layout, page.cursor = message["id"], 0
                if page.capture != self.session.captured_number:
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
        page.capture = self.session.captured_number
        message, frame = self.session.capture_message(), self.session.capture_frame()
        if message is not None and frame is not None:
            await page.socket.send_str(json.dumps(message))
            await page.socket.send_bytes(frame)

    # ---- files

    async def index(self, request: web.Request) -> web.StreamResponse:
        self.access.need_token(request)
        return web.FileResponse(str(files("evenspin.scope") / "static" / "index.html"))

    async def export(self, request: web.Request) -> web.StreamResponse:
        self.access.need_token(request)
        source = request.match_info["source"]
        try:
            seconds = float(request.query.get("seconds", "10"))
            octets = await asyncio.get_running_loop().run_in_executor(self._work, self.session.csv, source, seconds)
        except (EvenspinError, ValueError) as error:
            raise web.HTTPConflict(text=f"{error}\n") from None
        headers = {"Content-Disposition": f'attachment; filename="{source}.csv"'}
        return web.Response(body=octets, content_type="text/csv", headers=headers)

    async def export_config(self, request: web.Request) -> web.StreamResponse:
        self.access.need_token(request)
        try:
            text = await asyncio.get_running_loop().run_in_executor(self._work, self.session.config_file)
        except EvenspinError as error:
            raise web.HTTPConflict(text=f"{error}\n") from None
        headers = {"Content-Disposition": 'attachment; filename="drive.toml"'}
        return web.Response(text=text, content_type="application/toml", headers=headers)

    @web.middleware
    async def guard(self, request: web.Request, handler: Any) -> web.StreamResponse:
        self.access.need_name(request)
        return await handler(request)


async def _harden(_: web.Request, response: web.StreamResponse) -> None:
    response.headers.update(HEADERS)


def make_app(feed: Feed, host: str = "127.0.0.1", made: Origin | None = None) -> web.Application:
    """The application; it starts and closes the feed. Its token is new. `made`: the command, for what it writes."""
    scope = Scope(feed, Access(host), made)
    app = web.Application(middlewares=[scope.guard])
    app[SCOPE] = scope
    app.cleanup_ctx.append(scope.run)
    app.on_response_prepare.append(_harden)
    app.router.add_get("/", scope.index)
    app.router.add_get("/socket", scope.websocket)
    app.router.add_get("/stop", scope.stop_socket)
    app.router.add_get("/export/{source:live|capture}.csv", scope.export)
    app.router.add_get("/export/drive.toml", scope.export_config)
    app.router.add_static("/static/", str(files("evenspin.scope") / "static"))
    return app


SCOPE = web.AppKey("scope", Scope)


async def _ping_on(socket_: web.WebSocketResponse) -> None:
    with contextlib.suppress(ConnectionError):
        while not socket_.closed:
            await socket_.ping()
            await asyncio.sleep(PING_S)


def _id_of(text: str) -> int:
    try:
        number = json.loads(text).get("id", 0)
    except (ValueError, AttributeError, RecursionError):
        return 0
    return number if isinstance(number, int) else 0
