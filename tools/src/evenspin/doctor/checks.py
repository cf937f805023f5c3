"""All checks, in the order in which they are shown."""

from __future__ import annotations

import os
from pathlib import Path

from evenspin.doctor import package, ti
from evenspin.doctor.finding import Finding, Purpose, State
from evenspin.doctor.programs import PROGRAMS, check_program

CMOCK = "CMOCK_DIR"  # as in cmake/UnityCMock.cmake
CMOCK_DEFAULT = "/usr/share/cmock"


def check_cmock(root: Path | None) -> Finding:
    """Debian's CMock, or the one that CMake has fetched."""
    places = [Path(os.environ.get(CMOCK, CMOCK_DEFAULT))]
    if root is not None:
        places += sorted((root / "build").glob("*/_deps/cmock_upstream-src"))
        places += sorted((root / "build").glob("fetched/cmock_upstream-src"))
    use = "mocks of the HAL"
    for place in places:
        if (place / "lib/cmock.rb").is_file():
            return Finding("cmock", Purpose.TEST, State.OK, str(place), use)
    return Finding("cmock", Purpose.TEST, State.MISSING, "", use, "make setup; without root rights CMake fetches it")


def run_checks() -> list[Finding]:
    root = package.checkout()
    programs = [check_program(program) for program in PROGRAMS]
    findings = [
        package.check_python(),
        *package.check_packages(),
        *(package.check_library(numeric, root) for numeric in ("float", "fixed")),
        *programs,
        check_cmock(root),
        ti.check_compiler(),
        ti.check_library(),
    ]
    order = list(Purpose)
    return sorted(findings, key=lambda finding: order.index(finding.purpose))
