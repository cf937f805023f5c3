"""Make every basic block of LLVM's text add its cost to a counter."""

from __future__ import annotations

import re

from evenspin.cycles.costs import cost, names_in_memory, widened

TERMINATOR = re.compile(r"^\s+(?:br|ret|switch|unreachable)\b")
COUNTER = "evenspin_cycles"


def instrument(text: str) -> str:
    """The same program with a counter."""
    lines: list[str] = []
    inside = False
    block = 0
    serial = 0
    narrow: set[str] = set()
    whole = text.splitlines()
    in_memory: set[str] = set()
    for number, line in enumerate(whole):
        if line.startswith("define "):
            inside, block = True, 0
            narrow.clear()
            in_memory = names_in_memory(whole[number : whole.index("}", number)])
        elif line == "}":
            inside = False
        elif inside:
            name = widened(line)
            if name is not None:
                narrow.add(name)
            if TERMINATOR.match(line):
                block += cost(line, narrow, in_memory)
                if block and not line.lstrip().startswith("unreachable"):
                    lines += [
                        f"  %evs.a{serial} = load i64, ptr @{COUNTER}",
                        f"  %evs.b{serial} = add i64 %evs.a{serial}, {block}",
                        f"  store i64 %evs.b{serial}, ptr @{COUNTER}",
                    ]
                    serial += 1
                block = 0
            else:
                block += cost(line, narrow, in_memory)
        lines.append(line)
    if f"@{COUNTER} = " not in text:
        lines.append(f"@{COUNTER} = external global i64")
    return "\n".join(lines) + "\n"
