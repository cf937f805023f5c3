"""Where the parts of a structure lie on the C28x, in words of 16 bits, read from LLVM's types."""

from __future__ import annotations

import re
from collections import Counter

SHORT_OFFSET = 7  # *+XARn[0..7]
NAMED = re.compile(r"^(?P<name>%(?:struct|union)\.[-\w.$]+) = type <?(?P<body>\{.*\})>?$")
ADDRESS = re.compile(
    r"^getelementptr (?P<type>%?[-\w.$]+|[\[{<].*?[\]}>]), ptr (?P<base>\S+?)(?P<indices>(?:, i\d+ \S+)*)$"
)


def parts_of(body: str) -> list[str]:
    """The parts between the outermost braces."""
    parts, depth, begin = [], 0, 0
    for at, letter in enumerate(body):
        depth += (letter in "[{(<") - (letter in "]})>")
        if letter == "," and depth == 0:
            parts.append(body[begin:at].strip())
            begin = at + 1
    last = body[begin:].strip()
    return [*parts, last] if last else parts


class Layout:
    """Sizes and offsets; characters have 16 bits, floats, 32-bit numbers and pointers two words."""

    def __init__(self, lines: list[str] | None = None) -> None:
        self.named: dict[str, str] = {}
        self.sizes: dict[str, tuple[int, int]] = {}
        for line in lines or []:
            match = NAMED.match(line)
            if match is not None:
                self.named[match["name"]] = match["body"]

    def size(self, kind: str) -> tuple[int, int]:
        """Words, and the words that its address is a multiple of."""
        if kind not in self.sizes:
            self.sizes[kind] = self._size(kind)
        return self.sizes[kind]

    def _size(self, kind: str) -> tuple[int, int]:
        if kind in self.named:
            return self.size(self.named[kind])
        if kind.startswith("["):
            match = re.match(r"\[(\d+) x (.*)\]$", kind)
            words, align = self.size(match[2]) if match else (1, 1)
            return (int(match[1]) if match else 1) * words, align
        if kind.startswith("{"):
            at, widest = 0, 1
            for part in parts_of(kind[1:-1]):
                words, align = self.size(part)
                at = -(-at // align) * align + words
                widest = max(widest, align)
            return -(-at // widest) * widest, widest
        if kind in ("i64", "double"):
            return 4, 2
        return (2, 2) if kind in ("i32", "float", "ptr") else (1, 1)

    def part(self, kind: str, index: int) -> tuple[int, str]:
        """Offset and type of one part."""
        if kind in self.named:
            kind = self.named[kind]
        if kind.startswith("["):
            inner = re.sub(r"^\[\d+ x (.*)\]$", r"\1", kind)
            return index * self.size(inner)[0], inner
        at = 0
        for number, part in enumerate(parts_of(kind[1:-1])):
            words, align = self.size(part)
            at = -(-at // align) * align
            if number == index:
                return at, part
            at += words
        return 0, "i16"

    def address(self, text: str) -> Counter[str]:
        """Class of a getelementptr."""
        match = ADDRESS.match(text.split(", !")[0])
        if match is None or match["base"].startswith("@"):
            return Counter({"gvar": 1}) if re.search(r", i\d+ %", text) else Counter()
        indices = re.findall(r", i\d+ (\S+?)(?=,|$)", match["indices"])
        if any(index.startswith("%") for index in indices):
            return Counter({"gvar": 1})
        kind = match["type"]
        at = int(indices[0]) * self.size(kind)[0]
        for index in indices[1:]:
            step, kind = self.part(kind, int(index))
            at += step
        return Counter({"gsmall" if 0 <= at <= SHORT_OFFSET else "gbig": 1})
