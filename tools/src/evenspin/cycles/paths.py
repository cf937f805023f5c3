"""Longest path through one function of LLVM's text, whatever its inputs: blocks, loops with bounds, calls."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from evenspin.cycles.classes import CALLED, MARKED, REGISTERS, Function
from evenspin.cycles.costs import tenths
from evenspin.cycles.layout import Layout
from evenspin.errors import InputError

DEFINED = re.compile(r"^define (?P<how>[^@]*)@(?P<name>[\w.$]+)\(")
LABEL = re.compile(r'^(?P<label>"[^"]+"|[-\w.$]+):')
TARGET = re.compile(r'label %("[^"]+"|[-\w.$]+)')
PLACE = re.compile(r", !dbg !(\d+)")
TERMINATOR = re.compile(r"^\s+(?:br|ret|switch|unreachable)\b")
LOCATION = re.compile(r"^!(\d+) = (?:distinct )?!DILocation\(line: (\d+).*?scope: !(\d+)(?:, inlinedAt: !(\d+))?")
SUBPROGRAM = re.compile(r'^!(\d+) = distinct !DISubprogram\(name: "(\w+)"')
LEXICAL = re.compile(r"^!(\d+) = (?:distinct )?!DILexicalBlock(?:File)?\(scope: !(\d+)")
# A loop that counts: its number, the next number, and the comparison that ends it.
COUNTED = re.compile(r"^phi (?:i\d+) (.*)$")
NEXT = re.compile(r"^add i\d+ (%[-\w.$]+), (-?\d+)$")
ENDS = re.compile(r"^icmp (eq|ne|ult|ugt|slt|sgt) i\d+ (%[-\w.$]+), (-?\d+)$")
ROUNDS_MOST = 100000


@dataclass(slots=True)
class Block:
    """What runs from its first line to its last."""

    label: str
    cost: int = 0  # tenths of a cycle, as the counter adds
    following: list[str] = field(default_factory=list)
    calls: list[str] = field(default_factory=list)
    places: list[tuple[str, ...]] = field(
        default_factory=list
    )  # of each line: functions of the source, the innermost first
    end: tuple[str, int] = ("", 0)  # function and line of the source of its end
    lines: list[str] = field(default_factory=list)
    returns: bool = False


@dataclass(slots=True)
class Code:
    """A function."""

    name: str
    file: str
    own: bool  # no other file sees it
    blocks: dict[str, Block]
    first: str


@dataclass(frozen=True, slots=True)
class Way:
    """A part of a program that runs one after the other; what of it each function takes, in tenths."""

    cost: int
    shares: Mapping[str, int]

    def then(self, other: Way) -> Way:
        shares = dict(self.shares)
        for name, cost in other.shares.items():
            shares[name] = shares.get(name, 0) + cost
        return Way(self.cost + other.cost, shares)

    def times(self, number: int) -> Way:
        return Way(self.cost * number, {name: cost * number for name, cost in self.shares.items()})


NOTHING = Way(0, {})


class Places:
    """Where a line comes from: LLVM's notes of source lines."""

    def __init__(self, lines: Sequence[str]) -> None:
        self.located: dict[str, tuple[int, str, str | None]] = {}
        self.scopes: dict[str, str] = {}
        self.names: dict[str, str] = {}
        for line in lines:
            if not line.startswith("!"):
                continue
            if match := LOCATION.match(line):
                self.located[match[1]] = (int(match[2]), match[3], match[4])
            elif match := SUBPROGRAM.match(line):
                self.names[match[1]] = match[2]
            elif match := LEXICAL.match(line):
                self.scopes[match[1]] = match[2]

    def of(self, line: str) -> tuple[tuple[str, ...], int]:
        """The functions that a line was written in and inlined to, the innermost first, and the line there."""
        match = PLACE.search(line)
        at = match[1] if match else None
        chain: list[str] = []
        number = 0
        while at is not None and at in self.located:
            here, scope, outer = self.located[at]
            while scope in self.scopes:
                scope = self.scopes[scope]
            chain.append(self.names.get(scope, ""))
            number = number if len(chain) > 1 else here
            at = outer
        return tuple(chain), number


def read_code(text: str, file: str) -> list[Code]:
    """All functions of a file."""
    whole = text.splitlines()
    layout, places = Layout(whole), Places(whole)
    found = []
    for number, line in enumerate(whole):
        match = DEFINED.match(line)
        if match is not None:
            body = whole[number : whole.index("}", number)]
            blocks = read_blocks(body, layout, places)
            found.append(Code(match["name"], file, "internal" in match["how"], blocks, next(iter(blocks))))
    return found


