"""The counting of stack and image, on small programs whose words are known by hand."""

from __future__ import annotations

import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import check
import sizes
import stack

# main_start > a > c (external); main_pass > b; octets of the frames: 8, 20, 0, 6
GRAPH = """graph: { title: "x.c"
node: { title: "main_start" label: "main_start\\nx.c:1:1\\n8 bytes (static)" }
node: { title: "x.c:a" label: "a\\nx.c:2:1\\n20 bytes (static)" }
node: { title: "c" label: "c\\nx.h:2:1" shape : ellipse }
node: { title: "main_pass" label: "main_pass\\nx.c:3:1\\n0 bytes (static)" }
node: { title: "b" label: "b\\nx.c:4:1\\n6 bytes (static)" }
edge: { sourcename: "main_start" targetname: "x.c:a" label: "x.c:1:9" }
edge: { sourcename: "x.c:a" targetname: "c" label: "x.c:2:9" }
edge: { sourcename: "main_pass" targetname: "b" label: "x.c:3:9" }
}
"""
COMMANDS = """MEMORY
{
    CODE  : origin = 0x8000, length = 0x000100
    ROM_A : origin = 0x80000, length = 0x000010
    ROM_B : origin = 0x81000, length = 0x000030
}
SECTIONS
{
    .text    : >> ROM_A | ROM_B, ALIGN(8) /* : > CODE */
    .ramfunc : LOAD = ROM_B, RUN = CODE, ALIGN(8),
               LOAD_START(A), RUN_START(B)
}
"""


def graph_of(text: str, pointers: dict[str, tuple[str, ...]] | None = None) -> stack.Graph:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.ci"
        path.write_text(text)
        graph = stack.Graph()
        graph.read(path, pointers or {})
        return graph


class Stack(unittest.TestCase):
    def test_a_way_counts_frames_return_addresses_and_what_is_not_compiled(self) -> None:
        words, way = stack.deepest(graph_of(GRAPH), "main_start")
        self.assertEqual(words, (4 + 2) + (10 + 2) + stack.EXTERNAL_WORDS)
        self.assertEqual(way, ["main_start", "x.c:a", "c"])
        self.assertEqual(stack.deepest(graph_of(GRAPH), "main_pass")[0], (0 + 2) + (3 + 2))

    def test_the_worst_is_the_deeper_main_with_every_interrupt_on_top(self) -> None:
        found = [stack.Depth("main_start", 30, []), stack.Depth("main_pass", 40, [])]
        found += [stack.Depth(name, 100, []) for name in stack.INTERRUPTS]
        self.assertEqual(stack.worst(found), 40 + 300)

    def test_an_interrupt_counts_what_is_pushed_before_it_runs(self) -> None:
        text = "".join(
            f'node: {{ title: "{name}" label: "{name}\\nx.c:1:1\\n4 bytes (static)" }}\n'
            for name in (*stack.MAIN, *stack.INTERRUPTS)
        )
        found = {depth.name: depth.words for depth in stack.depths([graph_of(text)])}
        self.assertEqual(found["main_pass"], 4)
        self.assertGreaterEqual(found["main_speed_isr"], 4 + 14)  # the CPU itself pushes 14

    def test_what_cannot_be_told_is_refused(self) -> None:
        again = 'edge: { sourcename: "b" targetname: "main_pass" label: "x.c:4:9" }\n'
        with self.assertRaisesRegex(stack.Unknown, "recursion: main_pass -> b -> main_pass"):
            stack.deepest(graph_of(GRAPH + again), "main_pass")
        with self.assertRaisesRegex(stack.Unknown, "variable size"):
            graph_of(GRAPH.replace("6 bytes (static)", "6 bytes (dynamic)"))
        pointer = 'edge: { sourcename: "b" targetname: "__indirect_call" label: "x.c:4:9" }\n'
        with self.assertRaisesRegex(stack.Unknown, "through a pointer at x.c:4:9"):
            graph_of(GRAPH + pointer)

    def test_a_call_through_a_pointer_reaches_the_deepest_of_those_it_can_be(self) -> None:
        pointer = 'edge: { sourcename: "b" targetname: "__indirect_call" label: "x.c:4:9" }\n'
        deep = 'node: { title: "request_x" label: "request_x\\ny.c:1:1\\n200 bytes (static)" }\n'
        words, way = stack.deepest(graph_of(GRAPH + pointer + deep, {"x.c": ("request_",)}), "main_pass")
        self.assertEqual(way[-1], "request_x")
        self.assertEqual(words, 2 + 5 + 102)


class Sizes(unittest.TestCase):
    def test_a_character_is_a_word_and_other_octets_are_half_of_one(self) -> None:
        self.assertEqual(sizes.section_of(".rodata.params_info.str1.4", "x.c", set(), set()), (".const", 1))
        self.assertEqual(sizes.section_of(".rodata.TABLE", "x.c", set(), set()), (".const", 2))

    def test_code_lies_in_ram_when_its_file_or_its_function_is_marked(self) -> None:
        self.assertEqual(sizes.section_of(".text.f", "x.c", {"x.c"}, set())[0], ".TI.ramfunc")
        self.assertEqual(sizes.section_of(".text.f", "x.c", set(), {"f"})[0], ".TI.ramfunc")
        self.assertEqual(sizes.section_of(".text.f", "x.c", set(), {"g"})[0], ".text")

    def test_the_objects_of_main_with_blocks_of_their_own_are_told_apart(self) -> None:
        self.assertEqual(sizes.section_of(".bss.drive", sizes.MAIN, set(), set())[0], "drive_memory")
        self.assertEqual(sizes.section_of(".bss.drive", "x.c", set(), set())[0], ".bss")


class Fit(unittest.TestCase):
    def test_the_observer_of_the_ram_build_takes_two_words_less_for_each_number_it_does_not_hold(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "firmware/app").mkdir(parents=True)
            (Path(folder) / "firmware/CMakeLists.txt").write_text('"$<x:DRIVE_OBSERVER_CAPACITY=1000U>"')
            (Path(folder) / "firmware/app/drive.h").write_text("#define DRIVE_OBSERVER_CAPACITY 1500U /**< x */")
            self.assertEqual(check.observer_words(Path(folder)), 1000)

    def test_regions_of_a_command_file(self) -> None:
        length, placed = check.regions(COMMANDS)
        self.assertEqual(length, {"CODE": 0x100, "ROM_A": 0x10, "ROM_B": 0x30})
        self.assertEqual(placed, {".text": [("ROM_A", "ROM_B")], ".ramfunc": [("ROM_B",), ("CODE",)]})

    def test_what_loads_and_what_runs_are_both_counted(self) -> None:
        self.assertEqual(check.fit("x", COMMANDS, {".text": 0x20, ".ramfunc": 0x18}, 0.9)[1], [])
        (fault,) = check.fit("x", COMMANDS, {".text": 0x28, ".ramfunc": 0x18}, 0.9)[1]
        self.assertIn("ROM_A + ROM_B: 64 of 64 words, 90 % allowed", fault)
        self.assertEqual(len(check.fit("x", COMMANDS, {".ramfunc": 0x2F}, 0.9)[1]), 1)
        self.assertEqual(check.fit("x", COMMANDS, {".new": 1}, 0.9)[1], ["x: .new is placed nowhere"])

    def test_growth_beyond_what_is_recorded_is_a_fault(self) -> None:
        self.assertEqual(check.grown("file", {"a": 270}, {"a": 100}, 1.2, 150), [])
        self.assertEqual(len(check.grown("file", {"a": 271}, {"a": 100}, 1.2, 150)), 1)


if __name__ == "__main__":
    unittest.main()
