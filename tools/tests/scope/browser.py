"""Headless Chromium with nothing of this user's in it, offline but for the page."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
)  # fmt: skip
WAIT_S = 30.0
# A display of fewer than 60 frames a second: drawing takes most of the processor time of a test.
FEWER_FRAMES = """
const everyFrame = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (draw) => setTimeout(() => everyFrame(draw), 1000 / %d);
window.cancelAnimationFrame = clearTimeout;
"""


def missing() -> str:
    """What a browser test lacks here, or ""."""
    try:
        import selenium  # noqa: F401
    except ImportError:
        return "selenium is not installed; `make setup` installs it"
    absent = [name for name in ("chromium", "chromedriver") if shutil.which(name) is None]
    return f"{' and '.join(absent)} not installed; `make setup` says how" if absent else ""


class Browser:
    """A page as a person uses it: look for something, press it, wait until it says something."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver

    def find(self, css: str) -> Any:
        from selenium.webdriver.common.by import By

        return self.driver.find_element(By.CSS_SELECTOR, css)

    def press(self, css: str) -> None:
        self.until(lambda: self.find(css).is_enabled(), f"{css} can be pressed")
        self.find(css).click()

    def type(self, css: str, text: str) -> None:
        from selenium.webdriver.common.keys import Keys

        field = self.find(css)
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(text, Keys.ENTER)

    def choose(self, css: str, text: str) -> None:
        """From a list of choices, with the mouse."""
        from selenium.webdriver.common.action_chains import ActionChains

        self.find(css).click()
        options = self.driver.find_elements("css selector", "select.choice option")
        wanted = next(option for option in options if option.text == text)
        ActionChains(self.driver).move_to_element(wanted).click().perform()

    def resize(self, width: int, height: int = 800) -> None:
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        self.until(lambda: self.driver.execute_script("return innerWidth") == width, f"{width} px wide")

    def keys(self, css: str, *keys: str) -> None:
        """To an element, as soon as it takes any: while its plot is drawn again it is not there."""
        self.until(lambda: self.find(css).send_keys(*keys) is None, f"{css} takes keys")

    def key(self, key: str) -> None:
        from selenium.webdriver.common.action_chains import ActionChains

        ActionChains(self.driver).send_keys(key).perform()

    def text(self, css: str) -> str:
        """What stands there, or "" when it is not there."""
        return self.driver.execute_script("return document.querySelector(arguments[0])?.innerText ?? ''", css)

    def data(self, css: str, name: str) -> str:
        script = "return document.querySelector(arguments[0])?.dataset[arguments[1]] ?? ''"
        return self.driver.execute_script(script, css, name)

    def until(self, true: Callable[[], Any], what: str, wait_s: float = WAIT_S) -> None:
        from selenium.common.exceptions import WebDriverException

        until_s = time.monotonic() + wait_s
        while True:
            try:
                if true():
                    return
            except WebDriverException:
                pass  # it was replaced in between
            assert time.monotonic() < until_s, f"not within {wait_s:g} s: {what}; banners: {self.text('#banners')!r}"
            time.sleep(0.03)

    def until_drawn(self) -> None:
        """What was done with the hand is on the page: drawn with the next frame, or the one after that."""
        frame = "requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(() => done())))"
        self.driver.execute_async_script(f"const done = arguments[0]; {frame}")

    def until_state(self, name: str) -> None:
        self.until(lambda: self.data("#state", "state") == name, f"state {name}")

    def complaints(self) -> list[str]:
        """What the console says is wrong, but for a connection that the test cut."""
        return [entry["message"] for entry in self.driver.get_log("browser") if "WebSocket" not in entry["message"]]


@contextmanager
def chromium(width: int = 1280, height: int = 800, frames_hz: int | None = 10) -> Iterator[Browser]:
    """`frames_hz`: of the display, about; None leaves it as it is."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        options = webdriver.ChromeOptions()
        for flag in (*FLAGS, f"--user-data-dir={profile}", f"--window-size={width},{height}"):
            options.add_argument(flag)
        options.binary_location = shutil.which("chromium") or ""
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
        try:
            driver.execute_cdp_cmd(
                "Emulation.setDeviceMetricsOverride",
                {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
            )
            if frames_hz is not None:
                source = {"source": FEWER_FRAMES % frames_hz}
                driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", source)
            yield Browser(driver)
        finally:
            driver.quit()


@contextmanager
def scope_command(port: str, http_port: int | str = 0) -> Iterator[str]:
    """`evenspin scope` in a process of its own; the address of the page."""
    words = [sys.executable, "-c", "from evenspin.cli import main; main()", "scope"]
    words += ["--port", port, "--http-port", str(http_port)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        assert process.stdout is not None
        yield process.stdout.readline().strip()
    finally:
        process.terminate()
        process.wait(10.0)
