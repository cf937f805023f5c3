"""Say which lines and branches of control/ its tests reach, and fail when it is fewer than it has to be.

    coverage_gate.py <build folder of the coverage preset>

control/ is compiled once per numeric; what either build reaches counts as reached. A page per file with the marked
source is left in <build folder>/coverage/index.html.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LINES_PERCENT = 100.0
BRANCHES_PERCENT = 95.0


def gcovr(build: Path, *outputs: str) -> None:
    subprocess.run(
        [
            sys.executable,
            "-m",
            "gcovr",
            f"--root={ROOT}",
            f"--filter={ROOT}/control/",
            # num.h defines the same functions for both numerics, at different lines.
            "--merge-mode-functions=separate",
            "--json-summary",
            str(build / "coverage" / "summary.json"),
            *outputs,
            str(build),
        ],
        cwd=ROOT,
        check=True,
    )


def main(arguments: list[str]) -> int:
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    build = Path(arguments[0]).resolve()
    (build / "coverage").mkdir(exist_ok=True)
    gcovr(build, "--txt=-", "--html-details", str(build / "coverage" / "index.html"))

    summary = json.loads((build / "coverage" / "summary.json").read_text())
    if not summary["line_total"]:
        print("coverage: nothing of control/ was measured")
        return 1
    lines, branches = summary["line_percent"], summary["branch_percent"]
    print(f"coverage of control/: {lines} % of the lines, {branches} % of the branches", flush=True)
    if branches < BRANCHES_PERCENT:
        gcovr(build, "--txt=-", "--txt-metric=branch")
    if lines < LINES_PERCENT or branches < BRANCHES_PERCENT:
        print(f"coverage: at least {LINES_PERCENT} % and {BRANCHES_PERCENT} % are wanted")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
