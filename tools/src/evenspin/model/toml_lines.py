"""Where each key of a TOML text is. `tomllib` reads the values but forgets the lines, which an error message needs.

The text has been read by tomllib before, so it is known to be valid; this only follows its structure.
"""

from __future__ import annotations

import re
import tomllib

Path = tuple[str | int, ...]

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_SPACE = re.compile(r"[ \t]*")
_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_SCALAR = re.compile(r"[^,\]}\r\n#]+")
_STRINGS = (
    re.compile(r'"""(?:\\.|[^\\])*?"{3,5}', re.DOTALL),
    re.compile(r"'''.*?'{3,5}", re.DOTALL),
    re.compile(r'"(?:\\.|[^"\\\n])*"'),
    re.compile(r"'[^'\n]*'"),
)


def key_lines(text: str) -> dict[Path, int]:
    """Line of every key, from 1. Members of arrays have their position as a part of the path."""
    return _Scanner(text).scan()


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.line = 1
        self.lines: dict[Path, int] = {}
        self.array_length: dict[Path, int] = {}

    def scan(self) -> dict[Path, int]:
        prefix: Path = ()
        self.skip(_BLANK)
        while self.at < len(self.text):
            if self.text.startswith("[", self.at):
                prefix = self.header()
            else:
                self.pair(prefix)
            self.skip(_BLANK)
        return self.lines

    def header(self) -> Path:
        is_array = self.text.startswith("[[", self.at)
        self.at += 2 if is_array else 1
        line = self.line
        parts = self.key()
        self.at += 2 if is_array else 1
        path: Path = ()
        for position, part in enumerate(parts):
            path += (part,)
            last = position == len(parts) - 1
            if last and is_array:
                self.array_length[path] = self.array_length.get(path, 0) + 1
            if path in self.array_length:
                self.lines.setdefault(path, line)
                path += (self.array_length[path] - 1,)
        self.lines[path] = line
        return path

    def pair(self, prefix: Path) -> None:
        line = self.line
        path = prefix
        for part in self.key():
            path += (part,)
            self.lines.setdefault(path, line)
        self.at += 1  # =
        self.skip(_SPACE)
        self.value(path)

    def key(self) -> list[str]:
        parts = []
        while True:
            self.skip(_SPACE)
            if bare := _BARE_KEY.match(self.text, self.at):
                parts.append(bare[0])
                self.at = bare.end()
            else:
                parts.append(tomllib.loads(f"k = {self.string()}")["k"])
            self.skip(_SPACE)
            if not self.text.startswith(".", self.at):
                return parts
            self.at += 1

    def value(self, path: Path) -> None:
        first = self.text[self.at]
        if first in "\"'":
            self.string()
        elif first == "[":
            self.members("]", path)
        elif first == "{":
            self.members("}", path)
        else:
            self.skip(_SCALAR)

    def members(self, end: str, path: Path) -> None:
        """An array (positions) or an inline table (keys)."""
        self.at += 1
        self.skip(_BLANK)
        position = 0
        while self.text[self.at] != end:
            if end == "}":
                self.pair(path)
            else:
                self.lines[(*path, position)] = self.line
                self.value((*path, position))
            position += 1
            self.skip(_BLANK)
            if self.text[self.at] == ",":
                self.at += 1
                self.skip(_BLANK)
        self.at += 1

    def string(self) -> str:
        for pattern in _STRINGS:
            if found := pattern.match(self.text, self.at):
                self.advance(found.end())
                return found[0]
        raise ValueError(f"not TOML at line {self.line}")

    def skip(self, pattern: re.Pattern[str]) -> None:
        found = pattern.match(self.text, self.at)
        self.advance(found.end() if found else self.at)

    def advance(self, to: int) -> None:
        self.line += self.text.count("\n", self.at, to)
        self.at = to
