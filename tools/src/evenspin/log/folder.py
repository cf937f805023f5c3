"""An output folder that is there completely or not at all.

Everything is written to a hidden folder beside it, which takes the place of the old one at the end. A folder that
holds anything but an earlier output of evenspin is left alone.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from evenspin.errors import InputError

MANIFEST = "manifest.json"


class OutputFolder:
    """`with OutputFolder(path, command) as folder:` write into `folder`; an exception leaves nothing behind."""

    def __init__(self, path: Path, command: Sequence[str]) -> None:
        self.path = path.absolute()
        self.command = list(command)
        self.staging: Path | None = None
        self.check()

    def check(self) -> None:
        """Refuse what must not be replaced, before any work is done."""
        parent = self.path.parent
        if self.path.is_symlink() or (self.path.exists() and not self.path.is_dir()):
            raise InputError("--out", "folder", str(self.path), "a folder", "choose another name")
        above = next(folder for folder in (parent, *parent.parents) if folder.exists())
        if not above.is_dir():
            raise InputError("--out", "folder", str(above), "a folder", "choose another place")
        if self.path.is_dir() and (foreign := self._foreign()):
            hint = f"it holds {foreign[0]}: choose another folder"
            raise InputError("--out", "folder", str(self.path), "new, empty, or an earlier output of evenspin", hint)

    def __enter__(self) -> Path:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.staging = Path(tempfile.mkdtemp(prefix=f".{self.path.name}.", dir=self.path.parent))
            self.staging.chmod(0o755)
        except OSError as error:
            raise InputError("--out", "folder", str(self.path), "writable", error.strerror or str(error)) from None
        return self.staging

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        assert self.staging is not None
        try:
            if kind is None:
                self._manifest(self.staging)
                self._replace(self.staging)
        finally:
            shutil.rmtree(self.staging, ignore_errors=True)
        if isinstance(error, OSError):
            raise InputError("--out", "folder", str(self.path), "writable", error.strerror or str(error)) from None

    def _foreign(self) -> list[str]:
        """What an earlier output did not write."""
        try:
            known = set(json.loads((self.path / MANIFEST).read_text())["files"]) | {MANIFEST}
        except (OSError, ValueError, KeyError, TypeError):
            return sorted(path.name for path in self.path.iterdir())
        return [name for name in _files(self.path) if name not in known]

    def _manifest(self, staging: Path) -> None:
        content = {"command": " ".join(self.command), "files": _files(staging)}
        (staging / MANIFEST).write_text(json.dumps(content, indent=1) + "\n")

    def _replace(self, staging: Path) -> None:
        """Two renames; an old output stays until the new one is complete."""
        self.check()
        if not self.path.exists():
            staging.rename(self.path)
            return
        old = Path(tempfile.mkdtemp(prefix=f".{self.path.name}.old.", dir=self.path.parent))
        self.path.rename(old / "it")
        try:
            staging.rename(self.path)
        except OSError:
            (old / "it").rename(self.path)
            raise
        finally:
            shutil.rmtree(old, ignore_errors=True)


def _files(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir())