def read_blocks(body: Sequence[str], layout: Layout, places: Places) -> dict[str, Block]:
    bare = [PLACE.sub("", line) for line in body]
    function = Function.read(bare, layout)
    blocks: dict[str, Block] = {}
    block = Block("entry")
    counts: Counter[str] = Counter()
    ended = False
    for noted, line in zip(body[1:], bare[1:], strict=True):
        label = LABEL.match(line)
        if label is not None:
            block, counts, ended = Block(label["label"]), Counter(), False
            continue
        if ended:
            block.following += TARGET.findall(line)  # of a switch
            continue
        if not line.strip() or line.lstrip().startswith(";"):
            continue
        if block.label not in blocks:
            blocks[block.label] = block
        counts += function.classes(line)
        block.lines.append(line)
        chain, number = places.of(noted)
        if chain and number and not line.lstrip().startswith("br label"):  # a jump stands where it leads to
            block.places.append(chain)
        if callee := callee_of(line):
            block.calls.append(callee)
        if TERMINATOR.match(line):
            block.cost, ended = tenths(counts), True
            block.following += TARGET.findall(line)
            block.returns = line.lstrip().startswith("ret")
            block.end = (chain[0] if chain else "", number)
    return blocks


def callee_of(line: str) -> str | None:
    """The function that a line calls, unless its instructions stand in its place; `*` when a pointer says which."""
    if re.match(r"^\s+(?:%\S+ = )?(?:tail |musttail |notail )?call\b", line) is None or " asm " in line:
        return None
    match = CALLED.search(line)
    if match is None:
        return "*"
    name = match[1]
    return None if name.startswith("llvm.") or name in MARKED or name in REGISTERS else name


def dominators(blocks: Mapping[str, Block], first: str) -> tuple[list[str], dict[str, set[str]]]:
    """Reached blocks in reverse postorder, and what dominates each."""
    order: list[str] = []
    seen = {first}
    stack: list[tuple[str, Iterator[str]]] = [(first, iter(blocks[first].following))]
    while stack:
        label, rest = stack[-1]
        for name in rest:
            if name in blocks and name not in seen:
                seen.add(name)
                stack.append((name, iter(blocks[name].following)))
                break
        else:
            order.append(label)
            stack.pop()
    order.reverse()
    before: dict[str, list[str]] = {label: [] for label in order}
    for label in order:
        for name in blocks[label].following:
            if name in before:
                before[name].append(label)
    found = {label: set(order) for label in order}
    found[first] = {first}
    changed = True
    while changed:
        changed = False
        for label in order[1:]:
            new = set.intersection(*(found[name] for name in before[label])) | {label}
            if new != found[label]:
                found[label], changed = new, True
    return order, found


@dataclass(frozen=True, slots=True)
class Loop:
    """A loop: all blocks between its head and the jumps back."""

    head: str
    body: frozenset[str]
    back: tuple[str, ...]


def loops_of(code: Code) -> list[Loop]:
    """Inner loops before outer ones."""
    blocks = code.blocks
    order, dominated = dominators(blocks, code.first)
    place = {label: number for number, label in enumerate(order)}
    back: dict[str, list[str]] = {}
    for label in order:
        for name in blocks[label].following:
            if name in place and place[name] <= place[label]:
                if name not in dominated[label]:
                    raise InputError("cycles", "loop", code.name, "a loop with one entry", "write it with for or while")
                back.setdefault(name, []).append(label)
    before: dict[str, set[str]] = {label: set() for label in order}
    for label in order:
        for name in blocks[label].following:
            if name in before:
                before[name].add(label)
    found = []
    for head, ends in back.items():
        body, todo = {head}, list(ends)
        while todo:
            label = todo.pop()
            if label not in body:
                body.add(label)
                todo += before[label]
        found.append(Loop(head, frozenset(body), tuple(ends)))
    return sorted(found, key=lambda loop: len(loop.body))


def is_tested_at_its_end(code: Code, loop: Loop) -> bool:
    """Whether every jump back is a test, too: then a body that runs n times jumps back n - 1 times."""
    return all(any(name not in loop.body for name in code.blocks[label].following) for label in loop.back)


