"""Break the code on purpose, one small change at a time, and see which test notices.

    mutate.py BUILD [FILE...] [--sample N] [--seed S] [--log FILE [--from-log]] [--page FILE]

BUILD is a build of the preset `host` in which CTest has run once. Every mutant (mutants.py) is compiled alone, put
before the libraries of a test, and the test is run: its own (test_NAME.c) first, then all others that have the file in
them, the quickest first, float before fixed. A mutant is killed by the first that fails, crashes or does not end. One
that gives the same object code in both numerics is no mutant, nor is one that does not compile.

--sample draws so many mutants of each FILE, a pattern below the root; FILE:N draws N of that one. --log keeps a line
for every mutant; what a log says already is not tried again, but for the mutants that were alive. Those that are alive
and equivalent to the original stand in reviewed.toml with the reason.
Exit status: 0 the goals of report.py are met, 1 they are not, 2 wrong usage.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import shlex
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from mutants import Mutant, mutants
from report import Outcome, page, said

ROOT = Path(__file__).resolve().parents[2]
PER_NUMERIC = {"control": "control", "firmware/app": "firmware", "firmware/services": "services"}
PLAIN = {"firmware/link": "link", "firmware/storage": "storage", "hal/f28379d": "port_f28379d"}
FOLDERS = {  # whose tests may notice, in this order
    "control": ("tests/control", "tests/firmware", "tests/scenario"),
    "firmware/app": ("tests/firmware", "tests/scenario"),
    "firmware/services": ("tests/firmware",),
    "firmware/link": ("tests/firmware",),
    "firmware/storage": ("tests/firmware",),
    "hal/f28379d": ("tests/hal",),
}
NOMINAL = ("firmware/app/protection.c", "firmware/app/state_machine.c", "firmware/app/faults.c", "firmware/storage/*.c")
LONGEST_S = 5.0  # a test that takes longer is run for the file that bears its name alone


@dataclass(frozen=True, slots=True)
class Test:
    """A test program: how it is linked, and how long it takes."""

    name: str
    folder: str
    link: str
    takes_s: float


class Builder:
    """Compiles and links as the build did."""

    def __init__(self, build: Path, root: Path) -> None:
        self.build, self.root = build, root
        self.compiles: dict[str, str] = {}
        self.tests: dict[str, Test] = {}
        cost = build / "Testing/Temporary/CTestCostData.txt"
        rows = [line.split() for line in cost.read_text(encoding="utf-8").splitlines()] if cost.is_file() else []
        times = {row[0]: float(row[2]) for row in rows if len(row) == 3}
        words = ["ninja", "-C", str(build), "-t", "commands"]
        for line in subprocess.run(words, capture_output=True, text=True, check=True).stdout.splitlines():
            if found := re.search(r" -o (\S+/(\w+)\.dir/\S+\.o) -c (\S+)$", line):
                self.compiles[f"{found[2]} {Path(found[3]).resolve()}"] = line
            elif found := re.search(r"^: && (\S*cc .* -o (tests/\S+/(test_\w+)) .*?)(?: && .*)?$", line):
                folder = str(Path(found[2]).parent)
                self.tests[found[3]] = Test(found[3], folder, found[1], times.get(found[3], 0.0))

    def command(self, file: str, numeric: str) -> str:
        target = library_of(file)
        return self.compiles[f"{target}{f'_{numeric}' if numeric else ''} {self.root / file}"]

    def compile(self, file: str, source: Path, numeric: str, out: Path) -> bool:
        """Without line numbers, so that objects can be compared."""
        words = [w for w in shlex.split(self.command(file, numeric)) if not w.startswith(("-W", "-g", "-MD"))]
        for option in ("-MT", "-MF", "-o", "-c"):
            at = words.index(option)
            del words[at : at + 2]
        words += ["-g0", "-w", "-I", str((self.root / file).parent), "-c", str(source), "-o", str(out)]
        return subprocess.run(words, cwd=self.build, capture_output=True, check=False).returncode == 0

    def passes(self, test: Test, part: Path, program: Path) -> bool:
        """The test with this object instead of that of the library."""
        words = shlex.split(test.link)
        at = words.index("-o")
        words = [*words[:at], str(part), "-o", str(program), *words[at + 2 :]]
        subprocess.run(words, cwd=self.build, capture_output=True, check=True)
        return ends_well(program, self.build, round(5.0 + 10.0 * test.takes_s))


def ends_well(program: Path, folder: Path, limit_s: int) -> bool:
    """Within that much processor time: on a busy machine the clock on the wall says nothing."""
    words = [f"ulimit -t {limit_s}; exec {shlex.quote(str(program))}"]
    try:
        done = subprocess.run(words, shell=True, cwd=folder, capture_output=True, timeout=50.0 * limit_s, check=False)
    except subprocess.TimeoutExpired:  # waits for what never comes
        return False
    return done.returncode == 0


def library_of(file: str) -> str:
    for folder, name in (PER_NUMERIC | PLAIN).items():
        if file.startswith(f"{folder}/"):
            return name
    raise SystemExit(f"{file}: not in one of {', '.join(PER_NUMERIC | PLAIN)}")


def numerics_of(file: str) -> tuple[str, ...]:
    return ("",) if library_of(file) in PLAIN.values() else ("float", "fixed")


def symbols(path: Path) -> set[str]:
    """What an object or a program defines for others."""
    done = subprocess.run(["nm", "--defined-only", "-g", str(path)], capture_output=True, text=True, check=True)
    return {line.split()[-1] for line in done.stdout.splitlines() if line.strip()}


@cache
def in_turn(builder: Builder, file: str, numeric: str) -> list[Test]:
    """The tests that have the file in them: its own first, then the quickest; of one numeric, where it has two."""
    own = re.compile(rf"test_{Path(file).stem}(_float|_fixed)?")
    folders = next(found for folder, found in FOLDERS.items() if file.startswith(f"{folder}/"))
    found = re.search(r" -o (\S+)", builder.command(file, numeric))
    defined = symbols(builder.build / str(found and found[1]))

    def rank(test: Test) -> tuple[bool, int, float]:
        near = next(n for n, folder in enumerate(folders) if test.folder.startswith(folder))
        return not own.fullmatch(test.name), near, test.takes_s

    fit = [
        test
        for test in builder.tests.values()
        if test.folder.startswith(folders)
        and test.name.endswith(f"_{numeric}" if numeric else test.name)
        and (test.takes_s <= LONGEST_S or own.fullmatch(test.name))
        and defined & symbols(builder.build / test.folder / test.name)
    ]
    return sorted(fit, key=rank)


def originals(builder: Builder, file: str, source: str, work: Path) -> dict[str, bytes]:
    """Object code of the file as it is; the mutants have its name, since that is part of it."""
    plain = work / Path(file).name
    plain.write_text(source, encoding="utf-8")
    found = {}
    for numeric in numerics_of(file):
        part = work / "original.o"
        if not builder.compile(file, plain, numeric, part):
            raise SystemExit(f"{file}: does not compile as it is")
        found[numeric] = part.read_bytes()
        for test in in_turn(builder, file, numeric)[:1]:
            if not builder.passes(test, part, work / "program"):
                raise SystemExit(f"{file}: {test.name} fails without a change")
    return found


def try_one(builder: Builder, file: str, mutant: Mutant, source: str, work: Path, same: dict[str, bytes]) -> Outcome:
    changed = work / Path(file).name
    changed.write_text(mutant.applied(source), encoding="utf-8")
    differs = False
    for numeric in numerics_of(file):
        part = work / f"mutant_{numeric}.o"
        if not builder.compile(file, changed, numeric, part):
            return Outcome(file, mutant, "refused")
        if part.read_bytes() == same[numeric]:
            continue
        differs = True
        for test in in_turn(builder, file, numeric):
            if not builder.passes(test, part, work / "program"):
                return Outcome(file, mutant, "killed", test.name)
    return Outcome(file, mutant, "alive" if differs else "same")


def chosen(root: Path, patterns: list[str], sample: int, seed: int) -> list[tuple[str, Mutant]]:
    picked = []
    for given in patterns:
        pattern, _, count = given.partition(":")
        files = sorted(str(path.relative_to(root)) for path in root.glob(pattern))
        if not files:
            raise SystemExit(f"{pattern}: there is no such file below {root}")
        every = [(file, m) for file in files for m in mutants((root / file).read_text(encoding="utf-8"))]
        drawn = sorted(
            random.Random(seed).sample(range(len(every)), min(int(count or sample) or len(every), len(every)))
        )
        picked += [every[k] for k in drawn]
    return picked


def known_from(log: Path | None, alive: bool) -> dict[tuple[str, str], tuple[str, str]]:
    """Fates of an earlier run that stand; with `alive` those that may have changed, too."""
    lines = log.read_text(encoding="utf-8").splitlines() if log is not None and log.is_file() else []
    rows = [json.loads(line) for line in lines]
    return {(row["file"], row["key"]): (row["fate"], row["by"]) for row in rows if alive or row["fate"] != "alive"}


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Mutation: which test notices a small change?")
    parser.add_argument("build", type=Path)
    parser.add_argument(
        "files", nargs="*", default=list(NOMINAL), help="patterns below the root; default: those whose goal is all"
    )
    parser.add_argument("--sample", type=int, default=0, help="so many mutants of each pattern; default: every one")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--log", type=Path, help="keeps what was found, and is gone on from")
    parser.add_argument("--from-log", action="store_true", help="try nothing: what the log says")
    parser.add_argument("--page", type=Path, help="write the result as a page")
    parser.add_argument("--root", type=Path, default=ROOT, help="of the sources that the build is of")
    options = parser.parse_args(arguments)
    root, began = options.root.resolve(), time.monotonic()
    builder = Builder(options.build.resolve(), root)
    if not builder.tests:
        print(f"{options.build}: no tests are built there; cmake --build --preset host", file=sys.stderr)
        return 2
    known = known_from(options.log, options.from_log)
    log = options.log.open("a", encoding="utf-8") if options.log else None
    outcomes: list[Outcome] = []
    same: dict[str, dict[str, bytes]] = {}
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        for file, mutant in chosen(root, options.files, options.sample, options.seed):
            earlier = known.get((file, mutant.key))
            if earlier is not None:
                outcomes.append(Outcome(file, mutant, *earlier))
            if earlier is not None or options.from_log:
                continue
            source = (root / file).read_text(encoding="utf-8")
            if file not in same:
                same[file] = originals(builder, file, source, work)
            outcomes.append(try_one(builder, file, mutant, source, work, same[file]))
            if log:
                row = {"file": file, "key": mutant.key, "fate": outcomes[-1].fate, "by": outcomes[-1].by}
                print(json.dumps(row), file=log, flush=True)
    lines, met = said(outcomes)
    print("\n".join(lines))
    print(f"{len(outcomes)} mutants, {time.monotonic() - began:.0f} s; the goals are {'met' if met else 'not met'}")
    if options.page:
        options.page.write_text(page(outcomes, options.files, options.sample, options.seed), encoding="utf-8")
    return 0 if met else 1


if __name__ == "__main__":
    os.nice(5)
    sys.exit(main(sys.argv[1:]))
