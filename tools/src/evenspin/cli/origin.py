"""Where the output of a command comes from: the words that were typed, and the files and folders that it reads."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from evenspin.output.origin import Origin

# What only says where an output goes, how fast it is made, or whether to ask.
PLACES = frozenset({"--out", "--plot", "--save-memory", "--record", "--markdown", "--workers", "--jobs", "--scheduler"})
FLAGS = frozenset({"--force", "--yes", "--check", "--no-check"})
JSON = "--json"
BLIND_MAKE, TRUTH = ["gap", "blind", "make"], "--truth"  # there an output, in `score` an input

_words: list[str] = []


def remember(words: Sequence[str], json_has_file: bool) -> None:
    """What was typed, from `main`. `json_has_file`: a file follows --json in this command."""
    _words[:] = _without_places(words, json_has_file)


def origin(*read: str | Path | None) -> Origin:
    """Of the command that runs. `read`: files and folders that it reads; what is none of them is left out, such as the
    name of a built-in model."""
    from evenspin.output.origin import Origin, existing

    package = Path(__file__).resolve().parents[1]
    given = [path for path in existing(read) if not path.is_relative_to(package)]  # built-in ones belong to the version
    return Origin(" ".join(["evenspin", *_words]), tuple(given))


def _without_places(words: Sequence[str], json_has_file: bool) -> list[str]:
    places = PLACES | ({JSON} if json_has_file else set()) | ({TRUTH} if list(words[:3]) == BLIND_MAKE else set())
    kept, remaining = [], iter(words)
    for word in remaining:
        if word in places:
            next(remaining, None)
        elif word not in FLAGS and word != JSON and word.partition("=")[0] not in places:
            kept.append(word)
    return kept
