"""Small changes of C source, each of which a test should notice.

Operators: a comparison or its boundary, `&&` and `||`, a dropped `!`, plus and minus, times and divided by, the num_add
and num_sub of the blocks, true and false, a constant one more, and a statement left out. Comments, strings and
preprocessor lines stay as they are.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass

# Pattern, and what replaces it. The blanks are those of clang-format: `a * b` multiplies, `char *b` does not.
SWAPPED: tuple[tuple[str, str, str], ...] = (
    ("comparison", r"(?<= )<(?= )", "<="),
    ("comparison", r"(?<= )<=(?= )", "<"),
    ("comparison", r"(?<= )>(?= )", ">="),
    ("comparison", r"(?<= )>=(?= )", ">"),
    ("comparison", r"(?<= )==(?= )", "!="),
    ("comparison", r"(?<= )!=(?= )", "=="),
    ("logic", r"(?<= )&&(?= )", "||"),
    ("logic", r"(?<= )\|\|(?= )", "&&"),
    ("logic", r"!(?=[A-Za-z_(])", ""),
    ("logic", r"\btrue\b", "false"),
    ("logic", r"\bfalse\b", "true"),
    ("arithmetic", r"(?<= )\+(?= )", "-"),
    ("arithmetic", r"(?<= )-(?= )", "+"),
    ("arithmetic", r"(?<=[\w)\]] )\*(?= )", "/"),
    ("arithmetic", r"(?<= )/(?= )", "*"),
    ("arithmetic", r"(?<= )%(?= )", "*"),
    ("arithmetic", r"(?<= )\+=(?= )", "-="),
    ("arithmetic", r"(?<= )-=(?= )", "+="),
    ("arithmetic", r"\+\+", "--"),
    ("arithmetic", r"(?<![-\w])--(?=[;\w])|(?<=[\w\]])--(?=;)", "++"),
    ("arithmetic", r"(?<= )<<(?= )", ">>"),
    ("arithmetic", r"(?<= )>>(?= )", "<<"),
    ("arithmetic", r"(?<= )&(?= )", "|"),
    ("arithmetic", r"(?<= )\|(?= )", "&"),
    ("arithmetic", r"\bnum_add\b", "num_sub"),
    ("arithmetic", r"\bnum_sub\b", "num_add"),
)
NUMBER = re.compile(r"(?<![\w.])(?:0x[0-9A-Fa-f]+U?|\d+U?|\d+\.\d*(?:e[-+]?\d+)?f?)(?![\w.])")
COMMENT = r"/\*.*?\*/|//[^\n]*"
TEXT = r'"(?:\\.|[^"\\\n])*"' + r"|'(?:\\.|[^'\\\n])*'"
PREPROCESSOR = r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*"
SKIPPED = re.compile(f"{COMMENT}|{TEXT}|{PREPROCESSOR}", re.DOTALL | re.MULTILINE)
NO_STATEMENT = "return break continue goto case default typedef else if for while switch do".split()
STATEMENT = re.compile(rf"(?<=[;{{}}:])(\s*)((?!(?:{'|'.join(NO_STATEMENT)})\b)[A-Za-z_*(][^;{{}}]*;)")
DECLARED = re.compile(
    r"^(?:static|const|volatile|extern|struct|enum|union|unsigned)\b"
    r"|^\w+(?:\s+|\s*\*+\s*(?:const\s+)?)\w+\s*(?:=|;|\[|,|\()"
)


@dataclass(frozen=True, slots=True)
class Mutant:
    """`at` and `end` bound what `new` replaces; `line` counts from 1, `text` is that line of the original."""

    operator: str
    at: int
    end: int
    old: str
    new: str
    line: int
    text: str
    nth: int  # of those with the same operator, change and text of the line

    @property
    def key(self) -> str:
        """What stays when lines move."""
        return json.dumps([self.text, " ".join(self.old.split()), self.new, self.nth])

    def applied(self, source: str) -> str:
        return source[: self.at] + self.new + source[self.end :]

    def __str__(self) -> str:
        old = " ".join(self.old.split())
        if self.operator == "statement":
            return f"without `{old}`"
        return f"{self.operator}: `{old}` -> `{self.new}`" if self.new else f"{self.operator}: without `{old}`"


def blanked(source: str) -> str:
    """The source with blanks for what is not code, so that places stay."""
    return SKIPPED.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), source)


def one_more(number: str) -> str:
    digits = number.rstrip("Uf")
    tail = number[len(digits) :]
    if number.startswith("0x"):
        digits = re.match(r"0x[0-9A-Fa-f]+", number)[0]  # type: ignore[index]
        return f"0x{int(digits, 16) + 1:X}{number[len(digits) :]}"
    if "." in digits or "e" in digits:
        value = float(digits)
        return f"{value + 1.0 if value == 0.0 else 1.5 * value!r}{tail}"
    return f"{int(digits) + 1}{tail}"


def changes(code: str) -> Iterator[tuple[str, int, int, str]]:
    """Operator, first and last place, what stands there instead."""
    for operator, pattern, new in SWAPPED:
        for found in re.finditer(pattern, code):
            yield operator, found.start(), found.end(), new
    for found in NUMBER.finditer(code):
        yield "constant", found.start(), found.end(), one_more(found[0])
    for found in STATEMENT.finditer(code):
        text = " ".join(found[2].split())
        if not DECLARED.match(text) and ("=" in text or "(" in text or "++" in text or "--" in text):
            yield "statement", found.start(2), found.end(2), ";"


def bodies(code: str) -> list[tuple[int, int]]:
    """Where functions and tables are: from a brace in the first column of depth to its end."""
    found, depth, start = [], 0, 0
    for at, sign in enumerate(code):
        if sign == "{":
            start = at if depth == 0 else start
            depth += 1
        elif sign == "}":
            depth -= 1
            if depth == 0:
                found.append((start, at + 1))
    return found


def mutants(source: str) -> list[Mutant]:
    """Every mutant of a file, in the order of its places."""
    code = blanked(source)
    lines = source.split("\n")
    inside = bodies(code)
    seen: dict[tuple[str, str, str], int] = {}
    found = []
    for operator, at, end, new in sorted(changes(code), key=lambda change: (change[1], change[2], change[3])):
        if not any(low < at < high for low, high in inside):
            continue
        line = source.count("\n", 0, at) + 1
        text, old = lines[line - 1].strip(), source[at:end]
        nth = seen.get((text, old, new), 0)
        seen[(text, old, new)] = nth + 1
        found.append(Mutant(operator, at, end, old, new, line, text, nth))
    return found
