"""Check that names, comments, messages and manuals use the terms of the field, not words that only this project knew.

    check_words.py <root of the repository>

Only words whose use is never right here are listed, each with what to write instead. A word counts where it stands by
itself: `told_apart`, a field of the table of effects, is another one. In C a doc comment has to stand alone, too: no
part of a sentence over several fields, and not "The same". Every finding is printed as
`file:line: word: what to write`. Exit status: 0 none, 1 some, 2 there was nothing to check.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

# Ordinary words that had a private meaning: a reader from outside stops at each, or takes it for something else.
INSTEAD = {
    "anew": "again",
    "blame": "locate",
    "boiled down": "reduced",
    "desk": "session",
    "heard": "detected, received",
    "leisure": "in the background",
    "lesson|lessons": "learned value",
    "news": "innovation, events",
    "sound unit|sound units": "healthy unit",
    "spot|spots": "position",
    "taught|teach|teaches": "learned, learns",
    "told": "reported, given, commanded; distinguished",
    "unusual|usual|usually": "nominal, default, abnormal",
    "valley|valleys": "local minimum",
    "wells": "detents",
    "wild": "nonlinear, out of control, outlier",
}
WORD = re.compile(r"(?<!\w)(?:" + "|".join(f"(?:{words})" for words in INSTEAD) + r")(?!\w)", re.IGNORECASE)
SHARED = re.compile(r"/\*\*<?\s*(?:\.\.\.|The same\b|As above\b|\(\d\)\. )|/\*\*.*\w\.\.\. \*/")  # part of a sentence
ALONE = "a sentence that stands alone when it is hovered"
KINDS = {".c", ".cmake", ".css", ".def", ".h", ".html", ".js", ".md", ".py", ".sh", ".toml", ".txt"}

# What is not ours to word, and what says how it was.
EXEMPT = re.compile(r"^CHANGELOG\.md|^docs/reference/|/vendor/|^tests/architecture/(test_)?check_words\.py")


def findings(text: str) -> Iterator[tuple[int, str, str]]:
    """Line, word, and what to write instead."""
    for number, line in enumerate(text.splitlines(), 1):
        yield from ((number, match[0], ALONE) for match in SHARED.finditer(line))
        for match in WORD.finditer(line):
            word = match[0]
            yield number, word, next(INSTEAD[key] for key in INSTEAD if word.lower() in key.split("|"))


def main(arguments: list[str]) -> int:
    root = Path(arguments[1])
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=root, capture_output=True, text=True)
    names = listed.stdout.splitlines() or [str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()]
    ours = [name for name in names if Path(name).suffix in KINDS and not EXEMPT.search(name)]
    files = [name for name in ours if (root / name).is_file()]
    if not files:
        print(f"{root}: nothing to check")
        return 2
    found = [(name, *each) for name in files for each in findings((root / name).read_text(encoding="utf-8"))]
    for name, line, word, instead in found:
        print(f"{name}:{line}: {word}: write {instead}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
