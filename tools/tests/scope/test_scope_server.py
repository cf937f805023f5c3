"""The server with a virtual drive behind it and pages made of websockets in front."""

from __future__ import annotations

import asyncio
import dataclasses
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from busy import Stopwatch
from evenspin.bench import client
from evenspin.bench.schema import own_schema
from evenspin.log.csvfile import read_csv
from evenspin.scope import server
from evenspin.scope.feed import DEFAULT_SIGNALS
from pages import Served, with_scope
from virtual_bench import running_bench


def test_only_pages_that_it_served_may_talk_to_it(bench) -> None:
    async def work(served: Served) -> None:
        get = served.get
        for host in ("evil.example", "evil.example:80", "10.0.0.1", ""):
            assert (await get("/", headers={"Host": host})).status == 403, host
        for host in (served.host, "localhost:1", "[::1]:1"):
            assert (await get("/", headers={"Host": host})).status == 200, host
        own = f"http://{served.host}"
        for origin in ("http://evil.example", "null", "", f"{own}.evil.example", own.replace("http", "https")):
            answer = await get("/socket", headers={
                "Origin": origin, "Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
                "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
            })  # fmt: skip
            assert answer.status == 403, origin
        headers = (await get("/")).headers
        assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]
        assert "Access-Control-Allow-Origin" not in headers
        assert (await get("/static/../server.py")).status in (403, 404)
        assert (await get("/static/main.js")).status == 200

    with_scope(bench.port, work)


