"""Compile with the counter, run the driver, and say how far the model can be trusted."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from evenspin.cycles.costs import ALL, COSTS
from evenspin.cycles.evidence import LARGE_CYC, Band, Listed, block_band, interrupt_band, read_listings
from evenspin.cycles.instrument import instrument
from evenspin.cycles.m4 import count_instructions, missing
from evenspin.cycles.rows import BUDGETS, CURRENT_INTERRUPT, SPEED_INTERRUPT, Row, make_rows, read_budgets, worst_rows
from evenspin.cycles.tools import (
    call,
    code_sources,
    fake_sources,
    include_options,
    link_sources,
    port_options,
    port_sources,
)
from evenspin.cycles.worst import BOUNDS, Limits, Program, parameter_names, read_program
from evenspin.errors import InputError, one_line

# TI's compiler inlines what is declared `inline`, and next to nothing else; so does this.
OPTIONS = (
    "-O2 -std=gnu99 -ffp-contract=off -fno-vectorize -fno-slp-vectorize -fno-unroll-loops -fno-discard-value-names "
    "-finline-hint-functions -fno-builtin -Wno-everything -DEVENSPIN_TMU_MARKED -gline-tables-only"
).split()


@dataclass(frozen=True, slots=True)
class Result:
    rows: list[Row]
    listed: tuple[Listed, ...]
    m4_note: str = ""
    contradictions: tuple[str, ...] = ()  # measured, and more than the worst case: one of the two is wrong

    @property
    def block(self) -> Band:
        return block_band(self.listed)

    @property
    def interrupt(self) -> Band:
        return interrupt_band(self.listed)

    @property
    def band(self) -> tuple[float, float]:
        """Of an interrupt, as errors: the model may be so much too low and too high."""
        return self.interrupt.low - 1.0, self.interrupt.high - 1.0

    def document(self) -> dict[str, object]:
        return {
            "rows": [row.document() for row in self.rows],
            "costs": COSTS,
            "costs_beside": {name: cost for name, cost in ALL.items() if name not in COSTS},
            "validation": [
                {"repository": f.repository, "name": f.name, "core": f.core, "cycles": f.cycles,
                 "model": round(f.model, 1), "error": f.ratio - 1.0}
                for f in self.listed
            ],
            "model_over_real": {
                name: {"p10": band.low, "median": band.middle, "p90": band.high, "functions": band.functions}
                for name, band in (("block", self.block), ("interrupt", self.interrupt))
            },
            "error_band": list(self.band),
            "m4_note": self.m4_note,
        }  # fmt: skip


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


def run_driver(root: Path, clang: str, work: Path) -> tuple[dict[str, tuple[int, int]], dict[str, str]]:
    """Mean and largest cost of everything that the driver measures, in tenths of a cycle; LLVM's texts by file."""
    include = include_options(root)
    sources = [*code_sources(root), *link_sources(root)]
    port = [*include, *port_options(root)]
    texts: dict[str, str] = {}

    def counted(source: Path, options: list[str] = include) -> Path:
        text = work / f"{source.parent.name}_{source.stem}.ll"
        call(clang, *OPTIONS, *options, "-S", "-emit-llvm", source, "-o", text)
        texts[text.stem] = text.read_text()
        text.write_text(instrument(texts[text.stem]))
        done = text.with_suffix(".o")
        call(clang, "-O1", "-Wno-everything", "-c", text, "-o", done)
        return done

    with ThreadPoolExecutor(os.cpu_count() or 2) as pool:
        objects = [*pool.map(counted, sources), *pool.map(lambda source: counted(source, port), port_sources(root))]
    program = work / "driver"
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
    return rows, texts


def measure(root: Path, with_m4: bool = True) -> Result:
    """Everything; without the tools for the Cortex-M4F, or when they fail, the note says why its column is empty."""
    budgets, *_ = read_budgets(root / BUDGETS)
    clang = find_clang()
    listed = read_listings(root)
    block, interrupt = block_band(listed).low, interrupt_band(listed).low

    def low(cycles: int) -> float:
        return interrupt if cycles >= LARGE_CYC else block

    with tempfile.TemporaryDirectory() as folder:
        measured, texts = run_driver(root, clang, Path(folder))
        m4, note = m4_counts(root, Path(folder)) if with_m4 else (None, "")
    worst, found = worst_cases(root, texts, measured, budgets, low)
    return Result([*make_rows(measured, budgets, m4, low), *worst], listed, note, tuple(found))


def worst_cases(
    root: Path,
    texts: Mapping[str, str],
    measured: Mapping[str, tuple[int, int]],
    budgets: Mapping[str, int],
    low: Callable[[int], float],
) -> tuple[list[Row], list[str]]:
    """Rows of the worst case, and what contradicts them."""
    program = read_program(texts, Limits.read(root / BOUNDS, parameter_names()))
    return worst_rows(program, budgets, low), contradictions(measured, program)


def contradictions(measured: Mapping[str, tuple[int, int]], program: Program) -> list[str]:
    """What was measured of a function of the interrupts and is more than its worst case over all inputs."""
    found = []
    judged = program.reached(*CURRENT_INTERRUPT, *SPEED_INTERRUPT)
    for name, (_, most) in measured.items():
        function = next((f for f in functions_of(name) if f in judged), None)
        if function is None:
            continue
        for setup in program.limits.setups_of(name):
            worst = program.worst(function, setup=setup).tenths
            if most > worst:
                found.append(f"{name}: {most / 10:.0f} cycles measured, worst case {worst / 10:.0f} ({setup.name})")
    return found


def functions_of(row: str) -> tuple[str, ...]:
    """What the function of a row can be called: `current_isr pi` is one of drive_current_isr, `hal_x` one of chip_x."""
    first = row.split()[0].rstrip(",")
    return (first, f"drive_{first}", f"drive_{first}_isr", first.replace("hal_", "chip_", 1))


def m4_counts(root: Path, work: Path) -> tuple[dict[str, int] | None, str]:
    """Instructions by name, and what to say about them."""
    reason = missing()
    if not reason:
        try:
            return count_instructions(root, work), "Cortex-M4F: instructions in the worst call, counted; HAL left out."
        except (InputError, RuntimeError, OSError, subprocess.TimeoutExpired) as error:
            reason = one_line(str(error))
    return None, f"Cortex-M4F instructions left out: {reason}"
