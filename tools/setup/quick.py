"""Lint what has changed and run the tests that a change touches, nearest first, within a minute.

    quick.py [--since REVISION] [--seconds SECONDS]

Changed is what differs from REVISION (by default the commit at which this branch left its upstream; without one, the
last commit), and what git does not know yet.
C       The host preset is built, and the tests run whose programs that made again.
Python  Test files that import a changed module, directly or through others, in the order of that distance: as many as
        fit into SECONDS by the times of the last whole run. What does not fit is counted; `make test` runs it.

The last line is `N passed, N failed`. Exit status: 0 none failed, 1 some failed, 2 wrong usage.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import run_tests

ROOT = run_tests.ROOT
TESTS = "tools/tests"
SOURCES = "tools/src"
UNKNOWN_S = 4.0  # a test file that no whole run has timed yet
C_FOLDERS = ("control/", "firmware/", "hal/", "sim_host/", "tests/", "cmake/", "CMakeLists.txt", "CMakePresets.json")

sys.path.insert(0, str(ROOT / "tests/architecture"))
import check_python_layers  # noqa: E402  (it knows how the packages import one another)


def git(*words: str) -> str:
    done = subprocess.run(["git", *words], cwd=ROOT, text=True, capture_output=True, check=False)
    return done.stdout.strip() if done.returncode == 0 else ""


def base_revision(wanted: str | None) -> str:
    """What to compare with: @p wanted, else where this branch left its upstream, else the last commit but one."""
    if wanted is not None:
        if not git("rev-parse", "--verify", "--quiet", f"{wanted}^{{commit}}"):
            print(f"quick.py: there is no revision {wanted}; `git log --oneline` lists them", file=sys.stderr)
            sys.exit(2)
        return wanted
    here = git("rev-parse", "HEAD")
    fork = git("merge-base", "HEAD", "@{upstream}")
    if (fork and fork != here) or git("status", "--porcelain"):
        return fork or here
    return git("rev-parse", "--verify", "--quiet", "HEAD~1") or here


def changed_files(base: str) -> list[str]:
    listed = git("diff", "--name-only", base) + "\n" + git("ls-files", "--others", "--exclude-standard")
    return sorted({name for name in listed.splitlines() if name})


def import_graph() -> dict[str, list[str]]:
    """The files, from the root of the repository, that each Python file of the package and of its tests imports."""
    modules = {check_python_layers.module_name(path, ROOT / SOURCES): path for path in (ROOT / SOURCES).rglob("*.py")}
    tests = ROOT / TESTS
    helpers = {path.stem: path for path in tests.rglob("*.py")}
    known = modules | helpers
    return {
        path.relative_to(ROOT).as_posix(): sorted(
            known[item.module].relative_to(ROOT).as_posix()
            for item in check_python_layers.imports_of(path.read_text(encoding="utf-8"), known)
            if known[item.module] != path
        )
        for path in [*modules.values(), *tests.rglob("*.py")]
    }


def distances(graph: Mapping[str, Iterable[str]], changed: Iterable[str]) -> dict[str, int]:
    """How many imports lie between each file and the nearest changed one; files that none reaches are left out."""
    importers: dict[str, list[str]] = {}
    for file, imports in graph.items():
        for other in imports:
            importers.setdefault(other, []).append(file)
    found = dict.fromkeys((file for file in changed if file in graph), 0)
    queue = list(found)
    for file in queue:
        for importer in importers.get(file, ()):
            if importer not in found:
                found[importer] = found[file] + 1
                queue.append(importer)
    return found


def times_of(junit: Path) -> dict[str, float]:
    """Seconds that each test file took in the last whole run; nothing when there has been none."""
    seconds: dict[str, float] = {}
    if junit.exists():
        for case in ET.parse(junit).getroot().iter("testcase"):
            parts = (case.get("classname") or "").split(".")
            file = next(
                (f"{'/'.join(parts[:n])}.py" for n in range(len(parts), 0, -1) if parts[n - 1][:5] == "test_"), ""
            )
            seconds[file] = seconds.get(file, 0.0) + float(case.get("time") or 0.0)
    return seconds


def chosen(near: Mapping[str, int], seconds: Mapping[str, float], budget_s: float) -> tuple[list[str], list[str]]:
    """Test files that fit into a budget, nearest and quickest first, and those that do not."""
    tests = [file for file in near if file.startswith(TESTS) and file.rsplit("/", 1)[1].startswith("test_")]
    tests.sort(key=lambda file: (near[file], seconds.get(file, UNKNOWN_S), file))
    taken, left, total = [], [], 0.0
    for file in tests:
        cost = seconds.get(file, UNKNOWN_S)
        if total + cost <= budget_s:
            total += cost
            taken.append(file)
        else:
            left.append(file)
    return taken, left


def rebuilt_tests(step: run_tests.Step) -> list[str]:
    """Build the host preset: the names of the tests whose programs are new."""
    start_s = time.time()
    step.build()
    listed = json.loads(step.need("ctest", "--preset", step.name, "--show-only=json-v1"))
    return [
        test["name"]
        for test in listed["tests"]
        if "command" in test
        and Path(test["command"][0]).exists()
        and Path(test["command"][0]).stat().st_mtime >= start_s
    ]


def c_part(step: run_tests.Step) -> run_tests.Count:
    names = rebuilt_tests(step)
    if not names:
        step.say("[quick] no C test was built again")
        return run_tests.Count()
    pattern = "^(" + "|".join(names) + ")$"
    only = ("-R", pattern, "--output-junit", step.junit)
    return step.counted("ctest", "--preset", step.name, "--parallel", run_tests.JOBS, *only)


def python_part(step: run_tests.Step, changed: Sequence[str], budget_s: float) -> run_tests.Count:
    near = distances(import_graph(), changed)
    taken, left = chosen(near, times_of(run_tests.RESULTS / "python.xml"), budget_s * int(run_tests.JOBS))
    if left:
        step.say(f"[quick] {len(left)} test files do not fit into {budget_s:g} s, as {left[0]}; `make test` runs them")
    if not taken:
        return run_tests.Count()
    shared = ("-n", run_tests.JOBS, "--dist", "loadfile") if len(taken) > 1 else ()
    return step.counted(sys.executable, "-m", "pytest", "-q", *shared, f"--junitxml={step.junit}", *taken)


def main(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--since", metavar="REVISION", help="compare with this commit")
    parser.add_argument("--seconds", type=float, default=35.0, help="budget of the Python tests (default: %(default)s)")
    options = parser.parse_args(arguments)
    changed = changed_files(base_revision(options.since))
    print(f"[quick] {len(changed)} changed files", flush=True)
    run_tests.RESULTS.mkdir(parents=True, exist_ok=True)
    parts: list[run_tests.Part] = [run_tests.step_of("lint")]
    if any(name.startswith(C_FOLDERS) for name in changed):
        parts.append(("host", run_tests.Step("host"), c_part))
    if any(name.endswith(".py") for name in changed):
        # A result of its own: python.xml keeps the times of the last whole run.
        parts.append(("python", run_tests.Step("quick"), lambda step: python_part(step, changed, options.seconds)))
    return run_tests.run_parts(parts)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
