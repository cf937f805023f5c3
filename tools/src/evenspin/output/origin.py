"""Where an output comes from: the command, and what it read."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from evenspin.errors import InputError

HARMLESS = "choose another place"


@dataclass(frozen=True, slots=True)
class Origin:
    """`command`: as it was typed, without what only says where the output goes. `inputs`: files and folders."""

    command: str = ""
    inputs: tuple[Path, ...] = ()

    def keep_apart(self, option: str, out: Path, *, folder: bool) -> None:
        """Refuse an output that is an input, and a folder that lies in one or holds one."""
        place = out.resolve()
        for given in self.inputs:
            read = given.resolve()
            what = "folder" if folder else "file"
            if place == read:
                raise InputError(option, what, out, "another one than the input", "this command reads it")
            if folder and place.is_relative_to(read):
                raise InputError(option, what, out, f"outside of the input {given}", HARMLESS)
            if folder and read.is_relative_to(place):
                raise InputError(option, what, out, f"a folder without the input {given}", HARMLESS)


def absolute(path: Path) -> Path:
    return Path(os.path.abspath(path))


def existing(names: Iterable[str | Path | None]) -> list[Path]:
    """Those that name a file or a folder, each once."""
    found = []
    for name in names:
        with contextlib.suppress(ValueError):  # a name with a zero octet
            if name is not None and str(name) and os.path.exists(name):
                found.append(absolute(Path(name)))
    return list(dict.fromkeys(found))
