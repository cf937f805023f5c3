"""The path of a stop: past everything else that is asked, and never behind other stops."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

AT_ONCE = 2  # the second need not wait when the answer to the first is lost


class Stopper:
    """Thousands may ask at the same time: they share the next stop that goes out. None of them gets one that went out
    before it was asked for, and so before a start that it is meant to end."""

    def __init__(self, stop: Callable[[], dict[str, Any]]) -> None:
        self._stop = stop
        self._pool = ThreadPoolExecutor(AT_ONCE, "scope stop")
        self._free = asyncio.Semaphore(AT_ONCE)
        self._next: asyncio.Task[dict[str, Any]] | None = None

    async def stop(self) -> dict[str, Any]:
        """Stop the motor. Returns the answer, {"error": text} when the drive did not confirm it."""
        if self._next is None:
            self._next = asyncio.create_task(self._go())
        return await asyncio.shield(self._next)

    async def _go(self) -> dict[str, Any]:
        async with self._free:
            self._next = None
            return await asyncio.get_running_loop().run_in_executor(self._pool, self._stop)

    def close(self) -> None:
        self._pool.shutdown(wait=False)
