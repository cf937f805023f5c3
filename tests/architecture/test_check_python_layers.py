"""The check of the Python packages finds imports that point the wrong way and circles, and nothing in a clean tree."""

from __future__ import annotations

import contextlib
import io
import re
import tempfile
import unittest
from pathlib import Path

import check_python_layers as layers

ORDER = (("errors",), ("model", "log"), ("cli",))
MODULES = ("evenspin", "evenspin.errors", "evenspin.model", "evenspin.model.parts", "evenspin.log", "evenspin.cli")


def faults(module: str, source: str) -> list[tuple[int, str]]:
    return list(layers.order_faults(module, layers.imports_of(source, MODULES), ORDER))


class Order(unittest.TestCase):
    def test_a_package_imports_what_stands_above_it_and_itself(self) -> None:
        source = "import os\nfrom evenspin.errors import InputError\nfrom evenspin.model import parts\n"
        self.assertEqual(faults("evenspin.model", source), [])
        self.assertEqual(faults("evenspin.cli", source), [])

    def test_an_import_from_below_is_named_with_its_line(self) -> None:
        self.assertEqual(faults("evenspin.model", "\nfrom evenspin.cli import x\n"), [(2, "model does not import cli")])

    def test_packages_of_one_line_do_not_know_each_other(self) -> None:
        self.assertEqual(faults("evenspin.model", "import evenspin.log\n"), [(1, "model does not import log")])

    def test_an_import_inside_of_a_function_or_for_a_type_checker_counts(self) -> None:
        inside = "def f():\n    from evenspin.cli import x\n"
        typed = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from evenspin.cli import X\n"
        self.assertEqual(faults("evenspin.errors", inside), [(2, "errors does not import cli")])
        self.assertEqual(faults("evenspin.errors", typed), [(3, "errors does not import cli")])

    def test_a_package_without_a_place_is_refused(self) -> None:
        self.assertEqual(faults("evenspin.new.part", ""), [(1, "new has no place in ORDER")])

    def test_the_top_of_the_package_has_no_place_in_the_order(self) -> None:
        self.assertEqual(faults("evenspin", "from evenspin.cli import x\n"), [])
        self.assertEqual(faults("evenspin.errors", "import evenspin\n"), [])

    def test_what_is_imported_from_a_package_is_the_module_where_there_is_one(self) -> None:
        found = [item.module for item in layers.imports_of("from evenspin.model import parts, Thing\n", MODULES)]
        self.assertEqual(found, ["evenspin.model.parts", "evenspin.model"])


ROOT = Path(__file__).resolve().parents[2]


class RealOrder(unittest.TestCase):
    def test_the_table_of_packages_in_the_manual_has_the_rows_of_the_order_from_top_to_bottom(self) -> None:
        manual = (ROOT / "docs/architecture.md").read_text()
        table = manual.split("| packages of `tools/src/evenspin` |", 1)[1].split("\n\n", 1)[0]
        rows = [set(re.findall(r"`(\w+)`", line.split("|")[1])) for line in table.splitlines()[2:]]
        self.assertEqual(rows, [set(names) for names in reversed(layers.ORDER)])

    def test_only_the_command_line_knows_the_blind_bench(self) -> None:
        found = list(layers.imports_of("import evenspin.blind\n", ["evenspin.blind"]))
        others = {name for names in layers.ORDER for name in names} - {"blind", "cli"}
        self.assertLess({"gap", "bench", "scope", "log"}, others)
        for name in others:
            self.assertEqual(
                list(layers.order_faults(f"evenspin.{name}", found)), [(1, f"{name} does not import blind")]
            )
        self.assertEqual(list(layers.order_faults("evenspin.cli", found)), [])


class Circles(unittest.TestCase):
    def test_a_circle_of_three_is_found_in_the_order_of_its_imports(self) -> None:
        graph = {"a": ["b", "d"], "b": ["c"], "c": ["a"], "d": []}
        around = layers.circle(graph)
        assert around is not None
        self.assertEqual(around[0], around[-1])
        for importer, imported in zip(around, around[1:], strict=False):
            self.assertIn(imported, graph[importer])

    def test_a_diamond_is_no_circle(self) -> None:
        self.assertIsNone(layers.circle({"a": ["b", "c"], "b": ["d"], "c": ["d"], "d": []}))


class Tree(unittest.TestCase):
    def check(self, files: dict[str, str]) -> tuple[int, str]:
        with tempfile.TemporaryDirectory() as name:
            root = Path(name)
            for path, source in files.items():
                place = root / layers.SOURCES / layers.PACKAGE / path
                place.parent.mkdir(parents=True, exist_ok=True)
                place.write_text(source, encoding="utf-8")
            said = io.StringIO()
            with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
                status = layers.main([str(root)])
            return status, said.getvalue()

    def test_a_clean_tree_is_good(self) -> None:
        status, said = self.check({"errors.py": "", "model/__init__.py": "from evenspin.errors import a\n"})
        self.assertEqual(status, 0)
        self.assertIn("0 violations", said)

    def test_two_circles_are_both_named(self) -> None:
        status, said = self.check(
            {
                "model/a.py": "from evenspin.model import b\n",
                "model/b.py": "from evenspin.model import a\n",
                "sim/a.py": "from evenspin.sim import b\n",
                "sim/b.py": "def f():\n    from evenspin.sim import a\n",
            }
        )
        self.assertEqual(status, 1)
        self.assertEqual(said.count("a circle"), 2)

    def test_a_folder_without_modules_is_no_success(self) -> None:
        self.assertEqual(self.check({})[0], 2)


if __name__ == "__main__":
    unittest.main()
