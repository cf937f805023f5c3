"""What stands beside an output: the command, version, commit, date, the inputs, and a hash of each file.

A folder has it as manifest.json. The single files of a folder of the user's have theirs together in one hidden file.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from evenspin.build import build
from evenspin.output.origin import Origin

MANIFEST = "manifest.json"
FILES = ".evenspin-files.json"  # of single files, beside them
AT_ONCE = 1 << 20


@dataclass(frozen=True, slots=True)
class Made:
    """An earlier output as its manifest describes it. `files` has no hashes (None) in one of an early version."""

    command: str
    inputs: tuple[str, ...]
    recording: bool
    files: Mapping[str, str | None]

    def by(self, origin: Origin) -> bool:
        """Whether both are outputs of the same command and the same inputs."""
        return self.command == origin.command and set(self.inputs) == {str(path) for path in origin.inputs}


def describe(origin: Origin, files: Mapping[str, str], *, recording: bool) -> dict[str, Any]:
    """The manifest of an output with these hashes."""
    return {
        "command": origin.command,
        **build().as_json(),
        "made_at": datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        "recording": recording,
        "inputs": {str(path): hash_of(path) for path in origin.inputs},
        "files": dict(files),
    }


def parse(content: Any) -> Made | None:
    """What a manifest says; None: it is none."""
    try:
        files = content["files"]
        hashes = {str(name): None for name in files} if isinstance(files, list) else {**files}
        return Made(str(content["command"]), tuple(content.get("inputs", ())), bool(content.get("recording")), hashes)
    except (KeyError, TypeError, AttributeError):
        return None


def read_manifest(folder: Path) -> Made | None:
    return parse(_json(folder / MANIFEST))


def hashes_of(folder: Path) -> dict[str, str]:
    """Every file below, by its name from here; the manifest itself is none of them."""
    return {name: hash_of(folder / name) for name in names_in(folder) if name != MANIFEST and not name.endswith("/")}


def names_in(folder: Path) -> list[str]:
    """Files and links below, and folders that hold nothing, which end in a slash."""
    found = []
    for place, folders, files in os.walk(folder, followlinks=False):
        here = Path(place).relative_to(folder)
        links = [name for name in folders if (Path(place) / name).is_symlink()]
        found += [(here / name).as_posix() for name in [*files, *links]]
        if not files and not folders and place != str(folder):
            found.append(f"{here.as_posix()}/")
    return sorted(found)


def hash_of(path: Path) -> str:
    """SHA-256 of a file; of a folder, of the names and hashes in it; of a link, of where it points."""
    digest = hashlib.sha256()
    if path.is_dir() and not path.is_symlink():
        for name in names_in(path):
            digest.update(f"{name}\0{'' if name.endswith('/') else hash_of(path / name)}\n".encode(errors="replace"))
    elif path.is_file():
        with path.open("rb") as file:
            while part := file.read(AT_ONCE):
                digest.update(part)
    elif path.is_symlink():
        digest.update(os.fsencode(os.readlink(path)))
    return digest.hexdigest()


# ---- of single files


def read_file_entry(path: Path, notes: Path) -> Made | None:
    """What the notes in a folder know of this file; None: nothing."""
    content = _json(notes / FILES)
    known = content.get("files") if isinstance(content, dict) else None
    entry = known.get(path.relative_to(notes).as_posix()) if isinstance(known, dict) else None
    return parse(entry) if isinstance(entry, dict) else None


def note_file(path: Path, notes: Path, origin: Origin) -> None:
    """Remember in the notes of a folder that this file below it was made by this command. Where that cannot be, a
    repeat of the command will be asked to choose another name: no reason to fail."""
    with contextlib.suppress(OSError), _held(notes):
        content = _json(notes / FILES)
        known = content.get("files") if isinstance(content, dict) else None
        known = known if isinstance(known, dict) else {}
        here = {name: entry for name, entry in known.items() if (notes / name).exists()}
        here[path.relative_to(notes).as_posix()] = describe(origin, {path.name: hash_of(path)}, recording=False)
        says = "What evenspin wrote here as single files; without this it takes no file for its own."
        _replace(notes / FILES, {"note": says, "files": dict(sorted(here.items()))})


@contextlib.contextmanager
def _held(folder: Path) -> Iterator[None]:
    """One process at a time."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError):  # a file system without locks
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def _replace(path: Path, content: Any) -> None:
    handle, name = tempfile.mkstemp(prefix=f"{FILES}.", dir=path.parent)
    try:
        with open(handle, "w", encoding="utf-8") as file:
            file.write(json.dumps(content, indent=1) + "\n")
        os.chmod(name, 0o644)
        os.replace(name, path)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(name)
        raise


def _json(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
