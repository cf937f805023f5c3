"""Make every basic block of LLVM's text add its cost to a counter."""

from __future__ import annotations

import re

from evenspin.cycles.costs import cost, widened

TERMINATOR = re.compile(r"^\s+(?:br|ret|switch|unreachable)\b")
COUNTER = "evenspin_cycles"


def instrument(text: str) -> str:
    """The same program with a counter."""
    lines: list[str] = []
    inside = False
    block = 0
    serial = 0
    narrow: set[str | None] = set()
    for line in text.splitlines():
        if line.startswith("define "):
            inside, block = True, 0
            narrow.clear()
        elif line == "}":
            inside = False
        elif inside:
            narrow.add(widened(line))
            if TERMINATOR.match(line):
                block += cost(line, narrow)
                if block and not line.lstrip().startswith("unreachable"):
                    lines += [
                        f"  %evs.a{serial} = load i64, ptr @{COUNTER}",
                        f"  %evs.b{serial} = add i64 %evs.a{serial}, {block}",
                        f"  store i64 %evs.b{serial}, ptr @{COUNTER}",
                    ]
                    serial += 1
                block = 0
            else:
                block += cost(line, narrow)
        lines.append(line)
    if f"@{COUNTER} = " not in text:
        lines.append(f"@{COUNTER} = external global i64")
    return "\n".join(lines) + "\n"
