"""Python, its packages, and the compiled library."""

from __future__ import annotations

import importlib.metadata
import re
import sys
from pathlib import Path

from evenspin.doctor.finding import Finding, Purpose, State, older
from evenspin.errors import EvenspinError

LEAST_PYTHON = "3.11"
SETUP = "make setup"
# What the compiled library is made of, as in tools/setup/setup.sh, and the file that setup leaves when it has built it.
SOURCES = ("control", "hal", "firmware", "sim_host", "cmake", "CMakeLists.txt", "pyproject.toml")
MARKER = Path(".venv/.installed")
REQUIREMENT = re.compile(r"^([\w.-]+)\s*(?:>=\s*([\d.]+))?")


def check_python() -> Finding:
    version = ".".join(str(part) for part in sys.version_info[:3])
    state = State.OLD if older(version, LEAST_PYTHON) else State.OK
    step = f"install Python {LEAST_PYTHON} or newer, then {SETUP}" if state is State.OLD else ""
    return Finding("python", Purpose.BUILD, state, version, "the command evenspin", step)


def check_packages() -> list[Finding]:
    """Packages that evenspin requires: each by itself when something is wrong, else all in one line."""
    findings = []
    for purpose, wanted in ((Purpose.BUILD, ""), (Purpose.TEST, "test")):
        names = [name_and_least(text) for text in requirements(wanted)]
        bad = [finding for name, least in names if (finding := check_package(name, least, purpose)) is not None]
        text = "Python packages" + (" for tests" if wanted else "")
        use = "`make test`" if wanted else "the command evenspin"
        findings += bad or [Finding(text, purpose, State.OK, f"{len(names)} packages", use)]
    return findings


def requirements(extra: str) -> list[str]:
    lines = importlib.metadata.requires("evenspin") or []
    if extra:
        return [line for line in lines if re.search(rf"extra\s*==\s*['\"]{extra}['\"]", line)]
    return [line for line in lines if "extra ==" not in line]


def name_and_least(requirement: str) -> tuple[str, str]:
    match = REQUIREMENT.match(requirement)
    return (match[1], match[2] or "") if match else (requirement, "")


def check_package(name: str, least: str, purpose: Purpose) -> Finding | None:
    """None when it is there and recent enough."""
    use = "`make test`" if purpose is Purpose.TEST else "the command evenspin"
    try:
        version = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return Finding(name, purpose, State.MISSING, "", use, SETUP)
    if older(version, least):
        return Finding(name, purpose, State.OLD, version, use, f"{least} or newer: {SETUP}")
    return None


def check_library(numeric: str, root: Path | None) -> Finding:
    """Can the library be loaded, and is it newer than the sources beside it? `root`: the checkout, if this is one."""
    name = f"library, {numeric}"
    use = "the simulator and the blocks in Python"
    from evenspin.native import load

    try:
        path = load(numeric).path
    except EvenspinError as error:
        return Finding(name, Purpose.BUILD, State.BROKEN, str(error), use, SETUP)
    changed = newer_source(root, path) if root is not None else None
    if changed is not None:
        return Finding(name, Purpose.BUILD, State.OLD, f"older than {changed}", use, SETUP)
    return Finding(name, Purpose.BUILD, State.OK, "built from these sources" if root is not None else str(path), use)


def newer_source(root: Path, library: Path) -> Path | None:
    """A source of the checkout that changed after the library was built; None when there is none."""
    marker = root / MARKER
    built_s = (marker if marker.is_file() else library).stat().st_mtime
    places = [root / name for name in SOURCES if (root / name).exists()]
    everything = [path for place in places for path in (place, *sorted(place.rglob("*")))]
    # a folder changes when a file in it comes or goes; the name of a changed file says more
    for path in sorted(everything, key=lambda path: path.is_dir()):
        if path.stat().st_mtime > built_s:
            return path.relative_to(root)
    return None


def checkout() -> Path | None:
    """The folder of the sources that this package is used from; None for an installed package."""
    for root in Path(__file__).resolve().parents:
        if (root / "tools/src/evenspin").is_dir() and (root / "CMakeLists.txt").is_file():
            return root
    return None
