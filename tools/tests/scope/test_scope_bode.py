"""Frequency responses from a page, on a virtual drive by the clock; test_bench_bode.py holds the figures."""

from __future__ import annotations

import asyncio
import time
from typing import Any

import pytest
from evenspin.scope.feed import DEFAULT_SIGNALS
from pages import WAIT_S, Page, Served, with_scope

RUN = 4
SMALL = {"place": "torque", "first_hz": 40.0, "last_hz": 160.0, "points": 3, "amplitude": 2.0}


def excitation(bench) -> float:
    return float(bench.server.drive.read("excitation_a"))


async def measuring(page: Page) -> dict[str, Any]:
    """The message with a first point."""
    return await page.got("bode", lambda bode: bode["found"] is not None)


def test_a_page_gets_point_after_point_then_margins_and_the_live_rows_come_again(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        assert (await page.got("bode"))["status"] == "none"
        assert "at most 450 Hz" in (await page.ask("bode", place="torque", last_hz=700.0))["error"]
        await page.turn()
        assert "error" not in await page.ask("bode", **SMALL)
        assert "is being measured" in (await page.ask("setpoint", speed_rad_s=31.0))["error"]
        assert "is being measured" in (await page.ask("bode", **SMALL))["error"]
        assert "a frequency response is being measured" in (await page.ask("calibrate", name="offsets"))["error"]
        first = await measuring(page)
        assert first["status"] == "running" and 0.0 < first["part"] < 1.0
        done = await page.got("bode", lambda bode: bode["status"] == "done")
        found = done["found"]
        assert [point["f_hz"] for point in found["points"]] == pytest.approx([40.0, 80.0, 160.0], rel=1e-5)
        assert all(point["loop"]["coherence"] > 0.95 and point["good"] for point in found["points"])
        assert found["units"] == {"plant": "rad/s per A", "loop": ""}
        assert "3 of 3 points are good" in done["lines"][0]
        assert bench.server.drive.read("state") == RUN  # it goes on as it ran
        assert excitation(bench) == 0.0
        count = len(page.frames)
        await page.until(lambda: len(page.frames) > count + 5)
        assert served.feed.live.names == DEFAULT_SIGNALS

    with_scope(bench.port, work)


def test_an_end_leaves_the_motor_running_and_a_stop_does_not(bench) -> None:
    async def work(served: Served) -> None:
        page, watcher = await served.page(), await served.page()
        await page.state("ready")
        await page.turn()
        for how in ("end", "stop"):
            assert "error" not in await page.ask("bode", **(SMALL | {"points": 100}))
            await measuring(page)
            await page.until(lambda: excitation(bench) != 0.0)
            if how == "end":
                assert "only watches" in (await watcher.ask("bode_end"))["error"]
                assert "error" not in await page.ask("bode_end")
            else:
                assert "error" not in await watcher.ask("stop")
            status = {"end": "ended", "stop": "stopped"}[how]
            ended = await page.got("bode", lambda bode, status=status: bode["status"] == status)
            assert excitation(bench) == 0.0
            assert (bench.server.drive.read("state") == RUN) == (how == "end")
            assert 0 < len(ended["found"]["points"]) < 100
        until_s = time.monotonic() + min(1.0, WAIT_S)
        while time.monotonic() < until_s:  # and nothing of it starts the motor again
            assert bench.server.drive.read("state") != RUN
            await asyncio.sleep(0.01)
        await page.ask("bode", **SMALL)
        failed = await page.got("bode", lambda bode: bode["status"] == "failed")
        assert "start it first" in failed["lines"][0]

    with_scope(bench.port, work)
