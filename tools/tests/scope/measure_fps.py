"""Frames per second of the page with 8 signals at 1 kHz, in headless Chromium on this machine.

    measure_fps.py [SECONDS]

Exit status: 0 at least 30 in every second, 1 fewer, 3 no browser.
"""

from __future__ import annotations

import statistics
import sys
import time

from browser import chromium, missing, scope_command

GOAL_FPS = 30
SIZES = ((1280, 800), (1920, 1080))


def main(seconds: float) -> int:
    if missing():
        print(f"scope-fps: {missing()}", file=sys.stderr)
        return 3
    good = True
    for width, height in SIZES:
        with scope_command("sim:guo2024") as address, chromium(width, height, frames_hz=None) as page:
            page.driver.get(address)
            page.until_state("ready")
            page.press("#arm")
            page.press("#start")
            page.until_state("run")
            time.sleep(6.0)  # the window of 5 s is full
            counted = []
            for _ in range(max(1, round(seconds))):
                time.sleep(1.0)
                counted.append(int(page.data("#foot", "fps")))
            lost = int(page.data("#foot", "lost"))
        good &= min(counted) >= GOAL_FPS and lost == 0
        print(
            f"{width} x {height}: {statistics.median(counted):g} frames/s in the median, {min(counted)} at least, over "
            f"{len(counted)} s with 8 signals at 1 kHz; {lost} rows lost; goal {GOAL_FPS}"
        )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0))
