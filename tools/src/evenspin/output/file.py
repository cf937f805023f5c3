"""A single file as output: there completely or not at all.

It replaces only what the same command made of the same inputs and nobody has touched since; `force` replaces any file
but an input. What is no ordinary file (a pipe, /dev/null, a terminal) is written into as it is.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from evenspin.output.manifest import hash_of, note_file, read_file_entry
from evenspin.output.origin import Origin
from evenspin.output.staging import NEW
from evenspin.output.writer import Say, Writer, to_stderr


class OutputFile(Writer):
    """`with OutputFile(path, origin) as place:` write the file `place`, whose name ends as that of `path`.

    `recording`: what was measured: never replaced without `force`, not by the same command either.
    `can_force`: the command has an option --force, which its message may name.
    `notes`: the folder above in which it is noted what made the file; None: its own.
    """

    what = "file"

    def __init__(
        self,
        path: Path,
        origin: Origin | Sequence[str],
        *,
        option: str = "--out",
        recording: bool = False,
        force: bool = False,
        can_force: bool = True,
        notes: Path | None = None,
        say: Say = to_stderr,
    ) -> None:
        self.can_force = can_force
        self._notes = notes
        super().__init__(path, origin, option=option, recording=recording, force=force, say=say)
        if self.path.is_symlink():
            self.path = self.path.resolve()  # the file behind it; the link stays

    def write(self, text: str) -> None:
        with self as place:
            place.write_text(text, encoding="utf-8")

    def check(self) -> None:
        path = self.path
        if path.is_dir() or not path.parent.is_dir() or (path.is_symlink() and not path.exists()):
            raise self.refusal("a file in an existing folder", "choose another place")
        self.origin.keep_apart(self.option, path, folder=False)
        if path.is_file() and not self.force and (reason := self._why_not()):
            other = "choose another name, or replace it with --force" if self.can_force else "choose another name"
            must = "a new file" if self.recording else "new, or the untouched output of this very command"
            raise self.refusal(must, f"{reason}: {other}")

    def _why_not(self) -> str:
        made = read_file_entry(*self._noted())
        if self.recording:
            return "it is there already, and what was measured is not replaced"
        if made is None:
            return "it is there already, and no command of evenspin is known to have made it"
        if made.command != self.origin.command:
            return f"`{made.command}` made it"
        if not made.by(self.origin):
            return "it was made of other inputs"
        return "" if made.files.get(self.path.name) == hash_of(self.path) else "it was changed since it was made"

    def begin(self, new: Path) -> None:
        new.mkdir()

    def __enter__(self) -> Path:
        if _is_special(self.path):
            return self.path
        return super().__enter__() / self.path.name

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not _is_special(self.path):
            super().__exit__(kind, error, trace)

    def finish(self, new: Path) -> None:
        """From the folder in which it has its own name to the place from which it is put."""
        assert self.staging is not None
        displaced = self.staging / "written"
        new.rename(displaced)
        (displaced / self.path.name).rename(self.staging / NEW)
        shutil.rmtree(displaced, ignore_errors=True)

    def done(self) -> None:
        if not self.recording:
            note_file(*self._noted(), self.origin)

    def _noted(self) -> tuple[Path, Path]:
        """The file itself, and the folder whose manifest lists it."""
        path = self.path.resolve()
        return path, path.parent if self._notes is None else self._notes.resolve()


def _is_special(path: Path) -> bool:
    return path.exists() and not path.is_file()
