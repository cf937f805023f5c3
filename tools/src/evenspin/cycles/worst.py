"""Worst case over all inputs: the longest path through what an interrupt can run, with a bound for every loop.

Nothing is run for it. The blocks and their costs are those of the counter (paths.py, instrument.py); how often a loop
goes round at most comes from its constants or from tests/budget/worst.toml, which names also what cannot happen
together. A loop without a bound is an error, a call of something unknown too.
"""

from __future__ import annotations

import ast
import math
import operator
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from evenspin.cycles.paths import Block, Code, Loop, Way, counted_rounds, longest, loops_of, read_code
from evenspin.errors import InputError

BOUNDS = Path("tests/budget/worst.toml")
ANY, MOVING = "any", "moving"
KINDS = (ANY, MOVING)
OPERATIONS: dict[type, Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.FloorDiv: operator.floordiv,
}


def rounds_of(text: str | int, names: Mapping[str, float]) -> int:
    """A number of rounds: sums, products and whole quotients of numbers and of what has a name."""

    def value(node: ast.AST) -> float:
        if isinstance(node, ast.BinOp) and type(node.op) in OPERATIONS:
            return OPERATIONS[type(node.op)](value(node.left), value(node.right))
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            return node.value
        name = ast.unparse(node)
        if name not in names:
            raise InputError(BOUNDS, "rounds", str(text), "numbers, parameters, default.parameter", f"{name}: unknown")
        return names[name]

    return math.ceil(value(ast.parse(str(text), mode="eval").body))


@dataclass(frozen=True, slots=True)
class Bound:
    """How often a loop of the source goes round at most."""

    any: int
    moving: int

    def of(self, kind: str) -> int:
        return self.any if kind == ANY else self.moving


@dataclass(frozen=True, slots=True)
class Never:
    """Calls that a function never makes in an interrupt."""

    inside: str
    calls: str


@dataclass(frozen=True, slots=True)
class Setup:
    """What a choice of parameters leaves out: functions, or `f>g` for the calls of g that f makes."""

    name: str
    absent: frozenset[str]


EVERYTHING = Setup("any", frozenset())


@dataclass(frozen=True, slots=True)
class Limits:
    """What worst.toml says."""

    loops: Mapping[str, tuple[Bound, ...]] = field(default_factory=dict)
    never: tuple[Never, ...] = ()
    setups: tuple[Setup, ...] = ()
    library: Mapping[str, int] = field(default_factory=dict)  # cycles, beside the call

    @classmethod
    def read(cls, path: Path, names: Mapping[str, float]) -> Limits:
        with path.open("rb") as file:
            document = tomllib.load(file)
        loops = {}
        for function, found in document.get("loop", {}).items():
            for each in found:
                if not each.get("why"):
                    raise InputError(path, f"loop.{function}", "no `why`", "a reason", "say why it is bounded")
            loops[function] = tuple(
                Bound(rounds_of(each["rounds"], names), rounds_of(each.get("moving", each["rounds"]), names))
                for each in found
            )
        for entry in (*document.get("never", []), *document.get("setup", [])):
            if not entry.get("why"):
                raise InputError(path, str(entry), "no `why`", "a reason", "say why this cannot happen")
        return cls(
            loops,
            tuple(Never(entry["inside"], entry["calls"]) for entry in document.get("never", [])),
            tuple(Setup(entry["name"], frozenset(entry["absent"])) for entry in document.get("setup", [])),
            {name: entry["cycles"] for name, entry in document.get("library", {}).items()},
        )

    def setups_of(self, row: str) -> list[Setup]:
        """The set-ups that a measured row such as `current_isr pi` is one of: any, and the one of its name."""
        return [EVERYTHING, *(setup for setup in self.setups if row.partition("_isr ")[2] == setup.name)]


@dataclass(frozen=True, slots=True)
class Worst:
    """The longest path of one function."""

    tenths: int
    shares: Mapping[str, int]  # cycles of each function on it


