"""Load the program of the chip into flash over the probe on the LaunchPad: `make flash`. docs/flashing.md has the
rest.

    flash.py [--print] [FILE.out]

FILE.out: by default the newest build/c2000/**/evenspin_f28379d_*.out. DSLite is searched in DSLITE,
UNIFLASH_ROOT, CCS_ROOT, and on the PATH; the target configuration in CCXML, and in C2000WARE_ROOT. Erased is what
the program needs and nothing else, so that parameters and learned table stay. --print shows the command and runs
nothing. Exit status 2 when something is missing.
"""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NAMES = ("dslite.sh", "dslite.bat", "dslite")
# Below UNIFLASH_ROOT, and below CCS_ROOT (the folder with ccs_base in it).
PLACES = {"UNIFLASH_ROOT": ("",), "CCS_ROOT": ("ccs_base/DebugServer/bin", "ccs/ccs_base/DebugServer/bin")}
TARGET = Path("device_support/f2837xd/common/targetConfigs/TMS320F28379D.ccxml")
KEEP = "FlashEraseSelection=Necessary Sectors Only (for Program Load)"  # the default erases the stored parameters, too


class Missing(Exception):
    """Something is not there; what to do."""


def program(given: str | None) -> Path:
    if given:
        path = Path(given)
        if not path.is_file():
            raise Missing(f"{path}: not there; build it with cmake --build --preset c2000")
        return path
    found = sorted(ROOT.glob("build/c2000/**/evenspin_f28379d_*.out"), key=lambda path: path.stat().st_mtime)
    if not found:
        raise Missing("build/c2000: no evenspin_f28379d_*.out; cmake --preset c2000 && cmake --build --preset c2000")
    return found[-1]


def dslite() -> Path:
    if given := os.environ.get("DSLITE"):
        if not Path(given).is_file():
            raise Missing(f"DSLITE = {given}: not there; set it to dslite.sh (dslite.bat) of UniFlash or CCS")
        return Path(given)
    for variable, folders in PLACES.items():
        if root := os.environ.get(variable):
            for path in (Path(root, folder, name) for folder in folders for name in NAMES):
                if path.is_file():
                    return path
            raise Missing(f"{variable} = {root}: no dslite in it; set it to the folder of the installation")
    if path := next(filter(None, map(shutil.which, NAMES)), None):
        return Path(path)
    raise Missing("no DSLite: install UniFlash (ti.com, free) and set UNIFLASH_ROOT to its folder; docs/flashing.md")


def target() -> Path:
    if given := os.environ.get("CCXML"):
        if not Path(given).is_file():
            raise Missing(
                f"CCXML = {given}: not there; a target configuration for TMS320F28379D with XDS100v2 is wanted"
            )
        return Path(given)
    path = Path(os.environ.get("C2000WARE_ROOT", ""), TARGET)
    if not os.environ.get("C2000WARE_ROOT") or not path.is_file():
        raise Missing(
            f"no target configuration: set C2000WARE_ROOT to C2000Ware, which has {TARGET}, or CCXML to a file"
        )
    return path


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Load the program into the flash of the LaunchPad.")
    parser.add_argument("file", nargs="?", help="program, a .out; default: the newest below build/c2000")
    parser.add_argument("--print", action="store_true", dest="only_print", help="show the command, run nothing")
    options = parser.parse_args(arguments)
    try:
        command = [str(dslite()), f"--config={target()}", "-s", KEEP, "-f", "-v", str(program(options.file))]
    except Missing as missing:
        print(f"flash: {missing}", file=sys.stderr)
        return 2
    print(shlex.join(command), flush=True)
    if options.only_print:
        return 0
    status = subprocess.run(command, check=False).returncode
    if status != 0:
        print(f"flash: DSLite ended with status {status}; docs/flashing.md, What goes wrong", file=sys.stderr)
        return 1
    print("loaded and verified; press RESET with S1 all up, and the drive comes up")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
