"""The page of a run in headless Chromium: its pictures can be zoomed, it fits a phone, and it prints."""

import browser
import pytest
from evenspin.cli import main

pytestmark = pytest.mark.skipif(bool(browser.missing()), reason=browser.missing())

WIDTHS = "return [document.documentElement.scrollWidth, innerWidth]"
RANGE = "return [uPlot.sync('time').plots.map((plot) => plot.scales.x.max)]"


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    text = 'name = "r"\nmodel = "guo2024"\nduration_s = 0.5\n[[event]]\nat_s = 0.0\nspeed_rpm = 300.0\n'
    (folder / "r.toml").write_text(text)
    with pytest.raises(SystemExit):
        main(["run", str(folder / "r.toml"), "--out", str(folder / "out")])
    return folder / "out" / "report.html"


def test_pictures_of_a_report_are_drawn_zoomed_together_and_printed_still(report):
    with browser.chromium() as page:
        page.driver.get(report.as_uri())
        charts = page.driver.execute_script("return document.querySelectorAll('script.chart').length")

        assert page.driver.execute_script("return document.querySelectorAll('.live canvas').length") >= charts > 2
        before = page.driver.execute_script(RANGE)[0]
        _drag(page)
        after = page.driver.execute_script(RANGE)[0]
        assert len(after) == 2 and all(new < 0.8 * old for new, old in zip(after, before, strict=True))
        page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        assert page.driver.execute_script("return getComputedStyle(document.querySelector('.live')).display") == "none"
        assert page.find(".still svg").is_displayed()
        assert page.complaints() == []


def test_a_report_fits_a_phone_in_both_themes(report):
    with browser.chromium() as page:
        dark = {"features": [{"name": "prefers-color-scheme", "value": "dark"}]}
        page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", dark)
        page.driver.get(report.as_uri())
        page.resize(400)

        def fits() -> bool:
            wide, room = page.driver.execute_script(WIDTHS)
            return wide <= room

        page.until(fits, "the page is no wider than the window")  # pictures follow with the next frame
        assert "rgb(18, 22, 26)" in page.driver.execute_script("return getComputedStyle(document.body).backgroundColor")
        assert page.complaints() == []


def _drag(page):
    """A zoom with the mouse, over the middle of the first picture."""
    from selenium.webdriver.common.action_chains import ActionChains

    over = page.find(".live .u-over")
    ActionChains(page.driver).move_to_element_with_offset(over, -100, 0).click_and_hold().move_by_offset(
        200, 0
    ).release().perform()
