"""Compilers, and what they compile."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from evenspin.errors import InputError

HAL_FUNCTION = re.compile(r"\bhal_(\w+)\(")


def call(*words: str | Path) -> str:
    """Run a command and return what it printed; its failure is an error of one line."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines() or [""]
        raise InputError("cycles", "command", " ".join(str(w) for w in words[:1]), "success", " | ".join(lines[:3]))
    return done.stdout


def include_options(root: Path) -> list[str]:
    return [f"-I{root}", f"-I{root / 'hal/include'}"]


def code_sources(root: Path) -> list[Path]:
    """What runs on the chip but for the port, and what its headers define inline as functions of their own."""
    folders = ("control/*", "firmware/app", "firmware/storage")
    own = [source for folder in folders for source in sorted(root.glob(f"{folder}/*.c"))]
    return [*own, root / "tests/target/cycles/inlined.c"]


def port_sources(root: Path) -> list[Path]:
    """The port to the chip."""
    return sorted((root / "hal/f28379d").glob("*.c"))


def port_options(root: Path) -> list[str]:
    """The port against the fake of driverlib, its hal_ functions by other names: the driver has some of its own."""
    names = [
        name
        for header in sorted((root / "hal/include/hal").glob("*.h"))
        for name in HAL_FUNCTION.findall(header.read_text())
    ]
    return [*(f"-Dhal_{name}=chip_{name}" for name in names), f"-I{root / 'tests/hal/fake_driverlib'}"]


def fake_sources(root: Path) -> list[Path]:
    """The registers behind the port."""
    return sorted((root / "tests/hal/fake_driverlib").glob("*.c"))


def link_sources(root: Path) -> list[Path]:
    """The bench link and the services on it."""
    return sorted((root / "firmware/link").glob("*.c")) + sorted((root / "firmware/services").glob("*.c"))
