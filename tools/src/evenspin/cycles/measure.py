"""Compile with the counter, run the driver, and make rows of what it says."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import tomllib
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

from evenspin.cycles.costs import CALL, ISR_FRAME
from evenspin.cycles.instrument import instrument
from evenspin.cycles.m4 import count_instructions, missing
from evenspin.cycles.tools import (
    call,
    code_sources,
    fake_sources,
    include_options,
    link_sources,
    port_options,
    port_sources,
)
from evenspin.errors import InputError, one_line
from evenspin.native import tables

CPU_CYCLES_PER_PERIOD = 20000  # 200 MHz / 10 kHz
SPEED_DIVIDER = 10
PLAIN_CONTROLLER = "pi"  # current control that the names of variants do not mention
GROWTH = 1.03
BUDGETS = Path("tests/budget/budgets.toml")
OPTIONS = (
    "-std=gnu99 -ffp-contract=off -fno-vectorize -fno-slp-vectorize -fno-unroll-loops -fno-discard-value-names "
    "-fno-builtin -Wno-everything -DEVENSPIN_TMU_MARKED"
).split()

# TI's cycles, call included: assembly that somebody scheduled by hand, and C without optimisation.
PUBLISHED_ASSEMBLY = {
    "DCL_runPI_C2": 52,
    "DCL_runPID_C2": 83,
    "DCL_runDF11_C2": 37,
    "DCL_runDF22_C4": 44,
    "DCL_runClamp_C2": 28,
    "mpy_SP_CSxCS": 17,
}
PUBLISHED_C = {
    "DCL_runPI_C2": 117,
    "DCL_runPID_C2": 197,
    "DCL_runDF11_C2": 60,
    "DCL_runDF22_C4": 71,
    "DCL_runClamp_C2": 71,
}


@dataclass(frozen=True, slots=True)
class Row:
    """One thing that costs cycles."""

    name: str
    kind: str  # step, isr, extra
    cycles_est: int  # mean over the inputs
    cycles_worst: int
    m4_instructions: int | None  # in the worst call, without the HAL
    budget: int | None
    source: str


@dataclass(frozen=True, slots=True)
class Check:
    """The model against one published figure."""

    name: str
    published: int
    model: int
    form: str

    @property
    def error(self) -> float:
        return self.model / self.published - 1.0


@dataclass(frozen=True, slots=True)
class Result:
    rows: list[Row]
    checks: list[Check]
    m4_note: str = ""

    @property
    def band(self) -> tuple[float, float]:
        errors = [check.error for check in self.checks]
        return min(errors), max(errors)

    def document(self) -> dict[str, object]:
        return {
            "rows": [asdict(row) for row in self.rows],
            "validation": [{**asdict(check), "error": check.error} for check in self.checks],
            "error_band": list(self.band),
            "m4_note": self.m4_note,
        }


def source_root() -> Path:
    """The checkout: the firmware's sources are not part of the installed package."""
    for folder in (Path.cwd(), *Path.cwd().parents, *Path(__file__).resolve().parents):
        if (folder / "tests/target/cycles/driver.c").is_file() and (folder / "control").is_dir():
            return folder
    raise InputError("cycles", "sources", str(Path.cwd()), "a checkout of evenspin", "run it inside the checkout")


def find_clang() -> str:
    """clang with opaque pointers in its text."""
    for name in ("clang-16", "clang-19", "clang-18", "clang-17", "clang-15"):
        if shutil.which(name):
            return name
    raise InputError("cycles", "clang", "none", "clang-15 or newer", "sudo apt-get install -y clang-16")


def run_driver(root: Path, clang: str, work: Path, level: str) -> dict[str, tuple[int, int]]:
    """Mean and largest cost of everything that the driver measures, in tenths of a cycle."""
    include = include_options(root)
    sources = [*code_sources(root), *link_sources(root), root / "tests/target/cycles/reference.c"]
    port = [*include, *port_options(root)]

    def counted(source: Path, options: list[str] = include) -> Path:
        text = work / f"{source.parent.name}_{source.stem}{level}.ll"
        call(clang, level, *OPTIONS, *options, "-S", "-emit-llvm", source, "-o", text)
        text.write_text(instrument(text.read_text()))
        done = text.with_suffix(".o")
        call(clang, "-O1", "-Wno-everything", "-c", text, "-o", done)
        return done

    with ThreadPoolExecutor(os.cpu_count() or 2) as pool:
        objects = [*pool.map(counted, sources), *pool.map(lambda source: counted(source, port), port_sources(root))]
    program = work / f"driver{level}"
    drivers = [root / "tests/target/cycles" / name for name in ("driver.c", "services.c", "port.c")]
    quiet: list[str | Path] = ["-O1", "-ffp-contract=off", "-Wno-everything", *include]
    quiet += ["-I", root / "tests/hal/fake_driverlib"]
    call(clang, *quiet, *drivers, *fake_sources(root), *objects, "-lm", "-o", program)
    rows: dict[str, tuple[int, int]] = {}
    for line in call(program).splitlines():
        if line.startswith("refused"):
            raise InputError("cycles", "driver", line, "inputs that the blocks accept", "correct tests/target/cycles")
        name, _, mean, worst = line.split("\t")
        rows[name] = (int(mean), int(worst))
    return rows


def whole(tenths: int) -> int:
    return (tenths + 5) // 10


def validate(optimised: dict[str, tuple[int, int]], plain: dict[str, tuple[int, int]]) -> list[Check]:
    """Hand-scheduled assembly against optimised code, C without optimisation against that."""
    checks = []
    for form, published, rows in (("assembly", PUBLISHED_ASSEMBLY, optimised), ("C, -O0", PUBLISHED_C, plain)):
        for name, cycles in published.items():
            checks.append(Check(name, cycles, whole(rows[name][1] + CALL), form))
    return checks


