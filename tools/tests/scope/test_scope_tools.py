"""Recording, parameters as a file and calibrations from a page, on a virtual drive by the clock."""

from __future__ import annotations

import asyncio
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomlkit
from busy import Stopwatch
from evenspin.bench.raw import read_raw
from evenspin.scope.feed import DEFAULT_SIGNALS
from pages import WAIT_S, Page, Served, with_scope

RUN = 4


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder in which the command runs."""
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


async def config(page: Page, text: str, *, apply: bool = False) -> dict[str, Any]:
    return await page.ask("config", text=text, name="mine.toml", apply=apply)


def test_parameters_go_into_a_file_and_come_back_and_can_be_undone(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        answer = await served.get("/export/drive.toml")
        assert answer.headers["Content-Disposition"] == 'attachment; filename="drive.toml"'
        text = await answer.text()
        assert (await config(page, text))["changes"] == []
        document = tomlkit.parse(text)
        before = float(document["drive"]["rc_gain"])
        document["drive"]["rc_gain"] = 0.25
        document["drive"]["method"] = "forc"
        changed = tomlkit.dumps(document)
        shown = (await config(page, changed))["changes"]
        assert {each["name"]: each["file"] for each in shown} == {"rc_gain": "0.25", "method": "forc"}
        held = (await page.got("values", lambda message: message["values"]))["values"]["rc_gain"]
        assert held == pytest.approx(before)  # only shown
        assert "error" not in await config(page, changed, apply=True)
        loaded = await page.got("values", lambda message: message["values"]["rc_gain"] == 0.25)
        assert loaded["undo"] == {"what": "load", "count": 2}
        assert "error" not in await page.ask("undo")
        await page.got("values", lambda message: message["values"]["rc_gain"] == pytest.approx(before))

    with_scope(bench.port, work)


def test_a_file_that_is_not_right_changes_nothing_and_the_refusal_names_file_and_place(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        text = await (await served.get("/export/drive.toml")).text()
        before = (await page.got("values", lambda message: message["values"]))["values"]
        for wrong, said in (
            ("", "mine.toml"),
            ("drive = [", "mine.toml"),
            (text.replace("rc_gain = ", "rc_gian = "), "did you mean rc_gain"),
            (text.replace("[drive]", "[drive]\nrc_gain = 99.0\n#", 1), "rc_gain"),
            (text.replace('hash = "', 'hash = "0'), "another firmware"),
        ):
            refused = (await config(page, wrong, apply=True))["error"]
            assert said in refused and "mine.toml" in refused, refused
            assert "\n" not in refused and "/tmp" not in refused, refused
        await page.ask("read_values")
        assert (await page.got("values"))["values"] == before
        watcher = await served.page()
        assert "only watches" in (await config(watcher, text, apply=True))["error"]

    with_scope(bench.port, work)


def test_a_recording_holds_every_row_of_its_time_and_says_where_it_is(bench, place: Path) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        began = await page.ask("record")
        folder = place / began["folder"]
        assert (place / f"{folder.name}.raw.mcap").exists()  # it survives a crash
        assert "is running" in (await page.ask("record"))["error"]
        await page.turn()
        await page.more_rows(1100)
        ended = await page.ask("record", on=False)
        assert f"{began['folder']}/recording.csv" in ended["text"]
        said = await page.got("recording", lambda message: not message["on"])
        assert said == {"type": "recording", "on": False, "folder": ended["folder"], "text": ended["text"]}
        rows = np.genfromtxt(folder / "recording.csv", delimiter=",", names=True)
        assert rows.dtype.names == ("t_s", *DEFAULT_SIGNALS)
        assert np.diff(rows["t_s"]) == pytest.approx(0.001, abs=1e-9)
        assert len(rows) > 1000  # as many as the page went on showing
        assert np.abs(rows["speed_rad_s"]).max() > 25.0
        raw = read_raw(folder / "raw.mcap")
        assert len(raw.record) == len(rows)
        assert [event["state"] for event in raw.events if event["state"] == "run"] == ["run"]
        manifest = next(json.loads(path.read_text()) for path in folder.glob("*.json"))
        assert manifest["recorded"]["rows"] == len(rows) and manifest["recorded"]["lost_rows"] == 0
        assert not list(place.glob("*.raw.mcap"))
        again = await page.ask("record")
        assert again["folder"] != began["folder"]

    with_scope(bench.port, work)
    assert len(list(place.glob("scope-*"))) == 2  # the end of the command has completed the second one


def test_other_signals_end_a_recording_with_the_reason_and_what_came_is_kept(bench, place: Path) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        folder = (await page.ask("record"))["folder"]
        await page.until(lambda: served.scope.session.recording.seconds > 0.2)
        await page.ask("watch", signals=["iq_a"], rate_hz=1000.0)
        ended = await page.got("recording", lambda message: message["folder"] and not message["on"])
        assert "the signals were changed" in ended["text"]
        assert len((place / folder / "recording.csv").read_text().splitlines()) > 100

    with_scope(bench.port, work)


def test_a_calibration_says_its_verdict_and_its_file_and_the_live_rows_come_again(bench, place: Path) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        names = [each["name"] for each in (await page.got("drive"))["procedures"]]
        assert names == ["offsets", "encoder", "rl", "mechanics", "cogging", "learning"] or set(names) >= {"offsets"}
        assert "error" not in await page.ask("calibrate", name="offsets")
        assert "a calibration is running" in (await page.ask("set", values={"rc_gain": 0.2}))["error"]
        lines = (await page.got("calibration", lambda message: message["status"] in ("good", "not good")))["lines"]
        assert any("offset that is left in phase a" in line for line in lines)
        assert lines[-1] == "Written: calibration-offsets.toml"
        assert tomlkit.parse((place / "calibration-offsets.toml").read_text())["calibration"] == "offsets"
        count = len(page.frames)
        await page.until(lambda: len(page.frames) > count + 5)
        assert served.feed.live.names == DEFAULT_SIGNALS

    with_scope(bench.port, work)


@pytest.mark.parametrize("how", ["the page", "a watcher", "the page goes away"])
def test_a_stop_ends_a_calibration_for_good_and_its_settings_are_put_back(bench, how: str) -> None:
    async def work(served: Served) -> None:
        page, watcher = await served.page(), await served.page()
        await page.state("ready")
        before = (await page.got("values", lambda message: message["values"]))["values"]
        assert "error" not in await page.ask("calibrate", name="mechanics")
        await page.state("run")
        watch, until_s = Stopwatch(), time.monotonic() + WAIT_S
        if how == "the page goes away":
            await page.close()
        else:
            assert "error" not in await (page if how == "the page" else watcher).ask("stop")
        while bench.server.drive.read("state") == RUN:
            assert time.monotonic() < until_s
            await asyncio.sleep(0.002)
        assert watch.quiet_s() < (1.0 if how == "the page goes away" else 0.3)
        until_s = time.monotonic() + 1.5  # and nothing of it starts the motor again
        while time.monotonic() < until_s:
            assert bench.server.drive.read("state") != RUN
            await asyncio.sleep(0.002)
        await watcher.got("calibration", lambda message: message["status"] == "stopped")
        await watcher.got("values", lambda message: message["values"] == before)
        await watcher.ask("take_control")
        await watcher.turn()  # and it can be started by hand

    with_scope(bench.port, work)


def test_an_unknown_calibration_is_refused_with_the_names_there_are(bench) -> None:
    async def work(served: Served) -> None:
        page = await served.page()
        await page.state("ready")
        assert "did you mean mechanics" in (await page.ask("calibrate", name="mechanic"))["error"]
        watcher = await served.page()
        assert "only watches" in (await watcher.ask("calibrate", name="offsets"))["error"]

    with_scope(bench.port, work)
