"""Does the program of the chip fit: its deepest stack, its image in flash and in RAM? From a build for the Cortex-M4F.

    check.py <root of the repository> [--record] [--quiet]

Prints the ways to the deepest stack, the sections against the regions of linker/*.cmd, and the words of every file.
Limits and recorded words are in tests/budget/memory.toml; --record writes the words again. Exit status 1 when something
does not fit, 77 when arm-none-eabi-gcc is not installed.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import sys
import tempfile
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import chip_objects
import sizes
import stack

BUDGET = Path("tests/budget/memory.toml")
SKIPPED = 77
# cl2000 inlines what is declared inline, and next to nothing else.
INLINING = ("-fno-inline-functions", "-fno-inline-small-functions", "-fno-inline-functions-called-once",
            "-fno-ipa-sra", "-fno-ipa-cp")  # fmt: skip
WITHOUT = ("-DEVENSPIN_NO_TEXTS",)  # as firmware/CMakeLists.txt says for the chip
PLACED = re.compile(r"^\s*([.\w:]+)\s*: ([^:]*?)(?=^\s*[.\w:]+\s*: |^\})", re.MULTILINE | re.DOTALL)
FLASH_ONLY = re.compile(r"hal/f28379d/self_test\w*\.c")  # empty in a program for RAM: PORT_SELF_TEST
FILE_SLACK = 1.2  # a file may grow by a fifth and...
FILE_MORE = 150  # ...so many words before it is recorded again; a new file may have as many
SECTION_SLACK = 1.05


def stack_words(root: Path) -> int:
    """What the linker is asked for."""
    build = (root / "firmware/CMakeLists.txt").read_text(encoding="utf-8")
    return int(re.search(r"--stack_size=(0x\w+)", build)[1], 16)


def capture_words(root: Path) -> dict[str, int]:
    """The recorders of the RAM build are smaller: what its definitions make them."""
    build = (root / "firmware/CMakeLists.txt").read_text(encoding="utf-8")
    given = {name: int(value) for name, value in re.findall(r"MAIN_(CAPTURE|BLACK_BOX)_VALUES=(\d+)U", build)}
    return {f"{name.lower()}_memory": 2 * value for name, value in given.items()}


def observer_words(root: Path) -> int:
    """The observer's memory of the RAM build is smaller, too: by so many words, two a number."""
    build = (root / "firmware/CMakeLists.txt").read_text(encoding="utf-8")
    header = (root / "firmware/app/drive.h").read_text(encoding="utf-8")
    full = int(re.search(r"#define DRIVE_OBSERVER_CAPACITY (\d+)U", header)[1])
    return 2 * (full - int(re.search(r"DRIVE_OBSERVER_CAPACITY=(\d+)U", build)[1]))


def regions(command_file: str) -> tuple[dict[str, int], dict[str, list[tuple[str, ...]]]]:
    """Words of every region, and for every section where it lies; a choice of regions counts as one."""
    text = re.sub(r"/\*.*?\*/", "", command_file, flags=re.DOTALL)
    length = {m[1]: int(m[2], 16) for m in re.finditer(r"(\w+)\s*:\s*origin = \w+, length = (0x\w+)", text)}
    placed = {}
    for section, where in PLACED.findall(text[text.index("SECTIONS") :]):
        groups = re.findall(r"(?:>+|LOAD =|RUN =)\s*((?:\w+)(?:\s*\|\s*\w+)*)", where)
        placed[section] = [tuple(re.findall(r"\w+", group)) for group in groups]
    return length, placed


def fit(name: str, command_file: str, words: dict[str, int], share: float) -> tuple[list[str], list[str]]:
    """Rows of the table and faults."""
    length, placed = regions(command_file)
    used: dict[tuple[str, ...], int] = {}
    for section, count in words.items():
        for group in placed.get(section, []):
            used[group] = used.get(group, 0) + count
    rows, found = [], [f"{name}: {section} is placed nowhere" for section in words if section not in placed]
    for group in list(used):  # what has a choice takes what the others leave
        room = sum(length[region] for region in group)
        inside = sum(count for other, count in used.items() if set(other) <= set(group))
        rows.append(f"  {' + '.join(group):<34}{room:>8}{inside:>8}{100 * inside / room:>7.0f} %")
        full = (*sizes.OWN_SECTION.values(), ".stack")  # as large as they were made: they may fill their region
        limit = 1.0 if any(group in placed[section] for section in full if section in placed) else share
        if inside > limit * room:
            over = f"{inside} of {room} words, {100 * limit:.0f} % allowed"
            found.append(f"{name}: {' + '.join(group)}: {over}; move a section or make the code smaller")
    return rows, found


