"""Times on a machine that does other work, too: a test that waits for its turn is not slow."""

from __future__ import annotations

import time

WORK_S = 0.05  # of processor time


def slowness() -> float:
    """How much longer work takes now than on a machine that does nothing else: 1 or more."""
    began, worked = time.perf_counter(), time.process_time()
    while time.process_time() - worked < WORK_S:
        pass
    return max(1.0, (time.perf_counter() - began) / WORK_S)


class Stopwatch:
    """Seconds since it was made, as a machine without other work would have needed them.

    It looks at both ends how busy the machine is, and takes the busier one.
    """

    def __init__(self) -> None:
        self._slowness = slowness()
        self._began_s = time.monotonic()

    def quiet_s(self) -> float:
        took_s = time.monotonic() - self._began_s
        return took_s / max(self._slowness, slowness())
