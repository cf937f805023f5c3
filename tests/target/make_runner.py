"""Take the tests that cannot run on a machine out of a runner that Unity has generated.

    make_runner.py <runner.c> <unfit.txt> <numeric>

The lines `<file>[_<numeric>]:<test>  <reason>` of unfit.txt count here; naming a test that the file does not have is an
error.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path


def main(arguments: list[str]) -> int:
    runner, unfit, numeric = Path(arguments[0]), Path(arguments[1]), arguments[2]
    name = runner.stem.removesuffix(f"_{numeric}")
    text = runner.read_text()
    for line in unfit.read_text().splitlines():
        entry = line.split("#")[0].split()
        if not entry or ":" not in entry[0]:
            continue
        file, test = entry[0].split(":")
        if file not in (name, f"{name}_{numeric}"):
            continue
        text, removed = re.subn(rf"^\s*run_test\({re.escape(test)},.*\n", "", text, flags=re.MULTILINE)
        if removed != 1:
            print(f"{unfit}: {entry[0]}: there is no such test in {name}", file=sys.stderr)
            return 1
    runner.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
