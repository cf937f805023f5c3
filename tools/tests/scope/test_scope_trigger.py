"""The trigger of the live trace, in Chromium: the picture stands where the drive crossed the level."""

from __future__ import annotations

import pytest
from browser import Browser, missing
from hands import drag, figure, table

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")

LEVEL = 45.0  # rad/s; a drive at 30 has a ripple of 1.1


def status(page: Browser) -> str:
    return page.text("#live-trigger-status")


def speed_to(page: Browser, speed: str) -> None:
    page.type("#speed", speed)
    page.until(
        lambda: abs(figure(page.text("#view-live [data-signal=speed_rad_s] b")) - float(speed)) < 1.0, f"{speed} rad/s"
    )


def cursors(page: Browser) -> list[list[float]]:
    """[time, speed] at A and at B."""
    heads, *rows = table(page, "#view-live .cursors")
    column = heads.index("speed_rad_s\nrad/s")
    return [[figure(row[1]), figure(row[column])] for row in rows[:2]]


def test_the_trace_stands_where_the_level_was_crossed(page: Browser) -> None:
    page.choose("#window", "1 s")
    page.choose("#live-trigger", "single")
    page.choose("#live-trigger-signal", "speed_rad_s")
    page.type("#live-trigger-level", str(LEVEL))
    speed_to(page, "30")
    assert status(page) == "waiting"
    speed_to(page, "60")
    page.until(lambda: status(page).startswith("stands"), "it has triggered")
    page.key("x")
    over = "#view-live .pane .u-over"
    drag(page, "#view-live [data-cursor=A]", over, 0.2)  # the trigger is a fifth from the left
    drag(page, "#view-live [data-cursor=B]", over, 0.1)
    page.until(lambda: cursors(page)[1][0] < -0.05, "both cursors are placed")
    (at_s, speed), (before_s, speed_before) = cursors(page)
    width = page.driver.execute_script(f"return document.querySelector('{over}').clientWidth")
    assert (at_s, before_s) == pytest.approx((0.0, -0.1), abs=2.0 / width)
    # The step from 30 to 60 takes some ten milliseconds; a pixel is 1.2 ms.
    assert speed == pytest.approx(LEVEL, abs=6.0)
    assert speed_before == pytest.approx(30.0, abs=2.0)
    seen = cursors(page)
    speed_to(page, "30")
    speed_to(page, "60")  # it would trigger again
    assert cursors(page) == seen
    assert status(page).startswith("stands")
    page.key("r")
    page.until(lambda: status(page) == "waiting", "armed again")
    page.key("x")


def test_normal_takes_each_crossing_of_its_edge_and_auto_rolls_without_one(page: Browser) -> None:
    page.choose("#live-trigger", "normal")
    page.choose("#live-trigger-edge", "falls below")
    speed_to(page, "60")
    speed_to(page, "30")
    page.until(lambda: status(page) == "triggered", "the falling edge")
    page.key("x")
    page.until(lambda: cursors(page)[1][1] == pytest.approx(60.0, abs=2.0), "60 rad/s before it")
    speed_to(page, "60")
    assert cursors(page)[1][1] == pytest.approx(60.0, abs=2.0)  # the last picture stays
    assert status(page) == "triggered"
    page.choose("#live-trigger", "auto")
    page.until(lambda: status(page) == "rolling: no trigger", "it rolls")
    page.choose("#live-trigger", "off")
    page.until(lambda: status(page) == "", "off")
    page.key("x")
