"""What `make quick` runs for a change."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/setup"))

import quick  # noqa: E402

GRAPH = {
    "tools/tests/test_far.py": ["tools/src/evenspin/middle.py"],
    "tools/tests/test_near.py": ["tools/src/evenspin/changed.py"],
    "tools/tests/test_other.py": ["tools/src/evenspin/other.py"],
    "tools/tests/helper.py": ["tools/src/evenspin/changed.py"],
    "tools/src/evenspin/middle.py": ["tools/src/evenspin/changed.py"],
    "tools/src/evenspin/changed.py": [],
    "tools/src/evenspin/other.py": [],
}
CHANGED = ["tools/src/evenspin/changed.py", "README.md"]


def test_tests_that_do_not_reach_the_change_are_not_near() -> None:
    assert quick.distances(GRAPH, CHANGED) == {
        "tools/src/evenspin/changed.py": 0,
        "tools/tests/test_near.py": 1,
        "tools/tests/helper.py": 1,
        "tools/src/evenspin/middle.py": 1,
        "tools/tests/test_far.py": 2,
    }


def test_the_nearest_tests_come_first_and_what_does_not_fit_is_named() -> None:
    near = quick.distances(GRAPH, CHANGED)

    assert quick.chosen(near, {"tools/tests/test_near.py": 6.0, "tools/tests/test_far.py": 5.0}, 10.0) == (
        ["tools/tests/test_near.py"],
        ["tools/tests/test_far.py"],
    )
    assert quick.chosen(near, {"tools/tests/test_near.py": 6.0, "tools/tests/test_far.py": 4.0}, 10.0) == (
        ["tools/tests/test_near.py", "tools/tests/test_far.py"],
        [],
    )


def test_a_changed_test_is_nearest_of_all() -> None:
    near = quick.distances(GRAPH, ["tools/tests/test_far.py", *CHANGED])

    assert quick.chosen(near, {}, 1000.0)[0][0] == "tools/tests/test_far.py"


def test_times_are_added_up_by_file(tmp_path: Path) -> None:
    junit = tmp_path / "python.xml"
    junit.write_text(
        '<testsuites><testsuite><testcase classname="tools.tests.gap.test_a" name="x" time="1.5"/>'
        '<testcase classname="tools.tests.gap.test_a.TestClass" name="y" time="2"/></testsuite></testsuites>'
    )

    assert quick.times_of(junit) == {"tools/tests/gap/test_a.py": 3.5}
    assert quick.times_of(tmp_path / "none.xml") == {}


def test_the_import_graph_has_this_repository_in_it() -> None:
    graph = quick.import_graph()

    assert "tools/src/evenspin/blocks/__init__.py" in graph["tools/tests/test_blocks.py"]
    assert "tools/setup/quick.py" not in graph
