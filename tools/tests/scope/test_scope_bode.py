"""Frequency responses from a page, on a virtual drive by the clock; test_bench_bode.py holds the figures."""

from __future__ import annotations

import asyncio
import time

import pytest
from evenspin.scope.feed import DEFAULT_SIGNALS
from pages import WAIT_S, Page, Served, with_scope

RUN = 4
SMALL = {"place": "torque", "first_hz": 40.0, "last_hz": 160.0, "points": 3, "amplitude": 2.0}


def excitation(bench) -> float:
    return float(bench.server.drive.read("excitation_a"))


async def measuring(page: Page) -> None:
    """Until there is a first point."""
    await page.until(lambda: page.last["bode"]["found"] is not None)


def test_a_page_gets_point_after_point_then_margins_and_the_live_rows_come_again(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        assert page.last["bode"]["status"] == "none"
        assert "at most 450 Hz" in (await page.ask("bode", place="torque", last_hz=700.0))["error"]
        await page.turn()
        assert "error" not in await page.ask("bode", **SMALL)
        assert "is being measured" in (await page.ask("setpoint", speed_rad_s=31.0))["error"]
        assert "is being measured" in (await page.ask("bode", **SMALL))["error"]
        await measuring(page)
        assert page.last["bode"]["status"] == "running" and 0.0 < page.last["bode"]["part"] < 1.0
        assert "a frequency response is being measured" in (await page.ask("calibrate", name="offsets"))["error"]
        await page.until(lambda: page.last["bode"]["status"] == "done")
        found = page.last["bode"]["found"]
        assert [point["f_hz"] for point in found["points"]] == pytest.approx([40.0, 80.0, 160.0], rel=1e-5)
        assert all(point["loop"]["coherence"] > 0.95 and point["good"] for point in found["points"])
        assert found["units"] == {"plant": "rad/s per A", "loop": ""}
        assert "3 of 3 points are good" in page.last["bode"]["lines"][0]
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
            await page.until(lambda status=status: page.last["bode"]["status"] == status)
            assert excitation(bench) == 0.0
            assert (bench.server.drive.read("state") == RUN) == (how == "end")
            assert 0 < len(page.last["bode"]["found"]["points"]) < 100
        until_s = time.monotonic() + min(1.0, WAIT_S)
        while time.monotonic() < until_s:  # and nothing of it starts the motor again
            assert bench.server.drive.read("state") != RUN
            await asyncio.sleep(0.01)
        await page.ask("bode", **SMALL)
        await page.until(lambda: page.last["bode"]["status"] == "failed")
        assert "start it first" in page.last["bode"]["lines"][0]

    with_scope(bench.port, work)
