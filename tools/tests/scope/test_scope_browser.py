"""The page in Chromium, as a person at the bench uses it, on a virtual drive by the clock."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from browser import Browser, chromium, missing, scope_command
from evenspin.native import tables

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")

ESCAPE = "\ue00c"


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as made:
        yield made


@pytest.fixture
def page(browser: Browser, bench) -> Iterator[Browser]:
    with scope_command(bench.port) as address:
        browser.driver.get(address)
        browser.until_state("ready")
        yield browser
        assert browser.complaints() == []
        browser.driver.get("about:blank")


def speed_rad_s(page: Browser) -> float:
    return float(page.text("#view-live [data-signal=speed_rad_s] b").replace("−", "-"))


def turn(page: Browser) -> None:
    page.press("#arm")
    page.press("#start")
    page.until_state("run")


def test_a_first_day_at_the_bench(page: Browser, bench) -> None:
    """Connect, start, see the speed arrive, change a gain, capture, provoke a fault and read it, unplug, recover."""
    drive = bench.server.drive
    assert not page.find("#start").is_enabled()  # not armed
    page.type("#speed", "40")
    turn(page)
    page.until(lambda: abs(speed_rad_s(page) - 40.0) < 0.8, "the speed arrives")  # 2 %: a mean over 0.2 s of ripple
    assert abs(drive.read("true_speed_rad_s") - 40.0) < 2.0
    page.until(lambda: int(page.data("#foot", "fps") or 0) > 0, "frames are drawn")

    page.type("[data-parameter=rc_gain]", "99")
    page.until(lambda: "must be a number in 0 .. 10" in page.text("#side-parameters"), "the refusal says the limits")
    page.type("[data-parameter=speed_kp_a_per_unit]", "0.03")
    row = ".parameter:has([data-parameter=speed_kp_a_per_unit])"
    page.until(lambda: "changed" in page.find(row).get_attribute("class"), "the gain is marked as changed")

    page.press("[data-view=capture]")
    page.choose("#trigger", "rises above")
    page.choose("#trigger-signal", "speed_rad_s")
    page.type("#trigger-level", "45")  # Enter arms
    page.until(lambda: "Waiting for the trigger" in page.text("#capture-status"), "the capture waits")
    page.type("#speed", "60")
    page.until(lambda: page.text("#capture-status") == "Complete", "the capture is complete")
    assert "speed_rad_s rises above 45" in page.text("#capture-title")

    bench.do("input", name="dc_link_v", value=5.0)
    page.until_state("fault")
    advice = next(fault for fault in tables().faults if fault.name == "under_voltage")
    page.until(lambda: advice.check in page.text("[data-banner=fault]"), "the advice is on the page")
    assert advice.cause in page.text("[data-banner=fault]")
    bench.do("input", name="dc_link_v", value=24.0)
    page.press("#last-samples")
    page.until(lambda: "last samples before under_voltage" in page.text("#capture-title"), "the last samples are shown")
    page.press("#clear-fault")
    page.until_state("ready")
    page.until(lambda: page.text("[data-banner=fault]") == "", "the fault is no longer shown")

    page.press("[data-view=live]")
    turn(page)
    bench.do("unplug", seconds=1.0)
    page.until(lambda: "No drive" in page.text("#banners"), "the page says that the drive is gone")
    page.until_state("none")
    page.until_state("ready")
    page.until(lambda: page.text("#banners") == "", "all is well again")
    assert not page.find("#start").is_enabled()  # nothing starts by itself
    turn(page)


@pytest.mark.parametrize("typing", [False, True])
def test_escape_stops_also_while_somebody_types(page: Browser, typing: bool) -> None:
    turn(page)
    if typing:
        page.find("#find-parameter").send_keys("rc_")
    page.key(ESCAPE)
    page.until_state("ready")


def test_the_stop_button_is_never_covered(page: Browser) -> None:
    for view in ("live", "capture", "xy", "spectrum"):
        page.press(f"[data-view={view}]")
        on_top = page.driver.execute_script(
            "const r = document.querySelector('#stop').getBoundingClientRect();"
            "return document.elementFromPoint(r.left + r.width / 2, r.top + r.height / 2).closest('#stop') !== null"
            " && r.top >= 0 && r.bottom <= innerHeight && document.documentElement.scrollHeight <= innerHeight"
        )
        assert on_top, view
        page.key("?")  # the list of keys, from the first view on


def test_a_second_page_watches_and_can_stop(page: Browser) -> None:
    turn(page)
    first = page.driver.current_window_handle
    address = page.driver.current_url
    page.driver.switch_to.new_window("tab")
    page.driver.get(address)
    page.until_state("run")
    page.until(lambda: "Watching" in page.text("#banners"), "the second page says that it watches")
    assert not page.find("[data-parameter=rc_gain]").is_enabled()
    page.press("#stop")
    page.until_state("ready")
    page.driver.close()
    page.driver.switch_to.window(first)


def test_what_is_shown_can_be_taken_away_as_csv_and_as_a_picture(page: Browser, tmp_path: Path) -> None:
    allow = {"behavior": "allow", "downloadPath": str(tmp_path)}
    page.driver.execute_cdp_cmd("Browser.setDownloadBehavior", allow)
    page.until(lambda: int(page.data("#foot", "fps") or 0) > 0, "rows are drawn")
    page.press("#export-csv")
    page.press("#export-png")
    page.until(lambda: {path.name for path in tmp_path.iterdir()} >= {"live.csv", "live.png"}, "both files are there")
    assert (tmp_path / "live.csv").read_text().startswith("t_s,speed_ref_rad_s,")
    assert (tmp_path / "live.png").read_bytes()[1:4] == b"PNG"


def test_the_page_says_when_the_scope_has_ended_and_that_the_next_one_has_another_address(
    browser: Browser, bench
) -> None:
    with scope_command(bench.port) as address:
        browser.driver.get(address)
        browser.until_state("ready")
    browser.until(lambda: "No connection to the scope" in browser.text("#banners"), "the page says so")
    assert not browser.find("#arm").is_enabled()
    port = urlsplit(address).port
    with scope_command(bench.port, http_port=port) as second:
        browser.until(lambda: "The scope was started again" in browser.text("#banners"), "the page says what to do")
        assert second != address and urlsplit(second).port == port
        browser.driver.get(second)
        browser.until_state("ready")
        browser.until(lambda: browser.text("#banners") == "", "all is well again")
    browser.driver.get("about:blank")
    browser.complaints()


def test_a_plot_of_few_pixels_shows_every_peak_and_every_gap(page: Browser) -> None:
    script = """
        const done = arguments[0];
        import('/static/ring.js').then(({ Ring }) => {
            const ring = new Ring(['a']), t = [], a = [];
            for (let k = 0; k < 200000; k++) { t.push(k / 1000); a.push(k === 150250 ? 50 : k === 150740 ? -60 : 1); }
            a.fill(NaN, 180000, 181000);
            ring.append(Float64Array.from(t), [Float32Array.from(a)]);
            const from100 = ring.window(100, 199.999, 500, 199.999);
            const some = ring.window(150.2, 150.3, 500);
            done([from100.t.length, Math.max(...from100.columns[0]), Math.min(...from100.columns[0]),
                  from100.t[from100.columns[0].indexOf(50)], from100.columns[0].filter((v) => v === null).length,
                  some.t.length, ring.mean('a', 1)]);
        });
    """
    points, high, low, at_s, gap, few, mean = page.driver.execute_async_script(script)
    assert 1000 <= points <= 1002  # a pair for each of 500 pixels, and one where the window cuts a stretch in two
    assert (high, low) == (50.0, -60.0)
    assert abs(at_s - (150.25 - 199.999)) <= 0.2  # a pixel
    assert gap in (8, 10)  # 1 s of 100 s in 500 pixels, two points each; the first and the last may hold other rows
    assert few in (100, 101)  # so few rows are shown as they are
    assert mean == 1.0


def test_spectrum_and_ripple_are_shown_over_the_angle(page: Browser) -> None:
    turn(page)
    page.press("[data-view=spectrum]")
    page.until(lambda: "order" in page.text("#spectrum-lines"), "lines in orders")
    page.press("[data-view=xy]")
    page.press("#xy-ripple")
    page.until(lambda: page.find("#xy-x").get_attribute("value") == "theta_m_rad", "the angle is the x axis")
    page.until(lambda: page.find("#view-xy .plot").is_displayed(), "there is something to see")
