"""The deepest stack of the chip's program, from the call graphs of the compiler.

The stack of the C28x holds words of 16 bits. A frame of the Cortex-M4F counts half its octets; every call adds
the two words of the return address, which the Cortex-M4F does not push for a function that calls none. Inlining
changes frames, so both a build that inlines and one that does not are measured, and the deeper counts. What is
not compiled here (run-time library, driver library) has a fixed share. The main loop, an interrupt of each kind
on top of it, and the trap for everything unexpected on top of those are the worst that can happen: nesting goes
no deeper (hal/f28379d/interrupts.c).
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from chip_objects import WORD

CALL_WORDS = 2  # return address
# A leaf of the run-time or driver library: divisions, memcpy, SysCtl_setClock and the like.
EXTERNAL_WORDS = 24
# Pushed by the CPU (14, and 1 to align), and at most by the compiler at the entry of an interrupt: ACC is done; XT,
# XAR0 to XAR7 (18), the old return address (2), R0H to R7H (16), STF and RB (4).
INTERRUPT_WORDS = 15 + 18 + 2 + 16 + 4
MAIN = ("main_start", "main_pass")
INTERRUPTS = ("main_speed_isr", "main_current_isr", "port_unexpected_isr")
INDIRECT = "__indirect_call"
# Where a function is called through a pointer, and which they can be.
POINTERS = {
    "firmware/services/services.c": ("request_",),
    "firmware/storage/find.c": ("fits_wanted", "take_value", "take_cell"),
    "firmware/storage/store.c": ("value_word", "table_word"),
}

NODE = re.compile(r'^node: \{ title: "([^"]+)" label: "([^"]*)"')
EDGE = re.compile(r'^edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"(?: label: "([^"]*)")?')
FRAME = re.compile(r"\\n(\d+) bytes \((\w+)")


class Unknown(Exception):
    """The depth cannot be determined."""


@dataclass(slots=True)
class Graph:
    frame: dict[str, int] = field(default_factory=dict)  # octets
    calls: dict[str, set[str]] = field(default_factory=dict)
    places: dict[str, str] = field(default_factory=dict)  # file

    def read(self, path: Path, pointers: dict[str, tuple[str, ...]]) -> None:
        for line in path.read_text(encoding="utf-8").splitlines():
            if node := NODE.match(line):
                if frame := FRAME.search(node[2]):
                    if frame[2] == "dynamic":
                        raise Unknown(f"{node[1]}: a frame of variable size")
                    self.frame[node[1]] = int(frame[1])
                    self.places[node[1]] = node[2].split("\\n")[1].split(":")[0]
            elif edge := EDGE.match(line):
                target = edge[2]
                if target == INDIRECT:
                    file = (edge[3] or "").split(":")[0]
                    if file not in pointers:
                        raise Unknown(
                            f"{edge[1]} calls through a pointer at {edge[3]}: add it to POINTERS in {__file__}"
                        )
                    self.calls.setdefault(edge[1], set()).update(f"*{prefix}" for prefix in pointers[file])
                else:
                    self.calls.setdefault(edge[1], set()).add(target)

    def targets(self, name: str) -> Iterable[str]:
        for target in self.calls.get(name, ()):
            if target.startswith("*"):
                yield from (f for f in self.frame if f.split(":")[-1].startswith(target[1:]))
            else:
                yield target


def words_of(frame: int) -> int:
    return (frame + WORD - 1) // WORD + CALL_WORDS


def deepest(graph: Graph, start: str) -> tuple[int, list[str]]:
    """Words from the call of a function on, and the way down there."""
    done: dict[str, tuple[int, list[str]]] = {}

    def walk(name: str, above: tuple[str, ...]) -> tuple[int, list[str]]:
        if name in above:
            raise Unknown(f"recursion: {' -> '.join((*above[above.index(name) :], name))}")
        if name not in done:
            if name not in graph.frame:
                done[name] = (EXTERNAL_WORDS, [name])
            else:
                below = [walk(target, (*above, name)) for target in graph.targets(name)]
                depth, way = max(below, default=(0, []), key=lambda found: found[0])
                done[name] = (words_of(graph.frame[name]) + depth, [name, *way])
        return done[name]

    if start not in graph.frame:
        raise Unknown(f"{start}: not in the call graph")
    return walk(start, ())


def read_graph(work: Path) -> Graph:
    graph = Graph()
    for path in sorted(work.glob("*.ci")):
        graph.read(path, POINTERS)
    return graph


@dataclass(frozen=True, slots=True)
class Depth:
    name: str
    words: int
    way: list[str]


def depths(graphs: Iterable[Graph]) -> list[Depth]:
    """The deepest of each way into the program, over all builds."""
    found = []
    for name in (*MAIN, *INTERRUPTS):
        words, way = max((deepest(graph, name) for graph in graphs), key=lambda one: one[0])
        extra = INTERRUPT_WORDS if name in INTERRUPTS else 0
        found.append(Depth(name, words + extra, way))
    return found


def worst(found: Iterable[Depth]) -> int:
    """The deeper of start-up and main loop, and every interrupt on top."""
    words = {depth.name: depth.words for depth in found}
    return max(words[name] for name in MAIN) + sum(words[name] for name in INTERRUPTS)
