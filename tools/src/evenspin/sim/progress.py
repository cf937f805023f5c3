"""Progress on the terminal: a bar when it takes long and someone is watching."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

PATIENCE_S = 2.0


class Bar(Protocol):
    def update(self, done: float) -> None: ...

    def say(self, text: str) -> None: ...


class _Silent:
    def update(self, done: float) -> None:
        pass

    def say(self, text: str) -> None:
        pass


class _RichBar:
    """Draws nothing before PATIENCE_S have passed."""

    def __init__(self, text: str, total: float, patience_s: float) -> None:
        self.text, self.total = text, total
        self.since = time.monotonic()
        self.patience_s = patience_s
        self.bar: Progress | None = None
        self.task: TaskID  # of the bar

    def update(self, done: float) -> None:
        if self.bar is None and time.monotonic() - self.since >= self.patience_s:
            self._draw()
        if self.bar is not None:
            self.bar.update(self.task, completed=done)

    def say(self, text: str) -> None:
        """What is being done now."""
        self.text = text
        if self.bar is not None:
            self.bar.update(self.task, description=text)

    def _draw(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
        self.bar = Progress(*columns, console=Console(stderr=True), transient=True)
        self.task = self.bar.add_task(self.text, total=self.total)
        self.bar.start()

    def close(self) -> None:
        if self.bar is not None:
            self.bar.stop()


@contextmanager
def progress_bar(text: str, total: float, patience_s: float = PATIENCE_S) -> Iterator[Bar]:
    """A bar on stderr, or nothing at all where nobody is watching."""
    if not sys.stderr.isatty() or os.environ.get("EVENSPIN_QUIET"):
        yield _Silent()
        return
    bar = _RichBar(text, total, patience_s)
    try:
        yield bar
    finally:
        bar.close()
