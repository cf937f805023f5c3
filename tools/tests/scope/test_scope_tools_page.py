"""Recording, parameters as a file and a calibration by hand on the page, in Chromium."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser import Browser, missing
from hands import opened_page, turn
from selenium.webdriver.common.keys import Keys
from virtual_bench import Bench

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")

RUN = 4


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which the command runs."""
    return tmp_path_factory.mktemp("here")


@pytest.fixture(scope="module")
def opened(here: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Browser, Bench]]:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(here)
        with opened_page(tmp_path_factory.mktemp("registry")) as both:
            both[0].press("[data-side=tools]")
            yield both


def test_a_key_records_and_the_page_says_where_the_rows_are(opened: tuple[Browser, Bench], here: Path) -> None:
    page, _ = opened
    page.key("o")
    page.until(lambda: page.text("#record-said").startswith("Recording into scope-"), "it records")
    page.until(lambda: page.text("#record") == "End recording", "it can be ended")
    time.sleep(1.0)
    page.key("o")
    page.until(lambda: page.text("#record") == "Record", "it has ended")
    folder = next(here.glob("scope-*"))
    assert f"rows in {folder}/recording.csv" in page.text("#record-said")
    assert len((folder / "recording.csv").read_text().splitlines()) > 100


def test_a_file_is_loaded_after_its_changes_were_shown(opened: tuple[Browser, Bench], tmp_path: Path) -> None:
    page, _ = opened
    page.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    page.press("#config-save")
    file = tmp_path / "drive.toml"
    page.until(file.exists, "the file is there")
    lines = file.read_text().splitlines()
    place = next(i for i, line in enumerate(lines) if line.startswith("rc_gain = "))
    before = float(lines[place].split()[2])
    lines[place] = "rc_gain = 0.125"
    file.write_text("\n".join(lines) + "\n")
    page.find("#config-file").send_keys(str(file))
    page.until(lambda: "Load 1 values from drive.toml?" in page.text("#ask"), "it asks first")
    assert f"rc_gain: {before:g} → 0.125" in page.text("#ask")
    page.press("#ask-do")
    page.until(lambda: "1 values are in force" in page.text("#config-said"), "loaded")
    assert page.find("[data-parameter=rc_gain]").get_attribute("value") == "0.125"
    file.write_text("rc_gain = 1\n")
    page.find("#config-file").send_keys(str(file))
    page.until(lambda: page.text("#config-said").startswith("drive.toml"), "the refusal names the file")
    page.press("[data-side=parameters]")
    page.press("[data-command=undo]")
    page.until(lambda: page.find("[data-parameter=rc_gain]").get_attribute("value") == f"{before:g}", "undone")
    page.press("[data-side=tools]")


def test_the_stop_key_ends_a_calibration(opened: tuple[Browser, Bench]) -> None:
    page, bench = opened
    page.choose("#calibration", "mechanics")
    page.press("#calibrate")
    assert "The shaft must be free" in page.text("#ask")
    page.press("#ask-do")
    page.until_state("run")
    page.key(Keys.SPACE)
    page.until(lambda: bench.server.drive.read("state") != RUN, "the motor is off", wait_s=1.0)
    page.until(lambda: page.text("#calibration-said").startswith("Stopped"), "the page says so")
    assert page.find("#calibrate").is_enabled()


def test_a_frequency_response_is_drawn_with_its_points_and_goes_away_as_csv(
    opened: tuple[Browser, Bench], tmp_path: Path
) -> None:
    page, _ = opened
    page.key("5")
    assert not page.find("#bode-start").is_enabled()  # the motor stands
    page.type("#speed", "30")
    turn(page)
    page.until(lambda: float(page.text("[data-read='speed_rad_s rad/s']").split()[1]) > 29.0, "at speed")
    for field, value in (("first", "50"), ("last", "150"), ("points", "2"), ("amplitude", "2,0")):
        page.type(f"#bode-{field}", value)
    page.press("#bode-start")
    page.until(lambda: page.data("#bode-said", "status") == "done", "measured")
    assert "2 of 2 points are good" in page.text("#bode-said")
    assert "plant / rad/s per A" in page.text("#bode-legend")
    assert len(page.driver.find_elements("css selector", ".bode-plot canvas")) == 3
    page.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    page.key("e")
    page.until((tmp_path / "bode.csv").exists, "the points are a file")
    rows = (tmp_path / "bode.csv").read_text().splitlines()
    assert rows[0].startswith("f_hz,plant_gain,plant_phase_deg,plant_coherence") and len(rows) == 3
    page.key(Keys.SPACE)
    page.key("1")
