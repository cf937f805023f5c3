"""Layouts by name, in Chromium: kept over a reload, taken away as a file, and refused when a file is not right."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser import Browser, missing
from hands import opened_page

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")

UNITS = (
    "return [...document.querySelectorAll('#view-live .pane')].map((p) => p.querySelector('[data-fold]').dataset.fold)"
)
FOLDED = "return [...document.querySelectorAll('#view-live .pane.folded [data-fold]')].map((b) => b.dataset.fold)"

UNTICK = """
const rows = [...document.querySelectorAll("#side-signals .signal")];
rows.find((row) => row.querySelector("code").innerText === arguments[0]).querySelector("input").click();
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with opened_page(tmp_path_factory.mktemp("registry")) as (browser, _):
        yield browser


def said(page: Browser) -> str:
    return page.text("#layouts-said")


def names(page: Browser) -> list[str]:
    return page.driver.execute_script(
        "return [...document.querySelectorAll('[data-layout]')].map((r) => r.dataset.layout)"
    )


def bring(page: Browser, path: Path, content: object) -> None:
    """A file for the page to import."""
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    page.driver.execute_script("document.querySelector('#layouts-said').textContent = ''")
    page.find("#layouts-file").send_keys(str(path))
    page.until(lambda: said(page) != "", "the page says what became of it")


def test_a_layout_brings_back_signals_views_trigger_cursors_and_panes(page: Browser, tmp_path: Path) -> None:
    page.until(lambda: int(page.data("#foot", "fps") or 0) > 0, "rows are drawn")
    page.choose("#window", "2 s")
    page.choose("#live-trigger", "normal")
    page.choose("#live-trigger-signal", "iq_a")
    page.type("#live-trigger-level", "0.5")
    page.press("#view-live [data-up=A]")
    page.press("#view-live [data-fold=V]")
    page.press("#view-live [data-cursors]")
    page.key("l")
    page.type("#layout-name", "tuning")
    page.until(lambda: said(page) == "Saved as tuning.", "saved")
    order = page.driver.execute_script(UNITS)
    assert order[:2] == ["A", "rad/s"]
    page.press("#layouts-close")

    page.press("[data-side=signals]")
    page.driver.execute_script(UNTICK, "vq_v")
    page.until(lambda: "7 signals" in page.text("#foot"), "one signal less")
    page.choose("#window", "10 s")
    page.choose("#live-trigger", "off")
    page.press("#view-live [data-fold=V]")
    page.press("#view-live [data-cursors]")
    page.driver.refresh()  # it is kept in the browser
    page.until_state("ready")
    page.until(lambda: "7 signals" in page.text("#foot"), "rows come")
    page.press("#show-layouts")
    page.press("[data-layout=tuning] [data-load]")
    page.until(lambda: said(page) == "tuning is in force.", "loaded")
    page.until(lambda: "8 signals" in page.text("#foot"), "the signal is back")
    assert page.find("#window").get_attribute("value") == "2"
    assert page.find("#live-trigger").get_attribute("value") == "normal"
    assert page.find("#live-trigger-signal").get_attribute("value") == "iq_a"
    assert page.find("#live-trigger-level").get_attribute("value") == "0.5"
    assert page.driver.execute_script(UNITS) == order
    assert page.driver.execute_script(FOLDED) == ["V"]
    page.until(lambda: page.find("#view-live [data-cursor=A]").is_displayed(), "the cursors are back")

    page.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    page.press("#layouts-export")
    file = tmp_path / "evenspin-layouts.json"
    page.until(file.exists, "the file is there")
    good = json.loads(file.read_text())
    assert list(good["layouts"]) == ["tuning"]
    assert good["layouts"]["tuning"]["live"]["panes"]["folded"] == ["V"]

    page.press("[data-layout=tuning] [data-delete]")
    page.press("#ask-do")
    page.until(lambda: names(page) == [], "deleted")

    def changed(**live: object) -> dict[str, object]:
        layout = good["layouts"]["tuning"]
        return good | {"layouts": {"tuning": layout | {"live": layout["live"] | live}}}

    for wrong, why in (
        ("junk", "is no JSON"),
        ([], "must be an object"),
        (good | {"format": "another"}, "file.format"),
        (good | {"version": 2}, "file.version = 2: must be one of 1"),
        (changed(seconds=3), "tuning.live.seconds = 3: must be one of 1, 2, 5"),
        (changed(sceonds=5), "tuning.live.sceonds: is no key here"),
        (changed(cursors={"on": True, "at": [0, 1e99]}), "tuning.live.cursors.at[1]"),
        (good | {"layouts": {"x": {}}}, "x.signals = missing"),
    ):
        bring(page, tmp_path / "wrong.json", wrong)
        assert why in said(page) and said(page).startswith("wrong.json: "), (wrong, said(page))
        assert names(page) == []

    other = json.loads(file.read_text())
    other["layouts"]["other"] = other["layouts"].pop("tuning") | {"signals": ["iq_a", "torque_of_another_drive"]}
    bring(page, tmp_path / "other.json", other)
    assert "other needs torque_of_another_drive, which this drive does not have" in said(page)
    page.press("[data-layout=other] [data-load]")
    page.until(lambda: "this drive has no signal torque_of_another_drive" in said(page), "not loaded")
    assert "8 signals" in page.text("#foot")
    bring(page, tmp_path / "good.json", good)
    assert said(page) == "Imported: tuning."
    page.press("[data-layout=tuning] [data-load]")
    page.until(lambda: said(page) == "tuning is in force.", "loaded")
