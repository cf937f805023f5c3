"""Two cursors and what lies between them, on a page in Chromium; the expected figures are those of an export."""

from __future__ import annotations

import io
import re
import urllib.request
from urllib.parse import urlsplit

import numpy as np
import pytest
from browser import Browser, missing
from hands import drag, figure, table
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")


def exported(page: Browser, source: str) -> dict[str, np.ndarray]:
    address = urlsplit(page.driver.current_url)
    with urllib.request.urlopen(f"http://{address.netloc}/export/{source}.csv?{address.query}") as answer:
        rows = np.genfromtxt(io.StringIO(answer.read().decode()), delimiter=",", names=True)
    return {name: rows[name] for name in rows.dtype.names}


def between(page: Browser, view: str) -> dict[str, str]:
    return dict(re.findall(r"(\S+) = (\S+ ?\S*)", page.text(f"#view-{view} .between")))


def test_on_the_live_trace_the_cursors_stand_while_it_moves_and_show_their_difference(page: Browser) -> None:
    page.press("[data-view=live]")
    page.until(lambda: int(page.data("#foot", "fps") or 0) > 0, "rows are drawn")
    page.key("x")
    over = "#view-live .pane .u-over"
    drag(page, "#view-live [data-cursor=A]", over, 0.80)
    drag(page, "#view-live [data-cursor=B]", over, 0.90)
    page.until(lambda: "Δt" in page.text("#view-live .between"), "the distance is shown")
    width = page.driver.execute_script(f"return document.querySelector('{over}').clientWidth")
    dt_s = figure(between(page, "live")["Δt"].split()[0]) / 1000.0
    assert dt_s == pytest.approx(0.5, abs=2.0 * 5.0 / width)  # a tenth of 5 s, two pixels
    assert figure(between(page, "live")["1/Δt"].split()[0]) == pytest.approx(1.0 / dt_s, rel=2e-3)
    heads, *rows = table(page, "#view-live .cursors")
    assert heads[1:3] == ["t\ns", "speed_ref_rad_s\nrad/s"]
    assert [row[0] for row in rows] == ["A", "B", "B − A"]
    assert [figure(row[1]) for row in rows] == pytest.approx([-1.0, -0.5, 0.5], abs=2.0 * 5.0 / width)
    for column in range(2, len(heads)):
        a, b, difference = (figure(row[column]) for row in rows)
        assert difference == pytest.approx(b - a, abs=1.6e-4 * max(abs(a), abs(b), 1.0)), heads[column]
    speed = heads.index("speed_rad_s\nrad/s")
    page.until(lambda: abs(figure(table(page, "#view-live .cursors")[2][speed]) - 30.0) < 1.0, "the trace moves on")


def test_in_a_capture_they_show_the_rows_that_the_drive_recorded(page: Browser) -> None:
    page.press("[data-view=capture]")
    page.press("#capture-arm")
    page.until(lambda: page.text("#capture-status") == "Complete", "captured")
    page.press("#view-capture [data-cursors]")
    over = "#view-capture .pane .u-over"
    drag(page, "#view-capture [data-cursor=A]", over, 0.20)
    drag(page, "#view-capture [data-cursor=B]", over, 0.60)
    page.keys("#view-capture [data-cursor=B]", Keys.ARROW_RIGHT, Keys.SHIFT, Keys.ARROW_RIGHT)
    page.until_drawn()
    page.until(lambda: "Δt" in page.text("#view-capture .between"), "the distance is shown")
    rows = exported(page, "capture")
    heads, a, b, difference = table(page, "#view-capture .cursors")
    pixel_ms = (
        1000.0 * rows["t_s"][-1] / page.driver.execute_script(f"return document.querySelector('{over}').clientWidth")
    )
    assert [figure(a[1]), figure(b[1])] == pytest.approx(
        [200.0 * rows["t_s"][-1], 600.0 * rows["t_s"][-1] + 21.0 * pixel_ms], abs=2.0 * pixel_ms
    )
    assert figure(difference[1]) == pytest.approx(figure(b[1]) - figure(a[1]), abs=0.002)
    for name in ("iq_a", "speed_rad_s"):
        column = next(i for i, head in enumerate(heads) if head.startswith(f"{name}\n"))
        at = [rows[name][np.argmin(np.abs(1000.0 * rows["t_s"] - figure(row[1])))] for row in (a, b)]
        assert [figure(a[column]), figure(b[column])] == pytest.approx(at, rel=1e-3, abs=1e-3), name
        assert figure(difference[column]) == pytest.approx(at[1] - at[0], rel=1e-3, abs=2e-3), name
    # A drag that begins on a cursor moves it and zooms nothing; one beside it zooms, and a cursor outside is hidden.
    assert page.driver.execute_script("return document.querySelector('#view-capture .u-select').clientWidth") == 0
    plot = page.find(over)
    width = plot.size["width"]
    ActionChains(page.driver).move_to_element_with_offset(plot, int(-0.1 * width), 20).click_and_hold().move_by_offset(
        int(0.35 * width), 0
    ).release().perform()
    page.until(lambda: not page.find("#view-capture [data-cursor=A]").is_displayed(), "A is outside")
    assert page.find("#view-capture [data-cursor=B]").is_displayed()
    page.key("x")
    page.key("x")
    page.until(lambda: page.find("#view-capture [data-cursor=A]").is_displayed(), "both are brought back")


def test_in_the_spectrum_they_stand_on_lines(page: Browser) -> None:
    page.press("[data-view=spectrum]")
    page.choose("#spectrum-source", "capture")
    page.choose("#spectrum-axis", "hertz")
    page.until(lambda: "frequency" in page.text("#spectrum-lines"), "lines in hertz")
    page.key("x")
    rows = exported(page, "capture")
    speed = rows["speed_rad_s"]
    line = 10_000.0 / len(speed)  # Hz between two lines
    largest = [figure(row[1]) for row in table(page, "#spectrum-lines")]
    width = page.driver.execute_script("return document.querySelector('#view-spectrum .u-over').clientWidth")
    beside = largest[0] / 5_000.0 + 3.0 / width  # a few pixels: a mouse does not hit a line
    drag(page, "#view-spectrum [data-cursor=A]", "#view-spectrum .u-over", beside)
    drag(page, "#view-spectrum [data-cursor=B]", "#view-spectrum .u-over", 0.3)
    page.keys("#view-spectrum [data-cursor=B]", Keys.SHIFT, Keys.ARROW_LEFT)
    page.until_drawn()
    page.until(lambda: "Δf" in page.text("#view-spectrum .between"), "the distance is shown")
    _, a, b, difference = table(page, "#view-spectrum .cursors")
    f_hz = figure(b[1])
    assert [figure(a[1]), figure(a[2])] == pytest.approx(largest[:2], rel=1e-3)  # four figures there
    assert f_hz / line == pytest.approx(round(f_hz / line), rel=5e-5) and f_hz > 0.0  # five figures
    assert figure(difference[1]) == pytest.approx(f_hz - figure(a[1]), abs=0.2)
    # A Hann window, and single lines of the transform by hand; the page writes four places.
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(len(speed)) / len(speed))
    for row in (a, b):
        nearest_hz = line * round(figure(row[1]) / line)
        turning = np.exp(-2j * np.pi * nearest_hz * np.arange(len(speed)) / 10_000.0)
        amplitude = 2.0 * abs(np.sum((speed - speed.mean()) * window * turning)) / window.sum()
        assert figure(row[2]) == pytest.approx(amplitude, rel=1e-3, abs=6e-5)