def counted_rounds(code: Code, loop: Loop) -> int | None:
    """How often the body runs when it counts from one constant to another and nothing else but that ends it later."""
    if len(loop.back) != 1:
        return None
    (end,) = loop.back
    texts = {}
    for label in loop.body:
        for line in code.blocks[label].lines:
            match = re.match(r"^\s+(%[-\w.$]+) = (.*)$", line)
            if match is not None:
                texts[match[1]] = re.sub(r"\b(?:nuw|nsw) ", "", match[2])
    tested = re.match(r"^\s+br i1 (%[-\w.$]+), label %([^,\s]+), label %([^,\s]+)", code.blocks[end].lines[-1])
    comparison = ENDS.match(texts.get(tested[1], "")) if tested else None
    if tested is None or comparison is None:
        return None
    goes_on_when = tested[2] in loop.body
    how, name, last = comparison[1], comparison[2], int(comparison[3])
    step = NEXT.match(texts.get(name, ""))
    number = step[1] if step else name
    counter = COUNTED.match(texts.get(number, ""))
    values = (
        {source: value for value, source in re.findall(r"\[ ([^,]+), %([-\w.$]+) \]", counter[1])} if counter else {}
    )
    begins = [value for source, value in values.items() if source not in loop.body]
    nexts = [value for source, value in values.items() if source in loop.body]
    if len(begins) != 1 or len(nexts) != 1 or re.fullmatch(r"-?\d+", begins[0]) is None:
        return None
    by = NEXT.match(texts.get(nexts[0], ""))
    if by is None or by[1] != number:
        return None
    value, compare = int(begins[0]), COMPARISONS[how]
    for rounds in range(1, ROUNDS_MOST):
        after = value + int(by[2])
        if compare(after if step else value, last) != goes_on_when:
            return rounds
        value = after
    return None


COMPARISONS: dict[str, Callable[[int, int], bool]] = {
    "eq": lambda a, b: a == b,
    "ne": lambda a, b: a != b,
    "ult": lambda a, b: a < b,
    "ugt": lambda a, b: a > b,
    "slt": lambda a, b: a < b,
    "sgt": lambda a, b: a > b,
}


def longest(
    code: Code,
    rounds: Callable[[Code, Loop], int],
    cost: Callable[[Code, Block], Way | None],
) -> Way | None:
    """Dearest way from the first block to a return. None: there is none.

    @param rounds  how often the body of a loop runs at most
    @param cost    what a block takes with all that it calls; None: it never runs
    """
    paths: dict[str, Way] = {}
    for label, block in code.blocks.items():
        path = cost(code, block)
        if path is not None:
            paths[label] = path
    edges: dict[str, dict[str, Way]] = {
        label: {name: NOTHING for name in code.blocks[label].following if name in paths} for label in paths
    }
    order = [label for label in dominators(code.blocks, code.first)[0] if label in paths]
    for loop in loops_of(code):
        if loop.head not in paths:
            continue
        inside = [label for label in order if label in loop.body and label in paths]
        reached = distances(loop.head, inside, paths, edges)
        round_ = dearest(
            reached[label].then(edges[label][loop.head])
            for label in inside
            if label in reached and loop.head in edges[label]
        )
        out: dict[str, Way] = {}
        for label in inside:
            for name, edge in edges[label].items() if label in reached else ():
                if name not in loop.body:
                    leaving = reached[label].then(edge)
                    out[name] = max(leaving, out.get(name, leaving), key=lambda path: path.cost)
        for label in inside:
            if label != loop.head:
                del paths[label], edges[label]
        jumps = 0 if round_ is None else rounds(code, loop) - is_tested_at_its_end(code, loop)
        paths[loop.head] = NOTHING if round_ is None else round_.times(max(jumps, 0))
        edges[loop.head] = out
        order = [label for label in order if label in paths]
    if code.first not in paths:
        return None
    reached = distances(code.first, order, paths, edges)
    return dearest(reached[label] for label in order if label in reached and code.blocks[label].returns)


def distances(
    first: str, order: Sequence[str], paths: Mapping[str, Way], edges: Mapping[str, Mapping[str, Way]]
) -> dict[str, Way]:
    """The dearest way to the end of each block, without a jump back to the first."""
    reached = {first: paths[first]}
    for label in order:
        if label not in reached:
            continue
        for name, edge in edges[label].items():
            if name == first or name not in paths or name not in order:
                continue
            way = reached[label].then(edge).then(paths[name])
            if name not in reached or way.cost > reached[name].cost:
                reached[name] = way
    return reached


def dearest(paths: Iterable[Way]) -> Way | None:
    return max(paths, key=lambda path: path.cost, default=None)
