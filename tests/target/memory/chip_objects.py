"""Compile the program of the chip for the Cortex-M4F, with types as wide as those of the C28x, to count its words.

What is alike on both machines: pointers and long have 32 bits, float and the fixed-width integers too, and 32-bit
values are aligned to 32 bits. What is widened here: _Bool to 16 bits as on the C28x, enumerations to 32 bits
(EABI of the C28x: 16, so this counts too much). An int has 32 bits here and 16 there; the firmware keeps its
numbers in types of fixed width.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

COMPILER = "arm-none-eabi-gcc"
FLAGS = (
    "-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard -O2 -std=gnu99 -ffp-contract=off -fno-short-enums "
    "-D_Bool=short -ffunction-sections -fdata-sections -fcallgraph-info=su -w -I. -Ihal/include "
    "-Itests/hal/fake_driverlib -DEVENSPIN_FLASH_API"
).split()
# The driver library is a set of declarations here; most of its functions are inline on the chip.
FOLDERS = ("control/*", "firmware/app", "firmware/link", "firmware/services", "firmware/storage", "hal/f28379d")
MAIN = "firmware/main_f28379d.c"
WORD = 2  # octets of the ARM in a word of the C28x


def sources(root: Path) -> list[Path]:
    found = [path for folder in FOLDERS for path in root.glob(f"{folder}/*.c")]
    return sorted(path.relative_to(root) for path in [*found, root / MAIN])


def object_of(source: Path, work: Path) -> Path:
    return work / f"{str(source).replace('/', '.')}.o"


def compile_all(root: Path, work: Path, options: Sequence[str]) -> list[Path]:
    """Objects, with a call graph (.ci) beside each."""

    def one(source: Path) -> Path:
        out = object_of(source, work)
        words = [COMPILER, *FLAGS, *options, "-c", str(source), "-o", str(out)]
        done = subprocess.run(words, cwd=root, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{source}: {done.stderr.strip()[-500:]}")
        return out

    work.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(one, sources(root)))


def ram_code(root: Path) -> tuple[set[str], set[str]]:
    """Files whose code runs from RAM, and functions of other files that do."""
    build = (root / "firmware/CMakeLists.txt").read_text(encoding="utf-8")
    listed = re.search(r"set_source_files_properties\(([^)]*?)PROPERTIES COMPILE_OPTIONS --ramfunc=on", build)
    if listed is None:
        raise RuntimeError("firmware/CMakeLists.txt: no list of files with --ramfunc=on")
    files = {f"firmware/{name}" for name in listed[1].split()}
    if "target_compile_options(control_${numeric} PRIVATE --ramfunc=on)" in build:
        files |= {str(source) for source in sources(root) if source.parts[0] == "control"}
    for listed in re.findall(r"set_source_files_properties\(([^)]*?)PROPERTIES COMPILE_OPTIONS --ramfunc=off", build):
        files -= set(re.findall(r"PROJECT_SOURCE_DIR}/(\S+\.c)", listed))
    functions = set()
    for source in sources(root):
        text = (root / source).read_text(encoding="utf-8")
        functions |= set(re.findall(r"\b(?:BOARD|PORT)_RAM_CODE[\w\s*]*?\b(\w+)\(", text))
    return files, functions
