"""Does hal_order() keep the order of plain data and a flag, with every compiler that is there?

    check_order.py <root of the repository> COMPILER...

Between two stores to the same word a compiler leaves out the first one unless something may look at it in between;
between two loads it leaves out the second. Whether it did shows in the names that are left in its assembly. The same
text with an empty hal_order() must lose them: else this would see nothing. For a compiler that is not gcc hal_order()
has to be a call.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

TEXT = """
#include "hal/hal_order.h"
#ifdef EMPTY
#define hal_order() ((void)0)
#endif
extern const char name_before, name_after;
const void       *data;
volatile unsigned flag;
void              name_of_a_change(void);
void              give(void);
void              take(void);

void give(void)
{
    data = &name_before;
    hal_order();
    flag = 1U;
    data = &name_after;
}

void take(void)
{
    const void *const before = data;
    if (flag != 0U) {
        hal_order();
        if (data != before) {
            name_of_a_change();
        }
    }
}
"""
KEPT = ("name_before", "name_of_a_change")
MORE = ("clang", "clang-16", "arm-none-eabi-gcc", "avr-gcc")


def assembly(compiler: str, root: Path, folder: Path, *options: str) -> str:
    source = folder / "order.c"
    source.write_text(TEXT, encoding="utf-8")
    words = [compiler, "-std=gnu99", "-O2", *options, f"-I{root / 'hal/include'}", "-S", str(source), "-o", "-"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


def names(text: str) -> set[str]:
    return {name for name in (*KEPT, "hal_order") if re.search(rf"\b_?{name}\b", text)}


def faults(compiler: str, root: Path, folder: Path) -> list[str]:
    found = []
    if not names(assembly(compiler, root, folder)) >= set(KEPT):
        found.append(f"{compiler}: hal_order() does not keep plain data beside a flag: hal/include/hal/hal_order.h")
    if names(assembly(compiler, root, folder, "-DEMPTY")) & set(KEPT):
        found.append(f"{compiler}: an empty hal_order() changes nothing, so this check sees nothing")
    other = names(assembly(compiler, root, folder, "-U__GNUC__"))
    if not other >= {*KEPT, "hal_order"}:
        found.append(f"{compiler}: without gcc's assembler line hal_order() is no call of a function")
    return found


def link_time_faults(root: Path) -> list[str]:
    """TI's compiler would look into the empty function."""
    files = [root / "cmake/ti-c2000.cmake", *root.glob("**/CMakeLists.txt")]
    return [
        f"{path.relative_to(root)}: link-time optimisation would see that hal_order() is empty"
        for path in files
        if "build" not in path.parts and re.search(r"--opt_level=4|-O4\b", path.read_text(encoding="utf-8"))
    ]


def main() -> int:
    root = Path(sys.argv[1])
    compilers = [*sys.argv[2:], *(name for name in MORE if shutil.which(name))]
    found = link_time_faults(root)
    with tempfile.TemporaryDirectory() as folder:
        for compiler in compilers:
            found += faults(compiler, root, Path(folder))
    print("\n".join(found) if found else f"hal_order() keeps the order with {', '.join(compilers)}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
