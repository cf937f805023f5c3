"""Where output goes: people's text to stdout, or to stderr when stdout carries JSON."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from evenspin.cli.origin import origin

if TYPE_CHECKING:
    from rich.console import Console

    from evenspin.output import OutputFile

STDOUT = "-"
WIDE = 150  # columns when the width is not known: tables must not be cut

# Commands whose --json may be followed by a file.
JSON_WITH_FILE = {"reproduce", "design", "memory", "identify", "benchmark", "bench", "cycles", "doctor"}


ALL_IDENTIFICATIONS = "all"


def name_the_identification(words: Sequence[str]) -> list[str]:
    """`evenspin identify --run sim` without the name of one means all of them."""
    words = list(words)
    if words[:1] == ["identify"] and words[1:2] and words[1].startswith("-") and words[1] not in ("--help", "-h"):
        words.insert(1, ALL_IDENTIFICATIONS)
    return words


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
    text = json_text(value)
    if json_file == STDOUT:
        sys.stdout.write(text)
        sys.stdout.flush()
        return
    _json_output(json_file).write(text)


def json_text(value: Any) -> str:
    return json.dumps(value, indent=1, allow_nan=False) + "\n"


def check_json_file(json_file: str | None) -> None:
    """Refuse a place that cannot be written, before any work is done."""
    if json_file is None or json_file == STDOUT:
        return
    _json_output(json_file)


def _json_output(json_file: str) -> OutputFile:
    return output_file(Path(json_file), "--json")


def output_file(path: Path, option: str, *read: str | Path | None) -> OutputFile:
    """A table or a picture that the command can make again; it has no --force. `read`: what the command reads."""
    from evenspin.output import OutputFile

    return OutputFile(path, origin(*read), option=option, can_force=False)
