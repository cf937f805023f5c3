"""Where output goes: people's text to stdout, or to stderr when stdout carries JSON."""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from evenspin.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

STDOUT = "-"
WIDE = 150  # columns when nobody can tell: tables must not be cut

# Commands whose --json may be followed by a file.
JSON_WITH_FILE = {"reproduce", "design", "memory", "identify", "benchmark", "bench", "cycles", "doctor"}


def split_json_option(words: Sequence[str]) -> list[str]:
    """`--json` without a file means stdout: give it the file name `-`."""
    words = list(words)
    if not words or words[0] not in JSON_WITH_FILE:
        return words
    result = []
    for word, following in zip(words, [*words[1:], None], strict=True):
        result.append(word)
        if word == "--json" and (following is None or (following.startswith("-") and following != STDOUT)):
            result.append(STDOUT)
    return result


def console(json_file: str | None = None) -> Console:
    """For people; on stderr when the JSON goes to stdout."""
    from rich.console import Console

    to_stderr = json_file == STDOUT
    stream = sys.stderr if to_stderr else sys.stdout
    width = None if stream.isatty() else max(WIDE, shutil.get_terminal_size((WIDE, 50)).columns)
    return Console(stderr=to_stderr, width=width, highlight=False, markup=False)


def write_json(value: Any, json_file: str) -> None:
    """Print it, or write the file completely or not at all."""
    text = json.dumps(value, indent=1, allow_nan=False) + "\n"
    if json_file == STDOUT:
        sys.stdout.write(text)
        sys.stdout.flush()
        return
    path = Path(json_file)
    check_json_file(json_file)
    with tempfile.NamedTemporaryFile("w", dir=path.parent, prefix=f".{path.name}.", delete=False) as file:
        file.write(text)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)


def check_json_file(json_file: str | None) -> None:
    """Refuse a place that cannot be written, before any work is done."""
    if json_file in (None, STDOUT):
        return
    path = Path(json_file)
    if path.is_dir() or not path.parent.is_dir():
        raise InputError("--json", "file", json_file, "a file in an existing folder", "choose another place")


def command_line(*words: str) -> list[str]:
    """A command as it is noted beside its output."""
    return ["evenspin", *words]
