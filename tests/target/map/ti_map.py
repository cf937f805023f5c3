"""Read the map file of TI's linker (cl2000 --map_file, EABI), and check it for what the drive relies on.

Written from the description of the format, without a linker at hand: columns are recognised by their shape, and what is
not recognised is left out. Sizes are words of 16 bits; addresses are word addresses.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

# First word and the word after the last of what the chip has; the CPU fetches from both, from RAM without waiting.
RAM = ((0x000000, 0x000800), (0x008000, 0x01C000))
FLASH = ((0x080000, 0x0C0000),)

MEMORY_ROW = re.compile(r"^\s{1,4}(\S+)\s+([0-9a-f]{8})\s+([0-9a-f]{8})\s+([0-9a-f]{8})\s+([0-9a-f]{8})\s+\S+")
SECTION_NAME = re.compile(r"^([.\w$][\w.:$]*)\s*$")
SECTION_ROW = re.compile(r"^(?:([.\w$][\w.:$]*)|\*)\s+(?:\d+\s+)?([0-9a-f]{8})\s+([0-9a-f]{8})(?:\s+(.*))?$")
RUN_ADDRESS = re.compile(r"RUN ADDR = ([0-9a-f]{8})")
MODULE_ROW = re.compile(r"^\s{4,}(\S.*?)\s+(\d+)\s+(\d+)\s+(\d+)\s*$")
LIBRARY_ROW = re.compile(r"^\s{1,4}(\S.*?)\s*$")
SYMBOL_ROW = re.compile(r"^(?:\d+\s+|abs\s+)?([0-9a-f]{8})\s+(?:\d+\s+\([0-9a-f]{8}\)\s+)?(\S+)\s*$")
TITLES = ("MEMORY CONFIGURATION", "SECTION ALLOCATION MAP", "MODULE SUMMARY", "GLOBAL SYMBOLS", "GLOBAL DATA SYMBOLS",
          "LINKER GENERATED", "SEGMENT ALLOCATION MAP", "FAR CALL TRAMPOLINES")  # fmt: skip

# Names of run-time routines for 64-bit floats, and of the division that the TMU replaces, under EABI and before it.
DOUBLE = re.compile(r"^(?:__c28xabi_(?:(?:add|sub|mul|div|neg|cmp)d|dto\w+|\w+tod)|FD\$\$\w+)$")
DIVISION = re.compile(r"^(?:FS\$\$DIV|__c28xabi_divf)$")


@dataclass(frozen=True, slots=True)
class Region:
    name: str
    origin: int
    length: int
    used: int


@dataclass(frozen=True, slots=True)
class Section:
    """`run`: where it is when it is used; differs from `load` for what start-up copies to RAM."""

    name: str
    load: int
    length: int
    run: int


@dataclass(frozen=True, slots=True)
class Module:
    library: str
    name: str
    code: int
    initialised: int
    uninitialised: int


@dataclass(slots=True)
class Map:
    regions: list[Region] = field(default_factory=list)
    sections: list[Section] = field(default_factory=list)
    modules: list[Module] = field(default_factory=list)
    symbols: dict[str, int] = field(default_factory=dict)

    def section(self, name: str) -> Section | None:
        return next((section for section in self.sections if section.name == name), None)


def parse(text: str) -> Map:
    """Everything that is recognised; a text that is no map gives an empty one."""
    found = Map()
    part, library, pending = "", "", ""
    for line in text.splitlines():
        title = next((title for title in TITLES if line.startswith(title)), None)
        if title is not None:
            part, library, pending = title, "", ""
        elif part == "MEMORY CONFIGURATION":
            if row := MEMORY_ROW.match(line):
                found.regions.append(Region(row[1], *(int(row[k], 16) for k in (2, 3, 4))))
        elif part == "SECTION ALLOCATION MAP":
            pending = read_section(found, line, pending)
        elif part == "MODULE SUMMARY":
            library = read_module(found, line, library)
        elif part.startswith("GLOBAL") and (row := SYMBOL_ROW.match(line)):
            found.symbols[row[2]] = int(row[1], 16)
    return found


def read_section(found: Map, line: str, pending: str) -> str:
    """A section's row; its name stands alone on the line before when it is long. Indented rows are input sections."""
    if row := SECTION_ROW.match(line):
        name = row[1] or pending
        if name:
            load, length = int(row[2], 16), int(row[3], 16)
            run = RUN_ADDRESS.search(row[4] or "")
            found.sections.append(Section(name, load, length, int(run[1], 16) if run else load))
        return ""
    alone = SECTION_NAME.match(line)
    return alone[1] if alone and not line.startswith("-") else pending


