"""Instructions of the Cortex-M4F, counted exactly: the driver's program under QEMU, with a plugin that counts."""

from __future__ import annotations

import os
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from evenspin.cycles.tools import call, code_sources, include_options

COMPILER = "arm-none-eabi-gcc"
QEMU = "qemu-system-arm"
NEEDED = {COMPILER: "gcc-arm-none-eabi", QEMU: "qemu-system-arm", "gcc": "gcc"}
MACHINE = "-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard".split()
OPTIONS = [*MACHINE, *"-O2 -std=gnu99 -ffp-contract=off -w".split()]
TIME_LIMIT_S = 120.0
DRIVER_SECTION = "driver_text"  # a C name: the linker then says where it starts and stops
INTERFACES = (1, 2)  # of QEMU's plugins: until 8.2, since 9.0


def missing() -> str:
    """Why instructions cannot be counted here, and what to do; empty when they can."""
    absent = [tool for tool in NEEDED if shutil.which(tool) is None]
    if not absent:
        return ""
    packages = " ".join(NEEDED[tool] for tool in absent)
    return f"{', '.join(absent)} not installed: sudo apt-get install -y {packages}"


def count_instructions(root: Path, work: Path) -> dict[str, int]:
    """Instructions in the worst call of everything that the driver measures."""
    program = build(root, work)
    places = symbols(program)
    low, high = places[f"__start_{DRIVER_SECTION}"], places[f"__stop_{DRIVER_SECTION}"]
    answer = ""
    for interface in INTERFACES:
        plugin, out = work / f"count{interface}.so", work / f"rows{interface}"
        source = root / "tests/target/cycles/count_plugin.c"
        call("gcc", "-O2", "-shared", "-fPIC", f"-DPLUGIN_INTERFACE={interface}", source, "-o", plugin)
        arguments = f"{plugin},low={low:#x},high={high:#x},mark={places['mark']:#x},out={out}"
        done = subprocess.run(
            [QEMU, *"-M mps2-an386 -nographic -monitor none -serial none".split(),
             *"-semihosting-config enable=on,target=native -plugin".split(), arguments, "-kernel", str(program)],
            capture_output=True, text=True, check=False, timeout=TIME_LIMIT_S, stdin=subprocess.DEVNULL,
        )  # fmt: skip
        if done.returncode == 0 and out.is_file():
            return worst(done.stdout, out.read_text())
        answer = (done.stderr or done.stdout).strip().splitlines()[0] if done.stderr or done.stdout else "no output"
    raise RuntimeError(f"{QEMU} does not take the plugin ({answer})")


def build(root: Path, work: Path) -> Path:
    """The driver's program for the Cortex-M4F; its own code in a section of its own."""
    include = include_options(root)

    def compiled(source: Path) -> Path:
        done = work / f"{source.stem}.m4.o"
        call(COMPILER, *OPTIONS, *include, "-c", source, "-o", done)
        return done

    more = (root / "firmware/link/crc.c", root / "tests/target/m4/target.c")
    with ThreadPoolExecutor(os.cpu_count() or 2) as pool:
        objects = list(pool.map(compiled, [*code_sources(root), *more]))
    driver = work / "driver.m4.o"
    # main among the other functions, not in a section of its own
    sectioned = ("-fno-reorder-functions", "-DCOUNT_INSTRUCTIONS")
    call(COMPILER, *OPTIONS, *sectioned, *include, "-c", root / "tests/target/cycles/driver.c", "-o", driver)
    call("arm-none-eabi-objcopy", "--rename-section", f".text={DRIVER_SECTION}", driver)
    program = work / "driver.elf"
    wanted = [f"-Wl,-u,__{edge}_{DRIVER_SECTION}" for edge in ("start", "stop")]
    call(
        COMPILER, *MACHINE, "--specs=rdimon.specs", "-nostartfiles", "-T", root / "tests/target/m4/m4.ld", *wanted,
        driver, *objects, "-Wl,--start-group", "-lc", "-lrdimon", "-lm", "-lgcc", "-Wl,--end-group", "-o", program,
    )  # fmt: skip
    return program


def symbols(program: Path) -> dict[str, int]:
    lines = (line.split() for line in call("arm-none-eabi-nm", program).splitlines())
    return {words[2]: int(words[0], 16) for words in lines if len(words) == 3}


def worst(names: str, counts: str) -> dict[str, int]:
    """Rows by name from what the driver printed (number, name) and the plugin wrote (number, calls, sum, largest)."""
    name_of = dict(line.split("\t", 1) for line in names.splitlines() if "\t" in line)
    return {name_of[words[0]]: int(words[3]) for words in (line.split("\t") for line in counts.splitlines())}
