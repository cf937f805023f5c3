"""Flash and RAM of every block in bytes, compiled for the Cortex-M4F: a stand-in for the map file of the TI linker.

    report.py <root of the repository>

Instances of blocks belong to the drive: the RAM of one is the size of its type, and of all of them that of drive_t.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

FLAGS = (
    "-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard -O2 -std=c99 -ffp-contract=off -I. -Ihal/include"
).split()
TYPE = re.compile(r"^\} (ctl_\w+_t|drive_t);", re.MULTILINE)
PART = re.compile(r"_(?:params|state|out|walk|filter|line)_t$")


def run(root: Path, *words: str | Path) -> str:
    return subprocess.run([str(w) for w in words], cwd=root, capture_output=True, text=True, check=True).stdout


def main(arguments: list[str]) -> int:
    root = Path(arguments[0]).resolve()
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
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
