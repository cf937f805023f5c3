"""One writer at a time: a lock file beside the output, held while it is made. The system lets go of the lock when a
writer is killed, so that a lock that can be had says that nobody writes any more."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import socket
import time
from pathlib import Path

MARK = ".evenspin-"  # .NAME.evenspin-lock, .NAME.evenspin-XXXXXXXX
TRIES, PATIENCE_S = 4, 0.03
NO_LOCKS = frozenset({errno.ENOTSUP, errno.ENOSYS, errno.ENOLCK, errno.EINVAL})  # a file system without them


class BusyError(Exception):
    """Somebody else holds it; the text says who."""


def lock_path(target: Path) -> Path:
    return target.parent / f".{target.name}{MARK}lock"


class Claim:
    """Held from `take` until `release`, which also takes back folders that were made for it and stayed empty."""

    def __init__(self, target: Path) -> None:
        self.path = lock_path(target)
        self._handle: int | None = None
        self._process = os.getpid()  # a process that is forked from this one does not hold it
        self._made: list[Path] = []

    def take(self, *, make_parents: bool = True) -> None:
        """A BusyError when another writer has it, an OSError when nothing can be written here."""
        if make_parents:
            self._make(self.path.parent)
        try:
            while not self._take_now():
                pass
        except BaseException:
            self._take_back()
            raise

    def _take_now(self) -> bool:
        """False: the file was removed by its holder meanwhile; once more."""
        handle = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            _lock(handle)
            if not _is_at(handle, self.path):
                os.close(handle)
                return False
        except BaseException:
            os.close(handle)
            raise
        with contextlib.suppress(OSError):  # a full disk: then nobody knows who it is
            os.ftruncate(handle, 0)
            os.write(handle, json.dumps({"pid": os.getpid(), "host": socket.gethostname()}).encode())
        self._handle = handle
        return True

    def release(self) -> None:
        if self._process != os.getpid():
            return
        if self._handle is not None:
            with contextlib.suppress(OSError):
                self.path.unlink()
            os.close(self._handle)
            self._handle = None
        self._take_back()

    def _make(self, folder: Path) -> None:
        missing = [place for place in (folder, *folder.parents) if not place.exists()]
        for place in reversed(missing):
            place.mkdir(exist_ok=True)
            self._made.append(place)

    def _take_back(self) -> None:
        while self._made:
            with contextlib.suppress(OSError):  # it is not empty: the output is there
                self._made.pop().rmdir()


def _lock(handle: int) -> None:
    for patience in (
        *[PATIENCE_S] * TRIES,
        None,
    ):  # a process that only checks whether it is free holds it for a moment
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if patience is None:
                raise BusyError(_holder(handle)) from None
            time.sleep(patience)
        except OSError as error:
            if error.errno not in NO_LOCKS:
                raise
            return


def is_free(target: Path) -> bool:
    """Nobody writes to this output now."""
    try:
        handle = os.open(lock_path(target), os.O_RDWR | os.O_CLOEXEC)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    except OSError:
        return False
    finally:
        os.close(handle)


def _is_at(handle: int, path: Path) -> bool:
    try:
        there = os.stat(path)
    except FileNotFoundError:
        return False
    return os.path.samestat(os.fstat(handle), there)


def _holder(handle: int) -> str:
    try:
        content = json.loads(os.pread(handle, 1000, 0))
        return f"process {int(content['pid'])} on {content['host']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"
