"""A folder as output: there completely or not at all.

It replaces only what the same command made of the same inputs and nobody has touched since. `force` lets it also
replace a recording, the output of another command, and one that was changed; never an input, and never a folder that is
not an output of evenspin.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from evenspin.errors import InputError
from evenspin.output.manifest import MANIFEST, Made, describe, hash_of, hashes_of, names_in, read_manifest
from evenspin.output.origin import Origin
from evenspin.output.writer import Say, Writer, to_stderr

FORCE = "choose another name, or replace it with --force"
NO_LINKS = frozenset({errno.EPERM, errno.EXDEV, errno.ENOTSUP, errno.ENOSYS, errno.EMLINK})


class OutputFolder(Writer):
    """`with OutputFolder(path, origin) as folder:` write into `folder`; an exception leaves nothing behind.

    `recording`: what was measured, which no command replaces.
    """

    what = "folder"

    def __init__(
        self,
        path: Path,
        origin: Origin | Sequence[str],
        *,
        option: str = "--out",
        recording: bool = False,
        force: bool = False,
        say: Say = to_stderr,
    ) -> None:
        self.facts: Mapping[str, Any] = {}  # what else the manifest shall say
        self._brought: list[Path] = []
        super().__init__(path, origin, option=option, recording=recording, force=force, say=say)
        self.claim()

    def bring(self, path: Path, name: str) -> None:
        """A file that lies elsewhere belongs to this output, under this name. It is removed there when the output is
        complete, and not before."""
        assert self.staging is not None
        place = self.staging / "new" / name
        place.parent.mkdir(parents=True, exist_ok=True)
        try:
            os.link(path, place)
        except OSError as error:
            if error.errno not in NO_LINKS:
                raise
            shutil.copyfile(path, place)
        self._brought.append(path)

    # ---- what a writer asks

    def check(self) -> None:
        if self.path.is_symlink() or (self.path.exists() and not self.path.is_dir()):
            raise self.refusal("a folder", "choose another name")
        above = next((folder for folder in self.path.parents if folder.exists()), self.path)
        if not above.is_dir():
            raise InputError(self.option, "folder", above, "a folder", "choose another place")
        self.origin.keep_apart(self.option, self.path, folder=True)
        if self.path.is_dir() and any(self.path.iterdir()):
            self._check_earlier()

    def begin(self, new: Path) -> None:
        new.mkdir()

    def finish(self, new: Path) -> None:
        content = {**describe(self.origin, hashes_of(new), recording=self.recording), **self.facts}
        (new / MANIFEST).write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")

    def done(self) -> None:
        for path in self._brought:
            path.unlink(missing_ok=True)

    # ---- an earlier output

    def _check_earlier(self) -> None:
        made = read_manifest(self.path)
        if made is None:
            first = next(iter(names_in(self.path)), "something")
            raise self.refusal(
                "new, empty, or an earlier output of evenspin", f"it holds {first}: choose another folder"
            )
        if self.force:
            return
        if reason := _why_not(self.path, made, self.origin):
            raise self.refusal("new, empty, or the untouched output of this very command", f"{reason}: {FORCE}")


def _why_not(folder: Path, made: Made, origin: Origin) -> str:
    """Why an earlier output is not replaced; empty: it is."""
    if made.recording:
        return f"it is a recording of `{made.command}`"
    if any(value is None for value in made.files.values()):
        return "an early version of evenspin made it, and it cannot be checked whether it was changed since"
    if not made.by(origin):
        same = made.command == origin.command
        return "it was made of other inputs" if same else f"`{made.command}` made it"
    there = [name for name in names_in(folder) if name != MANIFEST]
    if added := [name for name in there if name not in made.files]:
        return f"{added[0]} was added since"
    if gone := [name for name in made.files if name not in there]:
        return f"{gone[0]} was removed since"
    if changed := [name for name, known in made.files.items() if hash_of(folder / name) != known]:
        return f"{changed[0]} was changed since"
    return ""
