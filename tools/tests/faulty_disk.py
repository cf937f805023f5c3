"""A disk on which the Nth thing that is done to it goes wrong: an error of the system, or the end of the process.

Every change below one folder is a step: a file opened for writing, a block written, a name made, changed or removed, a
sync. Files are real and buffered as always; only the calls that Python makes of the system are counted.
"""

from __future__ import annotations

import builtins
import errno
import io
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import evenspin.output.staging as staging
import pytest

# What needs space: on a full disk it goes on failing, while names can be changed and removed.
NEEDS_SPACE = frozenset({"open", "write", "mkdir", "link", "create"})


class Disk:
    """`at`: the step that fails, from 1; None: none does, and they are only counted."""

    def __init__(self, root: Path, at: int | None, error: int = errno.ENOSPC, *, kill: bool = False) -> None:
        self.root, self.at, self.error, self.kill = root.resolve(), at, error, kill
        self.steps: list[tuple[str, str]] = []
        self.full = False

    def step(self, what: str, path: Any) -> None:
        name = os.path.abspath(os.fsdecode(path)) if not isinstance(path, int) else os.readlink(f"/proc/self/fd/{path}")
        if not name.startswith(str(self.root)):
            return
        self.steps.append((what, name))
        now = len(self.steps) == self.at
        if now and self.kill:
            os.kill(os.getpid(), signal.SIGKILL)
        if now or (self.full and what in NEEDS_SPACE):
            self.full = self.error == errno.ENOSPC
            raise OSError(self.error, os.strerror(self.error))

    def open(self, file: Any, mode: str = "r", buffering: int = -1, *rest: Any, **named: Any) -> Any:
        name = file if isinstance(file, int) else os.fspath(file)
        if not set(mode) & set("wxa+"):
            return REAL_OPEN(file, mode, buffering, *rest, **named)
        self.step("open", name)
        raw = _File(self, name, mode.replace("b", "").replace("t", ""), closefd=named.pop("closefd", True))
        buffered = io.BufferedWriter(raw)
        return buffered if "b" in mode else io.TextIOWrapper(buffered, *rest, **named)


class _File(io.FileIO):
    def __init__(self, disk: Disk, name: Any, mode: str, closefd: bool) -> None:
        super().__init__(name, mode, closefd)
        self._disk = disk

    def write(self, data: Any) -> int:
        self._disk.step("write", self.fileno())
        return super().write(data)


REAL_OPEN = builtins.open


@contextmanager
def faulty(disk: Disk) -> Iterator[Disk]:
    """As long as this lasts, the disk is that one."""

    def counted(what: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def call(path: Any, *rest: Any, **named: Any) -> Any:
            disk.step(what, path)
            return real(path, *rest, **named)

        return call

    def os_open(path: Any, flags: int, *rest: Any, **named: Any) -> int:
        if flags & os.O_CREAT:
            disk.step("create", path)
        return real_os_open(path, flags, *rest, **named)

    def exchange(one: Path, other: Path) -> bool:
        disk.step("exchange", one)
        return real_exchange(one, other)

    real_os_open, real_exchange = os.open, staging._exchange
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(builtins, "open", disk.open)
        patch.setattr(io, "open", disk.open)
        patch.setattr(os, "open", os_open)
        patch.setattr(staging, "_exchange", exchange)
        for name in ("rename", "replace", "link", "mkdir", "fsync"):
            patch.setattr(os, name, counted(name, getattr(os, name)))
        yield disk


def steps_of(root: Path, work: Callable[[], Any]) -> list[tuple[str, str]]:
    """What this work does to the disk when all goes well."""
    with faulty(Disk(root, None)) as disk:
        work()
    return disk.steps


def killed_at(root: Path, at: int, work: Callable[[], Any]) -> int:
    """Do it in a process of its own, which is killed at this step; its wait status."""
    child = os.fork()
    if child == 0:
        try:
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
            with faulty(Disk(root, at, kill=True)):
                work()
        finally:
            os._exit(0)
    return os.waitpid(child, 0)[1]
