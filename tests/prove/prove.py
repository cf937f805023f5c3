"""Prove, for all inputs, that blocks of control/ and the link have no undefined behaviour and keep their bounds.

    prove.py [--page FILE] [--self-test] [NAME...]

Each prove_NAME.c calls a block with values that stand for all values (any.h), and says in `check` what has to hold. The
value analysis of Frama-C (Eva) follows every path: overflow, division by zero, an index or a pointer out of bounds,
what was never written, and the checks. It runs in both numerics, with an int of 32 and of 16 bits (the C28x has 16).
`eva:` in the first comment of a file are its options. Proved: no alarm, no open precondition, and each check of the
file was reached and holds.

--self-test breaks copies of the code on purpose, and wants the proof to fail each time.
Exit status: 0 all proved that should be, 1 something is not, 2 wrong usage or no Frama-C (Debian: frama-c-base).
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
NUMERICS = ("float", "fixed")
INT_BITS = {32: "gcc_x86_64", 16: "x86_16"}
CONTRACTS = {"float": "num_clamp,num_is_finite,num_guard,num_from_float", "fixed": "num_from_float"}
TIMEOUT_S = 900

# What Eva cannot prove, and why: (name, numerics) and the reason. A proof that comes out all the same is an error, too.
OPEN = {
    (
        "angle_from_rad",
        "float",
    ): "a number less the nearest whole one is within 1/2: that relates two values, and Eva keeps ranges",
    ("num_math", "float"): "the root starts from the bits of a float, of which Eva knows nothing",
    ("fal", "float"): "its table is chosen by the bits of a float, of which Eva knows nothing",
    (
        "deadbeat",
        "float",
    ): "the bounds hold; that a prediction beyond the range is replaced is a comparison with NaN",
    ("thermal", "float"): "the bounds hold; that a load that is NaN counts as the largest is a comparison with NaN",
    ("thermal", "fixed"): "the bounds hold; that a load that is NaN counts as the largest is a comparison with NaN",
    ("profile", "float"): "its steps stay below 2^31 by relations between travel, step and limit",
    ("profile", "fixed"): "its steps stay below 2^31 by relations between travel, step and limit",
}

# file, text, what replaces it, the proof that has to notice
BROKEN = (
    (
        "control/motor/pi.c",
        "return num_clamp(s->wanted, self->params.out_min, self->params.out_max);",
        "return s->wanted;",
        "pi",
    ),
    ("control/memory/ring.c", "if (delay >= self->capacity) {", "if (delay > self->capacity) {", "ring"),
    ("control/memory/ring.h", "((self->head + 1U) < self->capacity)", "((self->head + 1U) <= self->capacity)", "ring"),
    ("control/memory/angle_grid.h", "((i + 1U) < self->cells)", "((i + 1U) <= self->cells)", "grid"),
    ("control/memory/angle_grid.c", "(count & 3U)", "(count & 7U)", "grid_write"),
    ("control/motor/svm.c", "duty->b = num_clamp(open.b, (num_t)0, NUM_C(1.0f));", "duty->b = open.b;", "svm"),
    (
        "control/motor/mt_speed.c",
        "return num_clamp(value, num_neg(p->speed_max), p->speed_max);",
        "return value;",
        "mt_speed",
    ),
    ("firmware/link/frame.c", "if (d->count < FRAME_MAX) {", "if (d->count <= FRAME_MAX) {", "frame"),
    ("firmware/link/codec.c", "w->at < w->room", "w->at <= w->room", "frame_send"),
)


@dataclass(frozen=True, slots=True)
class Outcome:
    name: str
    numerics: str
    int_bits: int
    proved: bool
    said: str
    seconds: float


def names() -> list[str]:
    return sorted(path.stem.removeprefix("prove_") for path in HERE.glob("prove_*.c"))


def title(name: str) -> str:
    """The first comment of a harness, without its options."""
    text = (HERE / f"prove_{name}.c").read_text().split("*/")[0].removeprefix("/*")
    return " ".join(re.sub(r"eva: .*", "", text.replace("\n *", "\n")).split())


def analyse(name: str, numerics: str, int_bits: int, root: Path = ROOT) -> Outcome:
    path = root / "tests" / "prove" / f"prove_{name}.c"
    text = path.read_text()
    options = re.search(r"eva: (.*?)\s*(\*/|$)", text, re.MULTILINE)
    defines = " -DEVENSPIN_FIXED" if numerics == "fixed" else ""
    command = [
        "frama-c", "-c11", "-machdep", INT_BITS[int_bits], f"-cpp-extra-args=-I{root}{defines}",
        "-eva", "-main", "prove", "-lib-entry", "-warn-special-float", "none", "-eva-use-spec", CONTRACTS[numerics],
        *(options.group(1).split() if options else ("-eva-precision", "1")),
        "-eva-msg-key=-initial-state,-final-states", str(path),
    ]  # fmt: skip
    start = time.monotonic()
    try:
        done = subprocess.run(
            command, cwd=root, capture_output=True, text=True, check=False, timeout=TIMEOUT_S
        )  # it also includes from where it is
        proved, said = judge(done.stdout + done.stderr, text.count("@ check "))
    except subprocess.TimeoutExpired:
        proved, said = False, f"no end after {TIMEOUT_S} s"
    return Outcome(name, numerics, int_bits, proved, said, time.monotonic() - start)


def judge(output: str, checks: int) -> tuple[bool, str]:
    """Whether everything is proved, and what to say about it."""
    alarms = re.search(r"(\d+) alarms? generated", output)
    if alarms is None or "User Error" in output or "aborted" in output:
        if "Please report as 'crash'" in output:
            return False, "the analysis ends in an error of its own"
        lines = [line for line in output.splitlines() if "rror" in line] or output.splitlines()[-1:] or ["no output"]
        return False, f"frama-c failed: {lines[0].strip()}"
    if "NON TERMINATING FUNCTION" in output:
        return False, "a function never returns, so that what follows was not looked at"
    counted = re.search(r"Assertions\s+(\d+) valid\s+(\d+) unknown\s+(\d+) invalid", output)
    valid, unknown, invalid = (int(number) for number in counted.groups()) if counted else (0, 0, 0)
    preconditions = len(re.findall(r"function \w+: precondition", output))
    left = [
        f"{count} {what}"
        for count, what in (
            (int(alarms.group(1)), "alarms"),
            (unknown + invalid, "checks open"),
            (preconditions, "preconditions open"),
            (checks - valid - unknown - invalid, "checks not reached"),
        )
        if count > 0
    ]
    return not left, ", ".join(left) or (f"proved, checks: {checks}" if checks else "proved")


def run_all(wanted: list[str]) -> list[Outcome]:
    jobs = [(name, numerics, bits) for name in wanted for numerics in NUMERICS for bits in INT_BITS]
    with ThreadPoolExecutor(os.cpu_count() or 2) as pool:
        results = []
        for result in pool.map(lambda job: analyse(*job), jobs):
            reason = OPEN.get((result.name, result.numerics))
            mark = "ok" if result.proved != bool(reason) else "WRONG"
            of = f"{result.name:16} {result.numerics:5} int {result.int_bits:2}"
            print(f"{mark:5} {of}  {result.said} ({result.seconds:.0f} s)", flush=True)
            results.append(result)
    return results


def contracts_hold() -> bool:
    """Hold contracts.h against the code, for every float there is."""
    compiler = shutil.which("gcc") or "cc"
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "contracts_hold"
        good = True
        for numerics in NUMERICS:
            define = ["-DEVENSPIN_FIXED"] if numerics == "fixed" else []
            subprocess.run(
                [compiler, "-O2", f"-I{ROOT}", *define, "-o", program, HERE / "contracts_hold.c"], check=True
            )
            done = subprocess.run([program], capture_output=True, text=True, check=False)
            mark = "ok" if done.returncode == 0 else "WRONG"
            print(f"{mark:5} {'contracts':16} {numerics:5}         {done.stdout.strip()}", flush=True)
            good = good and done.returncode == 0
    return good


def self_test() -> bool:
    good = True
    for file, text, other, name in BROKEN:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            for part in ("control", "firmware", "tests/prove"):
                shutil.copytree(ROOT / part, root / part)
            code = (root / file).read_text()
            if text not in code:
                print(f"WRONG {file}: `{text}` is no longer there; give BROKEN another line")
                good = False
                continue
            (root / file).write_text(code.replace(text, other, 1))
            result = analyse(name, "fixed", 32, root)
            noticed = not result.proved and "failed" not in result.said
            print(f"{'ok' if noticed else 'WRONG':5} broken {file}: {result.said}", flush=True)
            good = good and noticed
    return good


def page(results: list[Outcome]) -> str:
    rows = []
    for name in dict.fromkeys(result.name for result in results):
        for numerics in NUMERICS:
            of = [result for result in results if (result.name, result.numerics) == (name, numerics)]
            reason = OPEN.get((name, numerics))
            said = f"**open**: {of[0].said}; {reason}" if reason else of[0].said
            rows.append(f"| `{name}` | {title(name) if numerics == 'float' else ''} | {numerics} | {said} |")
    proved = sum(result.proved for result in results)
    return f"""<!-- Made by `make prove`. Do not edit. -->

