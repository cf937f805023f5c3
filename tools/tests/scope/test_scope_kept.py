"""Before and after, in Chromium: what was kept lies beneath what is shown, and the change stands there in figures."""

from __future__ import annotations

import io
import urllib.request
from urllib.parse import urlsplit

import numpy as np
import pytest
from browser import Browser, missing
from hands import figure, table

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")

PIXELS = "return document.querySelector('#view-live canvas').toDataURL()"


def exported(page: Browser, seconds: float) -> dict[str, np.ndarray]:
    address = urlsplit(page.driver.current_url)
    place = f"http://{address.netloc}/export/live.csv?seconds={seconds}&{address.query}"
    with urllib.request.urlopen(place) as answer:
        rows = np.genfromtxt(io.StringIO(answer.read().decode()), delimiter=",", names=True)
    return {name: rows[name] for name in rows.dtype.names}


def compared(page: Browser, view: str) -> dict[str, list[str]]:
    """[kept, now, change] by the first line of the head of the column."""
    rows = table(page, f"#view-{view} .kept")
    return {head.split("\n")[0]: [row[i] for row in rows[1:]] for i, head in enumerate(rows[0]) if i} if rows else {}


def test_lines_of_a_spectrum_are_compared_with_those_that_were_kept(page: Browser) -> None:
    page.until(lambda: exported(page, 5.0)["speed_rad_s"].min() > 25.0, "5 s at a steady speed", wait_s=30.0)
    page.press("[data-view=spectrum]")
    page.until(lambda: "order" in page.text("#spectrum-lines"), "lines in orders")
    page.key("k")
    page.until(lambda: "rms" in compared(page, "spectrum"), "figures")
    speed = exported(page, 5.0)["speed_rad_s"]
    kept = compared(page, "spectrum")
    # Whole turns under a window instead of all rows: a few per cent of a ripple that hardly changes.
    assert figure(kept["rms"][0]) == pytest.approx(speed.std(), rel=0.1)
    assert figure(kept["1.000"][0]) == pytest.approx(figure(table(page, "#spectrum-lines")[1][1]), rel=0.05)
    page.type("#speed", "60")
    page.until(lambda: figure(compared(page, "spectrum")["1.000"][1]) < 0.8 * figure(kept["1.000"][0]), "less ripple")
    before, now, change = compared(page, "spectrum")["1.000"]
    assert before == kept["1.000"][0]
    assert figure(change) == pytest.approx(100.0 * (figure(now) / figure(before) - 1.0), abs=0.6)
    page.choose("#spectrum-axis", "hertz")
    page.until(lambda: "not what is shown" in page.text("#view-spectrum .kept"), "orders and hertz do not compare")
    page.press("#view-spectrum [data-forget]")
    assert not page.find("#view-spectrum .kept").is_displayed()


def test_a_live_picture_that_was_kept_lies_beneath_the_present_one(page: Browser) -> None:
    page.press("[data-view=live]")
    page.choose("#window", "1 s")
    page.type("#speed", "60")
    page.until(lambda: abs(figure(page.text("#view-live [data-signal=speed_rad_s] b")) - 60.0) < 1.0, "60 rad/s")
    page.key("k")
    page.until(lambda: "speed_rad_s" in compared(page, "live"), "figures")
    kept = compared(page, "live")["speed_rad_s"][0]
    page.type("#speed", "30")
    page.until(lambda: abs(figure(page.text("#view-live [data-signal=speed_rad_s] b")) - 30.0) < 1.0, "30 rad/s")

    def rms_is_that_of_the_export() -> bool:
        steady = exported(page, 1.0)["speed_rad_s"].std()
        return steady < 2.0 and figure(compared(page, "live")["speed_rad_s"][1]) == pytest.approx(steady, rel=0.1)

    page.until(rms_is_that_of_the_export, "the step has left the window, and the figures follow")
    before, now, change = compared(page, "live")["speed_rad_s"]
    assert before == kept
    assert figure(change) == pytest.approx(100.0 * (figure(now) / figure(before) - 1.0), rel=0.02, abs=0.6)
    page.key("p")
    with_it = page.driver.execute_script(PIXELS)
    page.press("#view-live [data-forget]")
    page.until(lambda: page.driver.execute_script(PIXELS) != with_it, "it is no longer beneath")
    page.key("p")
