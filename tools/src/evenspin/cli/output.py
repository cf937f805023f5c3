"""Where output goes: people's text to stdout, or to stderr when stdout carries JSON."""

from __future__ import annotations

import itertools
import json
import os
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
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
# Commands that have a drive at the other end, as those with --port.
AT_A_MOTOR = {"bench", "commission", "drive", "scope"}

ALL_IDENTIFICATIONS = "all"


def name_the_identification(words: Sequence[str]) -> list[str]:
    """`evenspin identify --run sim` without the name of one means all of them."""
    words = list(words)
    if words[:1] == ["identify"] and words[1:2] and words[1].startswith("-") and words[1] not in ("--help", "-h"):
        words.insert(1, ALL_IDENTIFICATIONS)
    return words


@dataclass
class _Wanted:
    """By the words of the command that runs: where the JSON of a flag --json goes, whether --quiet was given, and
    whether a drive may be at the other end."""

    json_file: str | None = None
    quiet: bool = False
    at_a_motor: bool = False


_wanted = _Wanted()
QUIET, QUIET_VARIABLE = "--quiet", "EVENSPIN_QUIET"


def take_quiet(words: Sequence[str]) -> list[str]:
    """`--quiet` may stand anywhere, and is for this command: nothing is printed then but JSON and errors."""
    if QUIET in words:
        os.environ[QUIET_VARIABLE] = "1"  # sim.progress reads it, too
    elif _wanted.quiet:
        os.environ.pop(QUIET_VARIABLE, None)
    _wanted.quiet = QUIET in words
    return [word for word in words if word != QUIET]


def split_json_option(words: Sequence[str]) -> list[str]:
    """`--json` without a file means stdout. Where it takes any file it gets the name `-`; where it is a flag, a
    following FILE.json is where the output goes."""
    words = list(words)
    _wanted.json_file = None
    _wanted.at_a_motor = any(word in AT_A_MOTOR for word in words[:1]) or any(
        word.partition("=")[0] == "--port" for word in words
    )
    if not words or words[0] not in JSON_WITH_FILE:
        for index, (word, after) in enumerate(itertools.pairwise(words)):
            if word == "--json" and after.endswith(".json"):
                _wanted.json_file = after
                return words[: index + 1] + words[index + 2 :]
        return words
    result = []
    for word, following in zip(words, [*words[1:], None], strict=True):
        result.append(word)
        if word == "--json" and (following is None or (following.startswith("-") and following != STDOUT)):
            result.append(STDOUT)
    return result


def console(json_file: str | None = None) -> Console:
    """For people; on stderr when the JSON goes to stdout. Where nobody reads any more, the command goes on in silence,
    for what it has to write is still wanted; one that may move a motor ends."""
    from rich.console import Console

    class Patient(Console):
        def on_broken_pipe(self) -> None:
            if _wanted.at_a_motor:
                super().on_broken_pipe()
            self.quiet = True
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())

    to_stderr = json_file == STDOUT and _wanted.json_file is None
    stream = sys.stderr if to_stderr else sys.stdout
    width = None if stream.isatty() else max(WIDE, shutil.get_terminal_size((WIDE, 50)).columns)
    return Patient(
        stderr=to_stderr, width=width, highlight=False, markup=False, quiet=bool(os.environ.get(QUIET_VARIABLE))
    )


def write_json(value: Any, json_file: str) -> None:
    """Print it, or write the file completely or not at all."""
    text = json_text(value)
    if json_file == STDOUT and _wanted.json_file is not None:
        json_file = _wanted.json_file
    if json_file == STDOUT:
        sys.stdout.write(text)
        sys.stdout.flush()
        return
    _json_output(json_file).write(text)


def json_text(value: Any) -> str:
    return json.dumps(value, indent=1, allow_nan=False) + "\n"


def check_json_of_flag() -> None:
    """As `check_json_file`, where --json is a flag."""
    check_json_file(_wanted.json_file)


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