# What is proved

The value analysis of Frama-C (Eva) has followed every path of the blocks below, with values that stand for all values:
no undefined behaviour, no overflow, no index or pointer out of bounds, nothing read that was not written, and what each
file of `tests/prove` checks. Both numerics, with an int of 32 and of 16 bits, as the C28x has it: {proved} of
{len(results)} proofs came out, the others are open.

Eva 25 keeps NaN beside a range whatever it is compared with. So `num_clamp`, `num_is_finite`, `num_guard` and
`num_from_float` are taken by their contracts (`tests/prove/contracts.h`), which are held against the code for all 2^32
floats. An open row is no error that is known; its reason says why the analysis cannot decide it.

| proof | of what | numerics | result |
|---|---|---|---|
{chr(10).join(rows)}

`make prove` also breaks the code in {len(BROKEN)} places, and fails unless a proof notices each.
Not proved: repetitive control, the observers, the store and the state machine. They are tested.
"""


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one of {', '.join(names())}; all when left out")
    parser.add_argument("--page", type=Path, metavar="FILE", help="write the result as a page, of all proofs")
    parser.add_argument("--self-test", action="store_true", help="break the code on purpose, and see the proofs fail")
    args = parser.parse_args()
    unknown = sorted(set(args.names) - set(names()))
    if unknown:
        parser.error(f"no proof {', '.join(unknown)}; there are: {', '.join(names())}")
    if args.page and args.names:
        parser.error("--page holds all proofs: leave the names out")
    if shutil.which("frama-c") is None:
        print(
            "prove: frama-c is not installed (Debian: apt-get install --no-install-recommends frama-c-base)",
            file=sys.stderr,
        )
        return 2
    results = run_all(args.names or names())
    good = all(result.proved != ((result.name, result.numerics) in OPEN) for result in results)
    if not args.names:
        good = contracts_hold() and good
    if args.self_test:
        good = self_test() and good
    if args.page:
        args.page.write_text(page(results))
    print(f"{sum(result.proved for result in results)} of {len(results)} proved")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