def test_a_motor_is_armed_then_started_and_armed_again_after_a_stop(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        assert (await page.ask("start", speed_rad_s=30.0))["error"] == "start: arm first"
        await page.turn()
        assert "error" not in await page.ask("stop")
        await page.state("ready")
        assert (await page.ask("start", speed_rad_s=30.0))["error"] == "start: arm first"

    with_scope(bench.port, work)


def test_rows_come_without_a_gap_and_the_speed_arrives(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        assert (await page.got("layout"))["names"] == list(DEFAULT_SIGNALS)
        await page.turn()
        await page.more_rows(800)
        t_s = np.concatenate([t_s for *_, t_s in page.frames])
        assert np.diff(t_s) == pytest.approx(0.001, abs=1e-9)
        live = served.feed.live
        assert live is not None
        speed = live.history.last(0.2).values[:, live.names.index("speed_rad_s")]
        assert speed.mean() == pytest.approx(30.0, abs=0.3)  # 1 %: the ripple of the faulty current sensors is smaller

    with_scope(bench.port, work)


def test_a_refused_parameter_says_its_limits_and_a_taken_one_reaches_every_page(bench) -> None:
    async def work(served: Served) -> None:
        page, other = await served.page(), await served.page()
        await page.state("ready")
        refused = await page.ask("set", values={"rc_gain": 40.0})
        assert refused["error"].startswith("rc_gain = 40.0: must be a number in 0 .. 10")
        assert "error" not in await page.ask("set", values={"rc_gain": 0.25})
        await other.got("values", lambda message: message["values"].get("rc_gain") == 0.25)

    with_scope(bench.port, work)


def test_a_second_page_watches_and_stops_and_may_take_over(bench) -> None:
    async def work(served: Served) -> None:
        first, second = await served.page(), await served.page()
        await first.state("ready")
        assert [(await page.got("role"))["role"] for page in (first, second)] == ["control", "watch"]
        await first.turn()
        for what in ("arm", "setpoint", "clear_fault", "save"):
            assert "only watches" in (await second.ask(what))["error"], what
        assert "error" not in await second.ask("stop")
        await first.state("ready")
        await second.ask("take_control")
        await first.got("role", lambda role: role["role"] == "watch")
        await second.turn()

    with_scope(bench.port, work)


def test_an_unplugged_drive_is_found_again_and_does_not_start_by_itself(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        await page.turn()
        await page.got("link", lambda link: link["status"] == "connected")
        bench.do("unplug", seconds=0.7)
        link = await page.got("link", lambda link: link["status"] == "searching")
        assert "start it again" in link["text"] or "nothing answers" in link["text"]
        assert "error" in await page.ask("start", speed_rad_s=30.0)
        await page.got("link", lambda link: link["status"] == "connected")
        await page.state("ready")
        await asyncio.sleep(0.5)
        assert (await page.got("state"))["state"] == "ready"
        assert abs(bench.server.drive.read("true_speed_rad_s")) < 30.0
        count = len(page.frames)
        await page.until(lambda: len(page.frames) > count + 5)  # the same signals come again

    with_scope(bench.port, work)


def test_after_a_stop_no_command_is_shown_or_exported_as_if_it_acted(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        await page.turn()
        await page.more_rows(200)
        assert "error" not in await page.ask("stop")
        await page.state("ready")
        await page.more_rows(300)  # twice those that are looked at: what came before the stop may have been on its way
        rows = (await (await served.get("/export/live.csv?seconds=0.1")).text()).splitlines()
        names = rows[0].split(",")
        for name in ("speed_ref_rad_s", "iq_ref_a", "vq_v"):
            assert {float(row.split(",")[names.index(name)]) for row in rows[1:]} == {0.0}, name
        assert abs(float(rows[-1].split(",")[names.index("speed_rad_s")])) > 1.0  # the motor still coasts

    with_scope(bench.port, work)


def test_a_refusal_names_what_was_asked_for_and_what_stands_against_it(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        refused = (await page.ask("set", values={"over_current_a": 5.0}))["error"]
        assert refused.startswith("over_current_a = 5 A: does not fit iq_limit_a = 10 A")
        await page.turn()
        refused = (await page.ask("set", values={"pole_pairs": 5.0}))["error"]
        assert refused == "pole_pairs = 5: cannot change from 4 while the bridge is on; stop first"

    with_scope(bench.port, work)


def test_a_fault_comes_with_its_advice_and_its_last_samples(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        assert "no fault" in (await page.ask("last_fault"))["error"]
        await page.turn()
        bench.do("input", name="dc_link_v", value=5.0)
        await page.state("fault")
        fault = (await page.got("state"))["fault"]
        assert fault["name"] == "under_voltage"
        assert fault["check"] == "Supply, its current limit, cables and fuse."  # firmware/app/faults.def
        assert "error" not in await page.ask("last_fault")
        await page.until(lambda: any(kind == 3 for kind, *_ in page.frames))
        bench.do("input", name="dc_link_v", value=24.0)
        await page.more_rows(50)
        assert "error" not in await page.ask("clear_fault")
        await page.state("ready")

    with_scope(bench.port, work)


def test_a_capture_is_triggered_where_it_was_asked_for(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        wanted = {"signals": ["speed_rad_s", "iq_a"], "trigger": "rising", "signal": "speed_rad_s", "level": 15.0}
        assert (await page.ask("capture", **wanted, rows=400, pre_pct=25.0))["rows"] == 400
        await page.got("capture", lambda capture: capture["status"] == "waiting")
        await page.turn()
        await page.until(lambda: any(kind == 3 for kind, *_ in page.frames))
        assert (await page.got("capture_layout"))["title"] == "speed_rad_s rises above 15"
        t_s = next(t_s for kind, _, t_s in page.frames if kind == 3)
        np.testing.assert_allclose(t_s, (np.arange(400) - 100) / 10_000.0, atol=1.01e-4)  # a row
        octets = await (await served.get("/export/capture.csv")).read()
        assert octets.splitlines()[0] == b"t_s,speed_rad_s,iq_a"
        assert len(octets.splitlines()) == 401
        speed = np.array([float(line.split(b",")[1]) for line in octets.splitlines()[1:]])
        assert speed[:100].max() <= 15.0 < speed[101:120].max()

    with_scope(bench.port, work)


def test_a_stop_does_not_wait_for_a_capture_that_is_being_fetched() -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        assert "error" not in await page.ask("watch", signals=["speed_rad_s"], rate_hz=100.0)
        await page.turn()
        await page.ask("capture", signals=list(DEFAULT_SIGNALS), rows=700)
        await page.got("capture", lambda capture: capture["status"] == "fetching")
        watch = Stopwatch()
        assert "error" not in await page.ask("stop")
        took_s = watch.quiet_s()
        assert (await page.got("capture"))["status"] == "fetching"
        # 700 rows of 8 signals are 22 kB: 2 s at 115200 baud. Three answers that are on their way are 0.07 s of it.
        assert took_s < 0.7
        await page.state("ready")

    with running_bench("sim:guo2024?baud=115200") as slow:
        with_scope(slow.port, work)


def test_a_stop_does_not_wait_for_another_change(bench, monkeypatch: pytest.MonkeyPatch) -> None:
    began = threading.Event()

    def save_slowly(_: client.Drive) -> None:
        began.set()
        time.sleep(1.0)

    monkeypatch.setattr(client.Drive, "save", save_slowly)

    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        await page.turn()
        saving = asyncio.create_task(page.ask("save"))
        await page.until(began.is_set)
        watch = Stopwatch()
        await page.ask("stop")
        assert watch.quiet_s() < 0.5  # and not the second that the save takes
        await saving

    with_scope(bench.port, work)


def test_a_wrong_capture_is_refused_at_once(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        names = [signal["name"] for signal in (await page.got("drive"))["signals"]][:9]
        assert "1 to 8 names" in (await page.ask("capture", signals=names))["error"]
        assert "did you mean iq_a" in (await page.ask("capture", signals=["iq_aa"]))["error"]

    with_scope(bench.port, work)


def test_the_export_is_a_log_that_the_tools_read(bench, tmp_path: Path) -> None:
    async def work(served: Served) -> None:
        assert (await served.get("/export/live.csv")).status == 409  # nothing yet
        page = await served.page()
        await page.until(lambda: len(page.frames) > 10)
        answer = await served.get("/export/live.csv?seconds=0.1")
        path = tmp_path / "live.csv"
        path.write_bytes(await answer.read())
        assert answer.headers["Content-Disposition"] == 'attachment; filename="live.csv"'
        record = read_csv(path, ("t_s", *DEFAULT_SIGNALS), ("",) * (1 + len(DEFAULT_SIGNALS)))
        assert record["vdc_v"].mean() == pytest.approx(24.0, rel=1e-3)  # dc_link_v of the model

    with_scope(bench.port, work)


def test_a_page_that_does_not_read_costs_nobody_else_a_row(bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "REDUCE_ABOVE_ROWS", 200)
    monkeypatch.setattr(server, "REDUCED_PAIRS", 20)

    async def work(served: Served) -> None:
        page, slow = await served.page(), await served.page()
        scope = served.http.app[server.SCOPE]
        held = scope.pages[1]
        free = asyncio.Event()
        send = held.socket.send_bytes

        async def hang(octets: bytes, **options: Any) -> None:
            await free.wait()
            await send(octets, **options)

        monkeypatch.setattr(held.socket, "send_bytes", hang)
        await page.until(lambda: page.rows > 1000)
        t_s = np.concatenate([t_s for *_, t_s in page.frames])
        assert np.diff(t_s) == pytest.approx(0.001, abs=1e-9)
        free.set()
        await slow.until(lambda: any(kind == 2 for kind, *_ in slow.frames))
        reduced = next(t_s for kind, _, t_s in slow.frames if kind == 2)
        assert len(reduced) == 40

    with_scope(bench.port, work)


def test_a_drive_of_other_firmware_can_be_watched_and_stopped_only(bench, monkeypatch: pytest.MonkeyPatch) -> None:
    own = own_schema()
    fewer = {name: field for name, field in own.parameters.items() if name != "rc_gain"}
    monkeypatch.setattr(client, "own_schema", lambda: dataclasses.replace(own, parameters=fewer))

    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        drive = await page.got("drive")
        assert "other lists of parameters and signals" in drive["read_only"]
        assert len(drive["parameters"]) > 50
        assert "can only be read" in (await page.ask("set", values={"rc_gain": 0.25}))["error"]
        assert "can only be read" in (await page.ask("arm"))["error"]
        assert "gain" in (await page.ask("document", name="rc_gain"))["text"]
        assert "error" not in await page.ask("stop")
        await page.until(lambda: len(page.frames) > 5)

    with_scope(bench.port, work)


def test_without_a_drive_the_page_says_what_to_do() -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        link = await page.got("link", lambda link: "cannot be opened" in link["text"])
        assert link["status"] == "searching"
        assert "check cable, name and rights" in link["text"]
        assert "no drive is connected" in (await page.ask("stop"))["error"]

    with_scope("/dev/ttyNOBODY", work)


def test_a_request_that_is_none_is_answered_in_one_line(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        assert "do" in (await page.ask("explode"))["error"]
        await page.socket.send_str("{")
        await page.socket.send_str("[1]")
        assert "error" not in await page.ask("take_control")  # it is still there

    with_scope(bench.port, work)
