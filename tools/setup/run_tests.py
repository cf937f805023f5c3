"""Run the checks of the project, or those named on the command line, and add up what they found.

    run_tests.py [host] [asan] [fixed] [arm] [coverage] [lint] [python] [avr] [m4] [cppcheck]
                 [cycles] [prove] [tidy]

The last line is `N passed, N failed`: the tests of ctest and pytest together. A step that has no tests of its own, or
does not get as far as running them, adds nothing when it is good and one failure when it is not. Above it stands what
each step took: seconds, and seconds of processor time, which other work on the machine changes less.
Two steps run side by side, so that no core is idle while one of them has work for a single one; what a step has to say
comes in one piece at its end. Each step writes to build/checks/<step>.log; what a failed command said last is shown.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "build" / "checks"
JOBS = str(os.cpu_count() or 2)
TAIL_LINES = 100
CONFIGURING = Lock()  # all presets fetch what is not installed into one folder


@dataclass(frozen=True, slots=True)
class Count:
    """Tests of one step."""

    passed: int = 0
    failed: int = 0
    skipped: int = 0

    def __add__(self, other: Count) -> Count:
        return Count(self.passed + other.passed, self.failed + other.failed, self.skipped + other.skipped)

    def __str__(self) -> str:
        text = f"{self.passed} passed, {self.failed} failed"
        return f"{text}, {self.skipped} skipped" if self.skipped else text


class StepFailed(Exception):
    """A command that had to succeed did not."""


def show(text: str) -> None:
    """In one piece, also beside another step."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


Say = Callable[[str], None]  # what a step has to say, line by line or in pieces


class Step:
    """The commands of one step, and their log.

    `say`: where to say what is worth reading; `jobs`: processes at a time; `processor_s`: of each command so far, with
    the processes that it waited for.
    """

    def __init__(self, name: str, say: Say = show, jobs: str = JOBS) -> None:
        self.name = name
        self.say = say
        self.jobs = jobs
        self.log = RESULTS / f"{name}.log"
        self.junit = RESULTS / f"{name}.xml"
        self.log.write_text("")
        self.junit.unlink(missing_ok=True)
        self.processor_s: list[float] = []

    def call(self, *command: str | Path) -> tuple[int, str]:
        """Run a command and log it: its exit status and its output."""
        words = [str(word) for word in command]
        with subprocess.Popen(
            words, cwd=ROOT, text=True, errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        ) as process:
            assert process.stdout is not None
            said = process.stdout.read()
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        self.processor_s.append(usage.ru_utime + usage.ru_stime)
        with self.log.open("a") as log:
            log.write(f"$ {' '.join(words)}\n{said}\n")
        return process.returncode, said.rstrip()

    def need(self, *command: str | Path) -> str:
        """Run a command without which the step makes no sense, and return its output."""
        status, output = self.call(*command)
        if status != 0:
            self.say(end_of(output))
            raise StepFailed(f"see {self.log.relative_to(ROOT)}")
        return output

    def build(self) -> None:
        with CONFIGURING:
            self.need("cmake", "--preset", self.name)
        self.need("cmake", "--build", "--preset", self.name, "--parallel", self.jobs)

    def ctest(self) -> Count:
        return self.counted("ctest", "--preset", self.name, "--parallel", self.jobs, "--output-junit", self.junit)

    def pytest(self) -> Count:
        # a file at a time: its fixtures are made once; in the order of tools/tests/conftest.py: the long ones first
        shared = ("-n", JOBS, "--dist", "loadfile", "--no-loadscope-reorder", "--max-worker-restart=0")
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # on busy cores threads that wait for work cost an eighth
        return self.counted(sys.executable, "-m", "pytest", "-q", *shared, f"--junitxml={self.junit}")

    def counted(self, *command: str | Path) -> Count:
        """Run tests and count what the JUnit file says; a bad exit status that no test explains is a failure, too."""
        status, output = self.call(*command)
        count = read_junit(self.junit, self.say) if self.junit.exists() else Count()
        if status != 0 and count.failed == 0:
            self.say(end_of(output))
            raise StepFailed(f"the tests ended with status {status}, see {self.log.relative_to(ROOT)}")
        if count.passed + count.failed == 0:
            raise StepFailed("no tests were found")
        return count


def end_of(output: str) -> str:
    """The last lines of an output; of a build, from the first command that failed."""
    lines = output.splitlines()
    first = next((number for number, line in enumerate(lines) if line.startswith("FAILED: ")), None)
    if "CMake Error" in output:  # a failed configuration may hold a build of its own; its cause stands above
        first = None
    return "\n".join(lines[-TAIL_LINES:] if first is None else lines[first : first + TAIL_LINES])


