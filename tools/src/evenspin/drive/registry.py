"""Virtual drives that run on this machine: each leaves a note, so that the bench tools find it without an address."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from evenspin.errors import InputError


@dataclass(frozen=True, slots=True)
class Note:
    """`port` is what --port takes; `control` is HOST:PORT of the load machine and the clock."""

    pid: int
    port: str
    control: str
    model: str
    speed: str
    octets_per_s: float | None = None  # of a throttled link

    @property
    def alive(self) -> bool:
        try:
            os.kill(self.pid, 0)
        except ProcessLookupError:
            return False
        except OSError:
            return True
        return True


def folder() -> Path:
    """One per user; nobody else can write to it."""
    place = os.environ.get("XDG_RUNTIME_DIR")
    return Path(place) / "evenspin" if place else Path(tempfile.gettempdir()) / f"evenspin-{os.getuid()}"


@contextlib.contextmanager
def announced(note: Note) -> Iterator[None]:
    place = folder()
    place.mkdir(mode=0o700, parents=True, exist_ok=True)
    if place.stat().st_uid != os.getuid():
        raise InputError("drive", "folder", str(place), "this user's own", "remove it, or set XDG_RUNTIME_DIR")
    path = place / f"{note.pid}.json"
    path.write_text(json.dumps(asdict(note)) + "\n")
    try:
        yield
    finally:
        path.unlink(missing_ok=True)


def running() -> list[Note]:
    """Notes of drives that still run; notes of those that were killed are cleared away."""
    found = []
    for path in sorted(folder().glob("*.json")):
        try:
            note = Note(**json.loads(path.read_text()))
        except (OSError, ValueError, TypeError):
            continue
        if note.alive:
            found.append(note)
        else:
            path.unlink(missing_ok=True)
    return found