class Program:
    """All functions of a program, and what calls what."""

    def __init__(self, codes: Sequence[Code], limits: Limits, renamed: Mapping[str, str] | None = None) -> None:
        """@param renamed  prefixes of calls: hal_x of the firmware is chip_x in the port that the estimate compiles"""
        self.limits = limits
        self.renamed = renamed or {}
        self.everywhere = {code.name: code for code in codes if not code.own}
        self.inside = {(code.file, code.name): code for code in codes}
        lines: dict[str, set[int]] = {}
        for code in codes:
            for loop in loops_of(code):
                for label in loop.back:
                    name, line = code.blocks[label].end
                    lines.setdefault(name, set()).add(line)
        self.loop_lines = {name: sorted(found) for name, found in lines.items()}

    def called(self, code: Code, name: str) -> Code | None:
        for prefix, other in self.renamed.items():
            if name.startswith(prefix) and other + name.removeprefix(prefix) in self.everywhere:
                name = other + name.removeprefix(prefix)
        return self.inside.get((code.file, name)) or self.everywhere.get(name)

    def reached(self, *names: str) -> set[str]:
        """Functions that other files see, among all that these can call, themselves included."""
        seen: set[tuple[str, str]] = set()
        todo = [self.everywhere[name] for name in names]
        while todo:
            code = todo.pop()
            if (code.file, code.name) not in seen:
                seen.add((code.file, code.name))
                called = (self.called(code, name) for block in code.blocks.values() for name in block.calls)
                todo += [target for target in called if target is not None]
        return {name for _, name in seen if name in self.everywhere}

    def rounds(self, code: Code, loop: Loop, kind: str) -> int:
        """The bound of a loop, by its constants or by the table."""
        counted = counted_rounds(code, loop)
        if counted is not None:
            return counted
        name, line = code.blocks[loop.back[0]].end
        stated = self.limits.loops.get(name, ())
        lines = self.loop_lines[name]
        if len(stated) != len(lines):
            must = f"a bound for each of the {len(lines)} loops of {name}, lines {', '.join(map(str, lines))}"
            raise InputError(
                BOUNDS, f"loop.{name}", f"{len(stated)} bounds", must, f"the loop of line {line}, in {code.file}"
            )
        return stated[lines.index(line)].of(kind)

    def worst(self, name: str, kind: str = ANY, setup: Setup = EVERYTHING) -> Worst:
        """The longest path of a function. Its own call or entry is not in it."""
        found = self.longest(name, kind, setup.absent)
        if found is None:
            raise InputError(
                "cycles", "worst case", name, "a function that returns", f"look at {setup.name} in {BOUNDS}"
            )
        shares = sorted(found.shares.items(), key=lambda item: -item[1])
        return Worst(found.cost, {function: round(cost / 10) for function, cost in shares})

    def longest(self, name: str, kind: str = ANY, absent: frozenset[str] = frozenset()) -> Way | None:
        """The same for one combination: without the functions in @p absent."""
        known: dict[tuple[str, str], Way | None] = {}
        open_: list[str] = []

        def of(code: Code) -> Way | None:
            key = (code.file, code.name)
            if key not in known:
                if code.name in open_:
                    raise InputError("cycles", "worst case", code.name, "no recursion", " calls ".join(open_))
                open_.append(code.name)
                known[key] = longest(code, lambda code, loop: self.rounds(code, loop, kind), cost)
                open_.pop()
            return known[key]

        def cost(code: Code, block: Block) -> Way | None:
            if block.places and any(all(f in chain for chain in block.places) for f in absent):
                return None
            if any(code.name == never.inside and never.calls in block.calls for never in self.limits.never):
                return None
            way = Way(block.cost, {code.name: block.cost})
            for callee in block.calls:
                if callee in absent or f"{code.name}>{callee}" in absent:
                    return None
                target = self.called(code, callee)
                if target is not None:
                    inner = of(target)
                    if inner is None:
                        return None
                    way = way.then(inner)
                elif callee in self.limits.library:
                    tenths = 10 * self.limits.library[callee]
                    way = way.then(Way(tenths, {callee: tenths}))
                else:
                    what = "a pointer" if callee == "*" else callee
                    raise InputError("cycles", "worst case", what, "a function that is known", f"called by {code.name}")
            return way

        return of(self.everywhere[name])


def parameter_names() -> dict[str, float]:
    """Parameters by their largest value, and as default.x by what they are without being set."""
    from evenspin.native import tables

    names: dict[str, float] = {}
    for name, info in tables().params.items():
        names[name] = info.maximum
        names[f"default.{name}"] = info.default
    return names


def read_program(texts: Mapping[str, str], limits: Limits) -> Program:
    """Of LLVM's texts by the name of their files; the port's functions answer the firmware's calls."""
    codes = [code for file, text in texts.items() for code in read_code(text, file)]
    return Program(codes, limits, {"hal_": "chip_"})