def read_junit(path: Path, say: Say = show) -> Count:
    """Count the test cases of a JUnit file as ctest and pytest write it, and show those that failed."""
    count = Count()
    for case in ET.parse(path).getroot().iter("testcase"):
        if case.find("failure") is not None or case.find("error") is not None:
            count += Count(failed=1)
            said = (case.findtext(part) or "" for part in ("failure", "error", "system-out"))
            say(f"[test] FAILED {case.get('name')}\n{end_of(''.join(said))}")
        elif case.find("skipped") is not None or case.get("status") in ("notrun", "disabled"):
            count += Count(skipped=1)
        else:
            count += Count(passed=1)
    return count


def c_tests(step: Step) -> Count:
    """Build a preset and run its tests."""
    step.build()
    return step.ctest()


def arm(step: Step) -> Count:
    """Compile for the Cortex-M4F."""
    if shutil.which("arm-none-eabi-gcc") is None:
        raise StepFailed("arm-none-eabi-gcc is not installed; `make setup` says how")
    step.build()
    return Count()


def missing(step: Step, *tools: str) -> bool:
    """Whether a tool is not there: said in one line, and in CI a failure."""
    absent = [tool for tool in tools if shutil.which(tool) is None]
    if absent and os.environ.get("CI") == "true":
        raise StepFailed(f"{', '.join(absent)} not installed; `make setup` says how")
    if absent:
        step.say(f"[test] left out: {', '.join(absent)} not installed; `make setup` says how")
    return bool(absent)


def on_target(step: Step, toolchain: str, *tools: str) -> Count:
    """control/ and firmware/ by another compiler, and the block tests on its machine."""
    if missing(step, *tools):
        return Count()
    build = ROOT / "build" / f"target-{step.name}"
    cmock = Path("/usr/share/cmock")
    if not cmock.is_dir():
        cmock = next((ROOT / "build").glob("fetched/cmock_upstream-src"), cmock)
    with CONFIGURING:
        step.need(
            "cmake", "-S", "tests/target", "-B", build, "-G", "Ninja", "--toolchain", ROOT / "cmake" / toolchain,
            f"-DCMOCK_DIR={cmock}",
        )  # fmt: skip
    step.need("cmake", "--build", build, "--parallel", step.jobs)
    return step.counted("ctest", "--test-dir", build, "--parallel", step.jobs, "--output-on-failure",
                        "--output-junit", step.junit)  # fmt: skip


def avr(step: Step) -> Count:
    """int of 16 bits: AVR under simavr."""
    return on_target(step, "avr.cmake", "avr-gcc", "simavr")


def m4(step: Step) -> Count:
    """Cortex-M4F: control/ and firmware/ compiled, and the block tests under QEMU; without QEMU compiled alone."""
    if shutil.which("qemu-system-arm") is None:
        compiled = Step("arm", step.say, step.jobs)
        arm(compiled)
        step.processor_s += compiled.processor_s
    return on_target(step, "arm-none-eabi.cmake", "arm-none-eabi-gcc", "qemu-system-arm")


def cppcheck(step: Step) -> Count:
    """Static analysis with the sizes of the C28x."""
    if not missing(step, "cppcheck"):
        step.need(sys.executable, ROOT / "tests/target/cppcheck/check.py", ROOT)
    return Count()


def cycles(step: Step) -> Count:
    """Cycles of the C28x against their budgets; a test of the step python counts the instructions of the Cortex-M4F."""
    if not any(shutil.which(f"clang-{version}") for version in range(15, 20)) and missing(step, "clang-16"):
        return Count()
    step.need(ROOT / ".venv/bin/evenspin", "cycles", "--check", "--no-m4")
    return Count()


PROOFS = ("num", "pi", "svm", "ring", "grid_walk", "frame")  # those that take seconds; `make prove` has all


def prove(step: Step) -> Count:
    """Some blocks proved for all inputs, where Frama-C is installed: it is large, and setup does not install it."""
    if shutil.which("frama-c") is None:
        step.say("[test] left out: frama-c not installed; `make prove` says how")
        return Count()
    step.need(sys.executable, ROOT / "tests/prove/prove.py", *PROOFS)
    return Count()


def coverage(step: Step) -> Count:
    """Coverage of control/ by its own tests. The host step counts the same tests, so they are not counted again."""
    step.build()
    build = ROOT / "build" / step.name
    for counters in build.rglob("*.gcda"):
        counters.unlink()
    if step.ctest().failed:
        raise StepFailed("tests fail in the coverage build")
    step.say(step.need(sys.executable, ROOT / "tools/setup/coverage_gate.py", build))
    return Count()


def lint(step: Step) -> Count:
    """Format and lint of C and Python, types of Python, the layers of both, and private words."""
    step.need(sys.executable, "-m", "ruff", "check", ".")
    step.need(sys.executable, "-m", "ruff", "format", "--check", ".")
    step.need(sys.executable, "-m", "mypy")
    step.need(Path(sys.executable).with_name("clang-format"), "--dry-run", "-Werror", *c_files())
    for check in ("check_layers.py", "check_python_layers.py", "check_words.py"):
        step.need(sys.executable, ROOT / "tests/architecture" / check, ROOT)
    return tidy(step, (*TIDY_OPTIONS, *TIDY_STATES))


