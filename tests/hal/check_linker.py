"""Check the linker files of the F28379D against its memory map and against the sources that name their symbols.

    check_linker.py <root of the repository>

No TI linker is needed. Every fault is printed; exit status 1 if there is one.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

# Word addresses of CPU1: first word and the word after the last.
BLOCKS = {
    "boot ROM's RAM": (0x000002, 0x000123),
    "M0, M1": (0x000123, 0x000800),  # one piece: M1 begins where M0 ends
    "begin in RAM": (0x000000, 0x000002),
    "LS, D, GS": (0x008000, 0x01C000),
    "flash": (0x080000, 0x0C0000),
    "reset vector": (0x3FFFC0, 0x3FFFC2),
}
# Prefetch runs ahead of code: these words must not hold any (errata).
KEPT_EMPTY = ((0x0007F8, 0x000800), (0x01BFF8, 0x01C000), (0x0BFFF0, 0x0C0000))
SECTIONS = (
    "codestart .text .cinit .init_array .const .switch .TI.ramfunc .stack .bss .data .bss:output drive_memory "
    "capture_memory black_box_memory kept_memory .reset"
).split()

KEPT = ("black_box_memory", "kept_memory")  # over a reset
SUMMED = (".text", ".cinit", ".const", ".TI.ramfunc")  # what the flash holds of the program

# What hal/f28379d/storage.c erases: nothing may be linked there.
STORAGE = re.compile(r"FIRST_SECTOR UINT32_C\((0x\w+)\).*?SECTORS (\d+)U.*?SECTOR_WORDS (0x\w+)U", re.DOTALL)


def without_comments(text: str) -> str:
    return re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)


def faults(name: str, text: str, main: str, system: str, build: str, storage: str) -> list[str]:
    found = []
    text = without_comments(text)
    regions = {
        m[1]: (int(m[2], 16), int(m[2], 16) + int(m[3], 16))
        for m in re.finditer(r"(\w+)\s*:\s*origin = (0x\w+), length = (0x\w+)", text)
    }
    for region, (first, end) in regions.items():
        if not any(low <= first and end <= high for low, high in BLOCKS.values()):
            found.append(f"{region}: not inside a block of the chip")
        if any(first < high and low < end for low, high in KEPT_EMPTY):
            found.append(f"{region}: reaches into words that stay empty")
        for other, (first2, end2) in regions.items():
            if region < other and first < end2 and first2 < end:
                found.append(f"{region} and {other} overlap")
    placed = dict(re.findall(r"^\s*([.\w:]+)\s*: (.*)", text[text.index("SECTIONS") :], flags=re.MULTILINE))
    for section in SECTIONS:
        if section not in placed:
            found.append(f"{section}: not placed")
    for section, where in placed.items():
        named = re.findall(r"\b(?:RAM\w*|FLASH\w*)\b", where)
        found.extend(f"{section}: there is no region {region}" for region in named if region not in regions)
    first, count, words = (int(number, 0) for number in STORAGE.search(storage).groups())
    for region, (low, high) in regions.items():
        if low < first + count * words and first < high and region != "STORAGE":
            found.append(f"{region}: reaches into the sectors that hal/f28379d/storage.c erases")
    if "flash" in name and regions.get("STORAGE") != (first, first + count * words):
        found.append("STORAGE: not the sectors of hal/f28379d/storage.c")
    if any("STORAGE" in where for where in placed.values()):
        found.append("STORAGE: something is placed there")
    stack = regions["RAM_STACK"]
    if stack[1] > 0x10000:
        found.append(".stack: above what a stack pointer of 16 bits reaches")
    if stack[0] % 2:
        found.append("RAM_STACK: must begin at an even address")
    asked = int(re.search(r"--stack_size=(0x\w+)", build)[1], 16)
    if asked > stack[1] - stack[0]:
        found.append(f"RAM_STACK: smaller than --stack_size={asked:#x} of firmware/CMakeLists.txt")
    given = re.search(r"MAIN_DRIVE_REGION_WORDS=(0x\w+)U", build)[1] if "flash" not in name else None
    words = int(given or re.search(r"MAIN_DRIVE_REGION_WORDS (0x\w+)U", main)[1], 16)
    if regions["RAM_DRIVE"][1] - regions["RAM_DRIVE"][0] != words:
        found.append("RAM_DRIVE: not the length that firmware/main_f28379d.c assumes")
    given = re.search(r"MAIN_BLACK_BOX_VALUES=(\d+)U", build)[1] if "flash" not in name else None
    values = int(given or re.search(r"MAIN_BLACK_BOX_VALUES (\d+)U", main)[1])
    if regions["RAM_BOX"][1] - regions["RAM_BOX"][0] < 2 * values:
        found.append("RAM_BOX: too small for the black box of firmware/main_f28379d.c")
    given = re.search(r"MAIN_CAPTURE_VALUES=(\d+)U", build)[1] if "flash" not in name else None
    values = int(given or re.search(r"MAIN_CAPTURE_VALUES (\d+)U", main)[1])
    if regions["RAM_CAPTURE"][1] - regions["RAM_CAPTURE"][0] < 2 * values:
        found.append("RAM_CAPTURE: too small for the capture of firmware/main_f28379d.c")
    for section in KEPT:
        if "TYPE = NOINIT" not in placed.get(section, ""):
            found.append(f"{section}: not TYPE = NOINIT: the C start-up would clear what a reset has to leave")
    if "flash" in name:
        if ".TI.crctab" not in placed:
            found.append(".TI.crctab: not placed: there are the check sums of the program")
        for section in SUMMED:
            if not re.search(rf"^\s*{re.escape(section)}\s*:[^;]*?crc_table\(", text, flags=re.MULTILINE):
                found.append(f"{section}: has no crc_table for the self test of the program")
        for symbol in re.findall(r"extern uint16_t (.*);", system):
            for part in symbol.split(", "):
                if f"({part})" not in text:
                    found.append(f"{part}: used by system.c or self_test_places.c, not defined here")
    return [f"{name}: {fault}" for fault in found]


def main(arguments: list[str]) -> int:
    root = Path(arguments[0])
    program = (root / "firmware" / "main_f28379d.c").read_text(encoding="utf-8")
    port = root / "hal" / "f28379d"
    system = "".join((port / name).read_text(encoding="utf-8") for name in ("system.c", "self_test_places.c"))
    build = (root / "firmware" / "CMakeLists.txt").read_text(encoding="utf-8")
    storage = (root / "hal" / "f28379d" / "storage.c").read_text(encoding="utf-8")
    files = sorted((root / "linker").glob("f28379d_*.cmd"))
    sources = (program, system, build, storage)
    found = [f for file in files for f in faults(file.name, file.read_text(encoding="utf-8"), *sources)]
    print("\n".join([*found, f"check_linker: {len(files)} files, {len(found)} faults"]))
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
