"""The hidden folder beside an output in which it grows, and what killed writers left of theirs.

.NAME.evenspin-XXXXXXXX/new      is being written
.NAME.evenspin-XXXXXXXX/old      an earlier output, moved away, where the file system cannot exchange two names
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from evenspin.output.claim import MARK, BusyError, Claim, is_free

NEW, OLD = "new", "old"
AT_FDCWD, RENAME_EXCHANGE = -100, 2


def make_staging(target: Path) -> Path:
    return Path(tempfile.mkdtemp(prefix=f".{target.name}{MARK}", dir=target.parent))


def remove(staging: Path) -> None:
    shutil.rmtree(staging, ignore_errors=True)


def put_in_place(staging: Path, target: Path) -> None:
    """`new` of the staging folder becomes the target: at every moment either the old or the new stands there whole."""
    new = staging / NEW
    if not target.is_dir() or not any(target.iterdir()):
        os.rename(new, target)  # over a file, an empty folder, or nothing
        return
    if _exchange(new, target):
        return
    old = staging / OLD
    os.rename(target, old)
    try:
        os.rename(new, target)
    except OSError:
        os.rename(old, target)
        raise


def _exchange(one: Path, other: Path) -> bool:
    """Exchange two names in one step. False where this system cannot."""
    try:
        rename = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    if rename(AT_FDCWD, os.fsencode(one), AT_FDCWD, os.fsencode(other), RENAME_EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP):
        return False
    raise OSError(number, os.strerror(number), str(other))


def sync(path: Path) -> None:
    """Onto the disk, every file below."""
    for place in [path] if path.is_file() else [path, *path.rglob("*")]:
        sync_names(place)


def sync_names(place: Path) -> None:
    """A file, or the names in a folder, onto the disk."""
    handle = os.open(place, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


# ---- what was left behind


@dataclass(frozen=True, slots=True)
class Leftover:
    """A staging folder. `alive`: its writer still has the lock."""

    path: Path
    target: Path
    alive: bool

    @property
    def holds_the_earlier(self) -> bool:
        """The writer was killed between two renames: the output that was there is here, and nowhere else."""
        return (self.path / OLD).exists() and not self.target.exists()

    def __str__(self) -> str:
        if self.alive:
            return f"{self.path}: {self.target.name} is being written"
        if self.holds_the_earlier:
            return f"{self.path}/{OLD}: the earlier {self.target.name}, whole: move it back with mv"
        return f"{self.path}: left half-written by a command that was killed while it wrote {self.target.name}"

    def remove(self) -> bool:
        """Only what nobody writes, and what is nowhere else stays; False: it is still there."""
        if self.holds_the_earlier:
            return False
        claim = Claim(self.target)
        try:
            claim.take(make_parents=False)
        except (BusyError, OSError):  # again, or nothing can be written here
            return False
        try:
            remove(self.path)
        finally:
            claim.release()
        return not self.path.exists()


def leftovers(folder: Path, target: Path | None = None, *, own: bool = False) -> list[Leftover]:
    """In this folder; of one output only, if `target` is given. `own`: the caller has its lock, so others are dead."""
    found = []
    with contextlib.suppress(OSError):
        for path in sorted(folder.iterdir()):
            name, mark, rest = path.name[1:].rpartition(MARK)
            if not path.name.startswith(".") or not mark or not name or rest == "lock" or not path.is_dir():
                continue
            of = folder / name
            if target is None or of == target:
                found.append(Leftover(path, of, alive=not own and not is_free(of)))
    return found


def remove_locks(folder: Path) -> None:
    """Lock files that nobody holds. They do no harm, and the next writer takes them over."""
    ending = f"{MARK}lock"
    with contextlib.suppress(OSError):
        for path in list(folder.iterdir()):
            if path.name.startswith(".") and path.name.endswith(ending):
                with contextlib.suppress(BusyError, OSError):
                    claim = Claim(folder / path.name[1 : -len(ending)])
                    claim.take(make_parents=False)
                    claim.release()  # removes it