def grown(kind: str, now: dict[str, int], before: dict[str, int], slack: float, more: int) -> list[str]:
    return [
        f"{kind} {name}: {words} words, recorded {before.get(name, 0)}; make it smaller, or run check.py --record "
        "and write the reason into the commit"
        for name, words in now.items()
        if words > slack * before.get(name, 0) + more
    ]


def write(path: Path, budget: dict[str, object], sections: dict[str, int], files: dict[str, int]) -> None:
    head = path.read_text(encoding="utf-8").split("[sections]")[0]
    lines = [f'"{name}" = {words}' for name, words in sorted(sections.items())]
    rows = [f'"{name}" = {words}' for name, words in sorted(files.items())]
    path.write_text("\n".join([head + "[sections]", *lines, "", "[files]", *rows, ""]), encoding="utf-8")


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Stack and image of the chip, estimated.")
    parser.add_argument("root", type=Path)
    parser.add_argument("--record", action="store_true", help="write sections and files into tests/budget/memory.toml")
    parser.add_argument("--quiet", action="store_true", help="the faults and one line of result")
    options = parser.parse_args(arguments)
    root = options.root.resolve()
    if shutil.which(chip_objects.COMPILER) is None:
        print(f"{chip_objects.COMPILER} is not installed, so stack and image of the chip are not counted; `make setup`")
        return 1 if os.environ.get("CI") == "true" else SKIPPED
    budget = tomllib.loads((root / BUDGET).read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        objects = chip_objects.compile_all(root, work, (*INLINING, *WITHOUT))
        try:
            depths = stack.depths([stack.read_graph(work)])
        except stack.Unknown as why:
            print(f"the depth of the stack cannot be determined: {why}")
            return 1
        parts = list(sizes.parts(root, work, objects))
    sections = sizes.by_section(parts)
    blocks = sizes.by_block(parts)
    files = {name: sum(row.values()) for name, row in blocks.items()}

    given, worst, share = stack_words(root), stack.worst(depths), budget["limits"]["stack"]
    say = [f"stack: {worst} of {given} words, {100 * worst / given:.0f} %, at most {100 * share:.0f} %"]
    say += [
        f"  {depth.name:<20}{depth.words:>5}  {' > '.join(name.split(':')[-1] for name in depth.way)}"
        for depth in depths
    ]
    found = [f"stack: {worst} words of {given}, {100 * share:.0f} % allowed"] if worst > share * given else []
    for memory in ("flash", "ram"):
        words = sections | {".stack": given}
        if memory == "ram":
            words = sizes.by_section([part for part in parts if not FLASH_ONLY.match(part.file)]) | {".stack": given}
            words |= capture_words(root) | {".TI.ramfunc": words[".TI.ramfunc"] - sizes.FLASH_API_WORDS}
            words["drive_memory"] -= observer_words(root)
        text = (root / f"linker/f28379d_{memory}.cmd").read_text(encoding="utf-8")
        rows, faults = fit(memory, text, words, budget["limits"][memory])
        say += [f"{memory}: region, words, used", *rows]
        found += faults
    say += [f"{'section':<36}{'words':>8}", *(f"  {name:<34}{words:>8}" for name, words in sorted(sections.items()))]
    say += [f"{'file':<40}{'code':>7}{'const':>7}{'data':>7}"]
    say += [f"{name:<40}{row['code']:>7}{row['const']:>7}{row['data']:>7}" for name, row in sorted(blocks.items())]
    if options.record:
        write(root / BUDGET, budget, sections, files)
    else:
        found += grown("section", sections, budget["sections"], SECTION_SLACK, FILE_MORE)
        found += grown("file", files, budget["files"], FILE_SLACK, FILE_MORE)
    if not options.quiet:
        print("\n".join(say))
    print("\n".join(found) or f"the program of the chip fits; {say[0]}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
