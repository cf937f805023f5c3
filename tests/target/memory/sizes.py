"""What the program of the chip takes in flash and RAM, in words of 16 bits: an estimate from a build for the
Cortex-M4F.

Code counts half its octets: measured on TI's own driver library, cl2000 makes 0.86 of the size of Thumb-2, but it
was built without --opt_for_speed, so 1 is taken. A character of a string is a word, since a char has 16 bits.
Other constants and data count half their octets. What nobody refers to is left out by the linker, here as there
(--gen_func_subsections). Run-time library, driver library and flash API are not compiled here: RESERVE_WORDS, of
which some must be in RAM.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from chip_objects import COMPILER, MAIN, WORD, object_of, ram_code, sources

RESERVE_WORDS = {
    ".text": 2500,
    ".TI.ramfunc": 600 + 2000,
    ".const": 800,
    ".cinit": 200,
}  # ramfunc: inline driver library, flash API
FLASH_API_WORDS = 2000  # of these, in the flash build alone
OWN_SECTION = {"drive": "drive_memory", "capture": "capture_memory", "black_box": "black_box_memory",
               "services": "kept_memory"}  # fmt: skip
ENTRIES = ("main", "__error__")
ROW = re.compile(r"^ (\.\S+|COMMON)\n?\s+0x([0-9a-f]+)\s+0x([0-9a-f]+) (\S+)$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Part:
    """`section`: where TI's linker puts it; `file`: of the repository."""

    section: str
    file: str
    words: int


def linked_map(root: Path, work: Path, objects: Sequence[Path]) -> str:
    """The linker's map of all objects, without what nobody refers to."""
    words = [COMPILER, "-mcpu=cortex-m4", "-mthumb", "-nostdlib", "-Wl,--gc-sections", f"-Wl,-e,{ENTRIES[0]}"]
    words += ["-Wl,--unresolved-symbols=ignore-all", f"-Wl,-Map,{work / 'all.map'}", "-o", str(work / "all.elf")]
    words += [*map(str, objects), "-Wl,-Ttext=0x10000", "-w"]
    done = subprocess.run(words, cwd=root, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(done.stderr.strip()[-500:])
    return (work / "all.map").read_text(encoding="utf-8")


def section_of(name: str, file: str, files: set[str], functions: set[str]) -> tuple[str, int]:
    """Section on the chip, and octets of the ARM in one of its words."""
    kind, _, symbol = name[1:].partition(".")
    if kind == "text":
        return (".TI.ramfunc" if file in files or symbol.split(".")[0] in functions else ".text"), WORD
    if kind == "rodata":
        return ".const", 1 if ".str1." in name else WORD
    if symbol in OWN_SECTION and file == MAIN:
        return OWN_SECTION[symbol], WORD
    return {"data": ".data", "bss": ".bss", "COMMON": ".bss"}.get(kind, ""), WORD


def parts(root: Path, work: Path, objects: Sequence[Path]) -> Iterator[Part]:
    names = {str(object_of(source, work)): str(source) for source in sources(root)}
    files, functions = ram_code(root)
    text = linked_map(root, work, objects)
    text = text[text.index("Linker script and memory map") :]
    for name, address, size, path in ROW.findall(text):
        if path in names and int(address, 16) > 0 and int(size, 16) > 0:
            section, octets = section_of(name, names[path], files, functions)
            if section:
                yield Part(section, names[path], (int(size, 16) + octets - 1) // octets)


def room_of(file: str) -> str:
    """control/ by block, the rest by folder and file."""
    return file.removesuffix(".c")


def by_section(found: Sequence[Part]) -> dict[str, int]:
    """Words of every section; an initialised variable takes as much again in .cinit."""
    total = dict(RESERVE_WORDS)
    for part in found:
        total[part.section] = total.get(part.section, 0) + part.words
    total[".cinit"] = total.get(".cinit", 0) + total.get(".data", 0)
    return total


def by_block(found: Sequence[Part]) -> dict[str, dict[str, int]]:
    """Code, constants and data of every file."""
    kinds = {".TI.ramfunc": "code", ".text": "code", ".const": "const"}
    total: dict[str, dict[str, int]] = {}
    for part in found:
        row = total.setdefault(room_of(part.file), {"code": 0, "const": 0, "data": 0})
        row[kinds.get(part.section, "data")] += part.words
    return total