TIDY_OPTIONS = ("-std=gnu11", "-I.", "-Ihal/include", "-Itests/hal/fake_driverlib", '-DEVENSPIN_VERSION="0"')
# Of the 225000 states of a function that the analyzer goes through by default: most functions have fewer, and the few
# that have more took three quarters of its time. The step tidy goes through all.
TIDY_STATES = ("-Xclang", "-analyzer-config", "-Xclang", "max-nodes=40000")


def tidy(step: Step, options: Sequence[str] = TIDY_OPTIONS) -> Count:
    """clang-tidy by .clang-tidy; needs no build."""
    files = [file for file in c_files() if file.endswith(".c") and not file.startswith("tests/")]
    program = Path(sys.executable).with_name("clang-tidy")
    cores = int(step.jobs)
    with ThreadPoolExecutor(cores) as pool:
        parts = [files[first::cores] for first in range(min(cores, len(files)))]
        runs = [pool.submit(step.need, program, "--quiet", *part, "--", *options) for part in parts]
    for run in runs:
        run.result()
    return Count()


def c_files() -> list[str]:
    """What clang-format has to leave as it is. Lists of macros (.def) have a layout of their own."""
    folders = ("control", "firmware", "hal", "sim_host", "tests")
    found = (file for folder in folders for file in (ROOT / folder).rglob("*.[ch]") if file.parent.name != "golden")
    return sorted(str(file.relative_to(ROOT)) for file in found)


def python(step: Step) -> Count:
    """Run the tests of the Python package."""
    return step.pytest()


# Longest first: the last one has nothing beside it.
STEPS: dict[str, Callable[[Step], Count]] = {
    "python": python,
    "host": c_tests,
    "asan": c_tests,
    "coverage": coverage,
    "m4": m4,
    "avr": avr,
    "lint": lint,
    "cppcheck": cppcheck,
    "cycles": cycles,
    "prove": prove,
    "arm": arm,
    "fixed": c_tests,
    "tidy": tidy,
}
# The host preset runs every test in fixed point as well, m4 compiles what arm does with the same compiler, and most of
# tidy is in lint.
DEFAULT = [name for name in STEPS if name not in ("fixed", "arm", "tidy")]
AT_ONCE = 2  # steps


def main(arguments: Sequence[str]) -> int:
    unknown = sorted(set(arguments) - set(STEPS))
    if unknown:
        print(f"run_tests.py: no step {', '.join(unknown)}; there are: {', '.join(STEPS)}", file=sys.stderr)
        return 2

    RESULTS.mkdir(parents=True, exist_ok=True)
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # each of the many processes would compile the whole package
    names = [name for name in STEPS if name in (arguments or DEFAULT)]
    return run_parts([step_of(name) for name in names], AT_ONCE)


Part = tuple[str, Step, Callable[[Step], Count]]


def step_of(name: str) -> Part:
    """Each step may have all cores: either may be what is left at the end."""
    return name, Step(name), STEPS[name]


@dataclass(frozen=True, slots=True)
class Took:
    """What a part counted, and what it took."""

    name: str
    count: Count
    seconds: float
    processor_s: float


def run_parts(parts: Sequence[Part], at_once: int = 1) -> int:
    """Run named parts, so many side by side, and add up what they count: the exit status."""
    start = time.monotonic()
    with ThreadPoolExecutor(at_once) as pool:
        all_took = list(pool.map(lambda part: run_part(*part), parts))
    total = sum((took.count for took in all_took), Count())

    show(f"[test] {'':<10}{'s':>6}{'processor s':>13}")
    whole = Took("all", total, time.monotonic() - start, sum(took.processor_s for took in all_took))
    for took in (*all_took, whole):
        show(f"[test] {took.name:<10}{took.seconds:>6.0f}{took.processor_s:>13.0f}")
    if total.skipped:
        show(f"[test] {total.skipped} skipped")
    show(f"{total.passed} passed, {total.failed} failed")
    return 1 if total.failed else 0


def run_part(name: str, step: Step, part: Callable[[Step], Count]) -> Took:
    """What a part counts and takes; what it has to say is shown at its end."""
    show(f"[test] {name} ...")
    said: list[str] = []
    step.say = said.append
    start = time.monotonic()
    try:
        count = part(step)
        outcome = str(count) if count != Count() else "good"
    except StepFailed as failure:
        count = Count(failed=1)
        outcome = f"FAILED: {failure}"
    took = Took(name, count, time.monotonic() - start, sum(step.processor_s))
    show("\n".join([*said, f"[test] {name}: {outcome} ({took.seconds:.0f} s)"]))
    return took


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