def read_module(found: Map, line: str, library: str) -> str:
    """A module's row, or the line above its rows: a folder or an archive."""
    if row := MODULE_ROW.match(line):
        if not row[1].endswith(":"):  # Total, Grand Total, Stack, Linker Generated
            found.modules.append(Module(library, row[1], int(row[2]), int(row[3]), int(row[4])))
        return library
    place = LIBRARY_ROW.match(line)
    if place and not re.match(r"^[-+ ]+$|^Module\s", place[1]) and not place[1].endswith(":"):
        return place[1]
    return library


# ---- what the drive relies on, docs/bring-up.md step 0 --------------------------------------------------------------

IN_RAM = ("drive_current_isr", "drive_speed_isr", "ctl_pi_output", "hal_sample_read", "main_current_isr")
CODE_START = 0x080000
DRIVE_REGION = (0x014000, 0x019000)
STACK_END = 0x010000


def inside(address: int, ranges: tuple[tuple[int, int], ...]) -> bool:
    return any(first <= address < end for first, end in ranges)


def faults(found: Map) -> list[str]:
    """What must be corrected before the program goes to the chip, one line each."""
    lines = []
    flash_build = any(inside(section.load, FLASH) and section.length > 0 for section in found.sections)
    start = found.section("codestart")
    wanted = CODE_START if flash_build else 0
    if start is None or start.load != wanted:
        at = "missing" if start is None else f"at {start.load:#08x}"
        lines.append(f"codestart: {at}, must be at {wanted:#08x}: the boot ROM jumps there")
    for name in IN_RAM:
        address = found.symbols.get(name)
        if address is None:
            lines.append(f"{name}: not in the map: removed, or inlined into something else")
        elif not inside(address, RAM):
            lines.append(f"{name}: at {address:#08x}, must be in RAM: --ramfunc did not act")
    lines += [
        f"{name}: at {address:#08x}, must be in RAM: the flash API cannot run from the bank that it programs"
        for name, address in sorted(found.symbols.items())
        if name.startswith("Fapi_") and not inside(address, RAM)
    ]
    stack = found.section(".stack")
    if stack is None or stack.load + stack.length > STACK_END:
        lines.append(f".stack: must end below {STACK_END:#08x}: the stack pointer has 16 bits")
    drive = found.section("drive_memory")
    if drive is None or not DRIVE_REGION[0] <= drive.load <= drive.load + drive.length <= DRIVE_REGION[1]:
        lines.append(
            f"drive_memory: must lie in {DRIVE_REGION[0]:#08x} .. {DRIVE_REGION[1]:#08x}: MAIN_DRIVE_REGION_WORDS"
        )
    for name in sorted(found.symbols):
        if DOUBLE.match(name):
            lines.append(f"{name}: arithmetic with 64-bit floats slipped in")
        elif DIVISION.match(name):
            lines.append(f"{name}: a division is not on the TMU: --fp_mode=relaxed")
    lines += [f"{r.name}: full, {r.used} of {r.length} words" for r in found.regions if r.used > r.length]
    return lines


# ---- tables ---------------------------------------------------------------------------------------------------------


def report(found: Map) -> list[str]:
    """Regions, sections, and modules by library, in words."""
    lines = [f"{'memory':<14}{'origin':>10}{'words':>9}{'used':>9}{'%':>5}"]
    for r in found.regions:
        share = 100.0 * r.used / r.length if r.length else 0.0
        lines.append(f"{r.name:<14}{r.origin:>#10x}{r.length:>9}{r.used:>9}{share:>5.0f}")
    lines += ["", f"{'section':<20}{'load':>10}{'run':>10}{'words':>9}"]
    lines += [f"{s.name:<20}{s.load:>#10x}{s.run:>#10x}{s.length:>9}" for s in found.sections if s.length]
    lines += ["", f"{'module':<44}{'code':>8}{'const':>8}{'RAM':>8}"]
    library = None
    for m in found.modules:
        if m.library != library:
            library = m.library
            lines.append(f"{library.replace(chr(92), '/').rsplit('/', 1)[-1] or 'objects'}")
        lines.append(f"  {m.name:<42}{m.code:>8}{m.initialised:>8}{m.uninitialised:>8}")
    total = [sum(getattr(m, key) for m in found.modules) for key in ("code", "initialised", "uninitialised")]
    lines.append(f"{'all':<44}{total[0]:>8}{total[1]:>8}{total[2]:>8}")
    return lines
