"""Take the tests that cannot run on a machine out of a runner that Unity has generated.

    make_runner.py <runner.c> <unfit.txt> <numeric>

A line of unfit.txt is `<name>[_<numeric>]  <reason>`; the name is a test file's or a test's. A name that no runner has any
more is an error only for the file it stands in, so it is looked up there: `<file>:<test>`.
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
