"""One page for the tests of a file, with the drive behind it, and what hands do on it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from browser import Browser, chromium, scope_command
from selenium.webdriver.common.action_chains import ActionChains
from virtual_bench import Bench, running_bench


@contextmanager
def opened_page(registry: Path, model: str = "sim:guo2024") -> Iterator[tuple[Browser, Bench]]:
    """A browser, a scope and a drive. At the end the console must not have complained."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_RUNTIME_DIR", str(registry))
        with running_bench(model) as bench, scope_command(bench.port) as address, chromium(frames_hz=None) as browser:
            browser.driver.get(address)
            browser.until_state("ready")
            yield browser, bench
            complaints = browser.complaints()
            assert not complaints, complaints


def turn(page: Browser) -> None:
    page.press("#arm")
    page.press("#start")
    page.until_state("run")


def figure(text: str) -> float:
    """A number as the page writes it."""
    return float(text.replace("−", "-").replace(" %", ""))


def drag(page: Browser, handle: str, to: str, part: float) -> None:
    """With the mouse, to a part of the width of the element `to`."""
    page.until(lambda: page.find(handle).is_displayed(), f"{handle} is there")  # from the next frame on
    place = page.driver.execute_script(
        "const r = document.querySelector(arguments[0]).getBoundingClientRect(); return [r.left, r.width]", to
    )
    grip = page.find(handle)
    at = page.driver.execute_script("const r = arguments[0].getBoundingClientRect(); return r.left + r.width / 2", grip)
    by = round(place[0] + part * place[1] - at)
    ActionChains(page.driver).move_to_element(grip).click_and_hold().move_by_offset(by, 3).release().perform()
    page.until_drawn()


def table(page: Browser, css: str) -> list[list[str]]:
    """Texts of its cells, row by row."""
    script = (
        "return [...document.querySelectorAll(arguments[0] + ' tr')].map((r) => [...r.cells].map((c) => c.innerText))"
    )
    return page.driver.execute_script(script, css)
