"""Flash and RAM of every block in bytes, compiled for the Cortex-M4F: a stand-in for the map file of the TI linker. And
that map file itself, in words of 16 bits, when there is one: memory, sections, modules, and what docs/bring-up.md
checks in it.

    report.py <root of the repository> [--map FILE]        without FILE: the newest build/c2000/**/*.map

Exit status 1 when the map shows a fault, 2 when FILE cannot be read.

Instances of blocks belong to the drive: the RAM of one is the size of its type, and of all of them that of drive_t.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "map"))
import ti_map

FLAGS = (
    "-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard -O2 -std=c99 -ffp-contract=off -I. -Ihal/include"
).split()
TYPE = re.compile(r"^\} (ctl_\w+_t|drive_t);", re.MULTILINE)
PART = re.compile(r"_(?:params|state|out|walk|filter|line)_t$")


def run(root: Path, *words: str | Path) -> str:
    return subprocess.run([str(w) for w in words], cwd=root, capture_output=True, text=True, check=True).stdout


def print_proxy(root: Path) -> None:
    """Blocks for the Cortex-M4F."""
    total = [0, 0]
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        print(f"{'block':<36}{'flash':>8}{'RAM':>8}   RAM of one instance")
        for source in sorted([*root.glob("control/*/*.c"), *root.glob("firmware/app/*.c")]):
            name = source.relative_to(root)
            run(root, "arm-none-eabi-gcc", *FLAGS, "-c", name, "-o", work / "x.o")
            text, data, bss = map(int, run(root, "arm-none-eabi-size", work / "x.o").splitlines()[1].split()[:3])
            total = [total[0] + text + data, total[1] + data + bss]
            header = source.with_suffix(".h")
            if source.stem == "state_machine":
                header = source.with_name("drive.h")
            types = TYPE.findall(header.read_text()) if header.exists() else []
            types = [t for t in types if not PART.search(t)]
            sizes = []
            for kind in types:
                include = header.relative_to(root)
                (work / "s.c").write_text(f'#include "{include}"\nchar size[sizeof({kind})];\n')
                run(root, "arm-none-eabi-gcc", *FLAGS, "-c", work / "s.c", "-o", work / "s.o")
                sizes.append(f"{kind} {run(root, 'arm-none-eabi-size', work / 's.o').splitlines()[1].split()[2]}")
            print(f"{name!s:<36}{text + data:>8}{data + bss:>8}   {', '.join(sizes)}")
        print(f"{'all':<36}{total[0]:>8}{total[1]:>8}")


def newest_map(root: Path) -> Path | None:
    found = sorted(root.glob("build/c2000/**/*.map"), key=lambda path: path.stat().st_mtime)
    return found[-1] if found else None


def print_map(path: Path) -> int:
    """The linker's map of the program for the chip."""
    try:
        found = ti_map.parse(path.read_text(encoding="utf-8", errors="replace"))
    except OSError as error:
        print(f"{path}: {error.strerror}; link the program first: cmake --build --preset c2000", file=sys.stderr)
        return 2
    if not found.sections:
        print(f"{path}: no SECTION ALLOCATION MAP in it: not a map file of cl2000", file=sys.stderr)
        return 2
    print(f"\n{path}, words of 16 bits\n")
    print("\n".join(ti_map.report(found)))
    faults = ti_map.faults(found)
    print("\n" + "\n".join(faults or ["What docs/bring-up.md looks for in the map is there."]))
    return 1 if faults else 0


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Flash and RAM of every block.")
    parser.add_argument("root", type=Path)
    parser.add_argument("--map", type=Path, help="map file of cl2000")
    options = parser.parse_args(arguments)
    root = options.root.resolve()
    if shutil.which("arm-none-eabi-gcc") is None:
        print("arm-none-eabi-gcc is not installed, so no sizes for the Cortex-M4F; `make setup` says how")
    else:
        print_proxy(root)
    path = options.map or newest_map(root)
    if path is None:
        print("\nno map file of TI's linker below build/c2000; --map FILE names one")
        return 0
    return print_map(path)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
