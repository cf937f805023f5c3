"""cppcheck with the sizes of the C28x over control/ and firmware/, both numerics.

    check.py <root of the repository>

Any finding is a failure. suppressions.txt holds what is right as it stands, each line with its reason; it is empty now.
First a planted error must be found, so that a cppcheck that has lost its platform file is noticed.
Exit status: 0 clean, 1 findings, 3 cppcheck is missing.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent


def findings(root: Path, *arguments: str | Path) -> str:
    done = subprocess.run(
        ["cppcheck", "-q", "--std=c99", "--enable=warning,portability,performance", "--inline-suppr",
         "--template={file}:{line}: {severity} {id}: {message}", *map(str, arguments)],
        cwd=root, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return (done.stderr + done.stdout).strip()


def main(arguments: list[str]) -> int:
    root = Path(arguments[0]).resolve()
    if shutil.which("cppcheck") is None:
        print("cppcheck is not installed; `make setup` says how")
        return 3
    platform = f"--platform={HERE / 'c28x.xml'}"
    if "shiftTooManyBits" not in findings(root, platform, HERE / "planted.c"):
        print("cppcheck does not find the planted error: it does not calculate with the sizes of the C28x")
        return 1
    numerics = ("-UEVENSPIN_FIXED", "-DEVENSPIN_FIXED=1")

    def of(numeric: str) -> str:
        return findings(
            root, platform, numeric, "-I.", "-Ihal/include", "-D__TMS320C28XX__=1",
            f"--suppressions-list={HERE / 'suppressions.txt'}", "control", "firmware",
        )  # fmt: skip

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        texts = list(pool.map(of, numerics))
    for numeric, text in zip(numerics, texts, strict=True):
        if text:
            print(f"{numeric}\n{text}")
    return 1 if any(texts) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
