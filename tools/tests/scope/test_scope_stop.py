"""A stop overtakes whatever else is asked, and a page that controls and goes away leaves no motor that turns."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from busy import Stopwatch, slowness
from evenspin.bench import client
from evenspin.scope import messages
from evenspin.scope import page as page_module
from evenspin.scope.server import Scope
from pages import WAIT_S, Page, Served, with_scope

QUEUED = 3000
OURS = 1_000_000  # numbers of the page whose stop is watched
STOP_S = 0.1  # from the message at the server to the request at the drive
GONE_S = 1.0


@contextmanager
def watched_stops(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[list[float], list[float]]]:
    """When stops came in at the server, and when they went out to the drive."""
    came, went = [], []
    receive, stop = Scope._receive, client.Drive.stop_at_once

    def noted_receive(self: Scope, page: Any, text: str) -> None:
        if f'"id": {OURS + 1}' in text:
            came.append(time.monotonic())
        receive(self, page, text)

    def noted_stop(self: client.Drive) -> None:
        went.append(time.monotonic())
        stop(self)

    with monkeypatch.context() as patch:
        patch.setattr(Scope, "_receive", noted_receive)
        patch.setattr(client.Drive, "stop_at_once", noted_stop)
        yield came, went


@pytest.mark.parametrize("what", ["stop", "spectrum", "read_values", "junk"])
def test_a_stop_overtakes_what_another_page_has_queued(bench, monkeypatch: pytest.MonkeyPatch, what: str) -> None:
    async def work(served: Served) -> None:
        page, other = await served.page(), await served.page()
        await page.state("ready")
        await page.turn()
        fields = {"signal": "speed_rad_s", "seconds": 5.0} if what == "spectrum" else {}
        for number in range(QUEUED):
            await other.socket.send_json({"id": number, "do": what, **fields})
        page._number = OURS
        with watched_stops(monkeypatch) as (came, went):
            watch = Stopwatch()
            assert "error" not in await page.ask("stop")
            took_s = watch.quiet_s()
        passed_s = next(at_s for at_s in went if at_s >= came[0]) - came[0]
        print(f"{what}: at the drive {1e3 * passed_s:.1f} ms after it came in, answered after {1e3 * took_s:.0f} ms")
        assert passed_s < STOP_S * slowness()
        assert took_s < 1.0  # of which this process needs most to send and to read what the other page has queued
        await page.state("ready")

    with_scope(bench.port, work)


def test_a_stop_overtakes_what_the_same_page_has_queued(bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page has a second connection for stops alone."""

    async def work(served: Served) -> None:
        page = await served.page()
        stops = await served.connect("/stop")
        await page.state("ready")
        await page.turn()
        for number in range(QUEUED):
            await page.socket.send_json({"id": number, "do": "spectrum", "signal": "speed_rad_s", "seconds": 5.0})
        watch = Stopwatch()
        await stops.send_json({"id": 7, "do": "stop"})
        answer = json.loads((await stops.receive(WAIT_S)).data)
        assert (answer["id"], "error" in answer) == (7, False)
        assert watch.quiet_s() < 0.5
        await page.state("ready")

    with_scope(bench.port, work)


def test_only_pages_that_it_served_may_use_the_way_for_stops(bench) -> None:
    async def work(served: Served) -> None:
        answer = await served.get("/stop", headers={"Origin": "http://evil.example"})
        assert answer.status == 403

    with_scope(bench.port, work)