def base_of(variant: str) -> str:
    """What a variant costs more than: the drive without ripple suppression, under the same current controller."""
    if variant.startswith("position "):
        return "position ppi"
    other = [word for word in tables().params["current_controller"].choices if variant.endswith(f" {word}")]
    return f"pi {other[0]}" if other else "pi"


def make_rows(
    measured: Mapping[str, tuple[int, int]], budgets: Mapping[str, int], m4: Mapping[str, int] | None = None
) -> list[Row]:
    """Steps, interrupts, and what a method costs more than PI; `m4`: instructions of the Cortex-M4F by name."""
    source = "model"
    rows: list[Row] = []

    def add(name: str, kind: str, est: int, worst: int, instructions: int | None) -> None:
        rows.append(Row(name, kind, est, worst, instructions, budgets.get(f"{kind} {name}"), source))

    def counted(*names: str) -> list[int] | None:
        return [m4[name] for name in names] if m4 is not None and all(name in m4 for name in names) else None

    isr: dict[str, tuple[int, int]] = {}
    for name, (mean, worst) in measured.items():
        if name in PUBLISHED_ASSEMBLY:
            continue
        if "_isr " in name:
            isr[name] = (whole(mean + ISR_FRAME), whole(worst + ISR_FRAME))
            add(name, "isr", *isr[name], (m4 or {}).get(name))
        else:
            add(name, "step", whole(mean + CALL), whole(worst + CALL), (m4 or {}).get(name))

    methods = [name.removeprefix("current_isr ") for name in isr if name.startswith("current_isr ")]
    for method in methods:
        current, speed = isr[f"current_isr {method}"], isr[f"speed_isr {method}"]
        both = [current[i] + -(-speed[i] // SPEED_DIVIDER) for i in (0, 1)]
        each = counted(f"current_isr {method}", f"speed_isr {method}")
        add(f"both {method}", "isr", both[0], both[1], each[0] - (-each[1] // SPEED_DIVIDER) if each else None)
    for method in methods:
        base = base_of(method)
        if method in (base, "align"):  # the latter is no method, but a part of a start
            continue
        extra = [
            sum(isr[f"{which}_isr {method}"][i] - isr[f"{which}_isr {base}"][i] for which in ("current", "speed"))
            for i in (0, 1)
        ]
        each = counted(*(f"{which}_isr {name}" for name in (method, base) for which in ("current", "speed")))
        add(method, "extra", extra[0], extra[1], each[0] + each[1] - each[2] - each[3] if each else None)
    return rows


def read_budgets(path: Path) -> tuple[dict[str, int], dict[str, int], list[str]]:
    """Budgets and recorded figures by `<kind> <name>`, and the names that are known to be over."""
    with path.open("rb") as file:
        document = tomllib.load(file)
    return document["budget"], document["recorded"], document["open"]


def measure(root: Path, with_m4: bool = True) -> Result:
    """Everything; without the tools for the Cortex-M4F, or when they fail, the note says why its column is empty."""
    budgets, *_ = read_budgets(root / BUDGETS)
    clang = find_clang()
    with tempfile.TemporaryDirectory() as folder:
        optimised = run_driver(root, clang, Path(folder), "-O2")
        plain = run_driver(root, clang, Path(folder), "-O0")
        m4, note = m4_counts(root, Path(folder)) if with_m4 else (None, "")
    return Result(make_rows(optimised, budgets, m4), validate(optimised, plain), note)


def m4_counts(root: Path, work: Path) -> tuple[dict[str, int] | None, str]:
    """Instructions by name, and what to say about them."""
    reason = missing()
    if not reason:
        try:
            return count_instructions(root, work), "Cortex-M4F: instructions in the worst call, counted; HAL left out."
        except (InputError, RuntimeError, OSError, subprocess.TimeoutExpired) as error:
            reason = one_line(str(error))
    return None, f"Cortex-M4F instructions left out: {reason}"


def violations(
    rows: Sequence[Row], budgets: dict[str, int], recorded: dict[str, int], open_: Sequence[str] = ()
) -> list[str]:
    """What is over its budget, grew, or is not measured any more: name and both numbers.

    What `open_` names is known to be over its budget: it may not grow, and must leave the list when it gets below.
    """
    worst = {f"{row.kind} {row.name}": row.cycles_worst for row in rows}
    found = []
    for name, limit in budgets.items():
        if name not in worst:
            found.append(f"{name}: has a budget of {limit} cycles and is not measured")
        elif name in open_:
            if worst[name] <= limit:
                found.append(f"{name}: {worst[name]} cycles, budget {limit}: met, so take it out of `open`")
            elif name not in recorded:
                found.append(f"{name}: {worst[name]} cycles, budget {limit}: open, and not recorded")
        elif worst[name] > limit:
            found.append(f"{name}: {worst[name]} cycles, budget {limit}")
    for name, before in recorded.items():
        if name in worst and worst[name] > max(before * GROWTH, before + 1):
            found.append(f"{name}: {worst[name]} cycles, recorded {before}: grew by more than 3 %")
    return found


def write_recorded(path: Path, rows: Sequence[Row]) -> None:
    """Replace the recorded figures; budgets and comments stay."""
    kept = path.read_text().split("\n[recorded]\n")[0]
    lines = (f'"{row.kind} {row.name}" = {row.cycles_worst}\n' for row in rows)
    path.write_text(f"{kept}\n[recorded]\n{''.join(lines)}")
