"""Make every basic block of LLVM's text add its cost to a counter."""

from __future__ import annotations

import re
from collections import Counter

from evenspin.cycles.classes import Function
from evenspin.cycles.costs import tenths
from evenspin.cycles.layout import Layout

TERMINATOR = re.compile(r"^\s+(?:br|ret|switch|unreachable)\b")
COUNTER = "evenspin_cycles"
# What the compiler found out about a function without the counter: that it writes no memory, that equal calls are one.
PROMISES = re.compile(r"\b(?:memory\([^)]*\)|readnone|readonly|writeonly|speculatable)\s*")


def instrument(text: str) -> str:
    """The program with a counter of instructions."""
    whole = text.splitlines()
    layout = Layout(whole)
    function: Function | None = None
    lines: list[str] = []
    serial = 0
    block: Counter[str] = Counter()
    for number, line in enumerate(whole):
        if line.startswith("define "):
            function = Function.read(whole[number : whole.index("}", number)], layout)
            block.clear()
        elif line == "}":
            function = None
        elif function is not None:
            block += function.classes(line)
            if TERMINATOR.match(line):
                cost = tenths(block)
                if cost and not line.lstrip().startswith("unreachable"):
                    lines += [
                        f"  %evs.a{serial} = load i64, ptr @{COUNTER}",
                        f"  %evs.b{serial} = add i64 %evs.a{serial}, {cost}",
                        f"  store i64 %evs.b{serial}, ptr @{COUNTER}",
                    ]
                    serial += 1
                block.clear()
        lines.append(PROMISES.sub("", line) if line.startswith("attributes #") else line)
    if f"@{COUNTER} = " not in text:
        lines.append(f"@{COUNTER} = external global i64")
    return "\n".join(lines) + "\n"