def test_a_stop_that_is_asked_for_while_one_is_under_way_gets_one_of_its_own(
    bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The one under way may have passed the drive before the start that the second is meant to end."""
    count = []
    monkeypatch.setattr(client.Drive, "stop_at_once", lambda _: (count.append(1), time.sleep(0.2)))

    async def work(served: Served) -> None:
        first, second = await served.page(), await served.page()
        await first.state("ready")
        asked = asyncio.create_task(first.ask("stop"))
        await first.until(lambda: len(count) == 1)
        await second.ask("stop")
        assert len(count) == 2
        await asked

    with_scope(bench.port, work)


async def motor_stops(served: Served, bench: Any, began_s: float) -> float:
    while bench.server.drive.read("state") == 4:
        assert time.monotonic() - began_s < WAIT_S, "the motor runs on"
        await asyncio.sleep(0.005)
    return time.monotonic() - began_s


@pytest.mark.parametrize(("how", "watchers"), [("closed", 0), ("closed", 2), ("killed", 2), ("cut off", 2)])
def test_a_page_in_control_that_goes_away_stops_the_motor_within_a_second(bench, how: str, watchers: int) -> None:
    async def work(served: Served) -> None:
        if how == "cut off":
            socket = await served.connect("/socket", autoping=False)  # hears nothing, says nothing, hangs up nothing
            page = Page(socket)
            await page.got("role")
        else:
            page = await served.page()
        watching = [await served.page() for _ in range(watchers)]
        await page.state("ready")
        alive = None
        if how == "cut off":

            async def pong() -> None:
                while True:
                    await page.socket.pong()
                    await asyncio.sleep(0.05)

            alive = asyncio.create_task(pong())
        await page.turn()
        await asyncio.sleep(0.9)
        assert bench.server.drive.read("state") == 4  # as long as the page is there, the motor runs
        began_s = time.monotonic()
        if alive is not None:
            alive.cancel()
        elif how == "closed":
            await page.close()
        else:
            page.socket._response.connection.transport.abort()
        assert await motor_stops(served, bench, began_s) < GONE_S * slowness()
        for other in watching:
            role = await other.got("role", lambda role: role["free"] and role["pages"] == watchers)
            assert role["role"] == "watch"
        if watching:
            assert "error" not in await watching[0].ask("take_control")
            await watching[1].got("role", lambda role: not role["free"])
            await watching[0].turn()

    with_scope(bench.port, work)


def test_a_page_that_is_loaded_again_keeps_control_and_the_motor_runs_on(bench) -> None:
    async def work(served: Served) -> None:
        page, watcher = await served.page("a"), await served.page("b")
        await page.state("ready")
        await page.turn()
        await page.close()
        stranger = await served.page("c")
        role = await stranger.got("role")
        assert (role["role"], role["free"]) == ("watch", False)
        again = await served.page("a")
        assert (await again.got("role"))["role"] == "control"
        await asyncio.sleep(1.0)
        assert (await again.got("state"))["state"] == "run"
        await watcher.got("role", lambda role: role["pages"] == 3)

    with_scope(bench.port, work)


def test_a_page_that_hangs_is_one_that_has_gone(bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its browser still answers for it, but nobody can press its button."""
    monkeypatch.setattr(page_module, "HUNG_S", 1.2)

    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        await page.socket.send_str('{"do":"alive"}')
        await page.turn()
        began_s = time.monotonic()
        took_s = await motor_stops(served, bench, began_s)
        assert took_s < 2.2  # 1.2 s from the last word

    with_scope(bench.port, work)


def test_deep_junk_is_refused_and_the_page_stays(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        for junk in ("[" * 30_000, '{"id":' * 9_000, '{"do":"set","values":' + "[" * 20_000, "9" * 60_000):
            await page.socket.send_str(junk)
        assert "error" not in await page.ask("take_control")

    with_scope(bench.port, work)


def test_many_values_at_once_can_be_brought_back(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        assert "nothing to undo" in (await page.ask("undo"))["error"]
        assert "error" not in await page.ask("set", values={"rc_gain": 0.25, "iq_limit_a": 5.0})
        before = (await page.got("values", lambda message: message["values"].get("iq_limit_a") == 5.0))["values"]
        assert "error" not in await page.ask("defaults")
        after = await page.got("values", lambda message: message["undo"])
        changed = {name for name, value in after["values"].items() if value != before[name]}
        assert {"rc_gain", "iq_limit_a"} <= changed
        assert after["undo"] == {"what": "defaults", "count": len(changed)}
        assert "error" not in await page.ask("undo")
        assert (await page.got("values", lambda message: message["undo"] is None))["values"] == before
        assert "undo" in messages.NEEDS_CONTROL

    with_scope(bench.port, work)
