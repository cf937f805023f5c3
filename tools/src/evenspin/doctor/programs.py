"""Programs on the PATH."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass

from evenspin.doctor.finding import Finding, Purpose, State, older, version_in

PATIENCE_S = 10.0


@dataclass(frozen=True, slots=True)
class Program:
    """One of `names`, of at least this version."""

    names: Sequence[str]
    purpose: Purpose
    needed_for: str
    package: str
    least: str = ""
    ask: Sequence[str] = ("--version",)  # nothing: it cannot be asked


PROGRAMS = (
    Program(("gcc", "cc", "clang"), Purpose.BUILD, "compiles the simulator and the firmware in it", "gcc", "8"),
    Program(("cmake",), Purpose.BUILD, "builds", "cmake", "3.25"),
    Program(("ninja", "ninja-build"), Purpose.BUILD, "builds", "ninja-build"),
    Program(("make",), Purpose.TEST, "short names for everyday work", "make"),
    Program(("ruby",), Purpose.TEST, "makes mocks and test runners (CMock)", "ruby", "2.7"),
    Program(("avr-gcc",), Purpose.TEST, "compiles for an int of 16 bits", "gcc-avr avr-libc"),
    Program(("simavr",), Purpose.TEST, "runs the block tests with an int of 16 bits", "simavr libsimavr-dev libelf-dev",
            ask=()),
    Program(("arm-none-eabi-gcc",), Purpose.TEST, "compiles for the Cortex-M4F; target-report, cycles",
            "gcc-arm-none-eabi libnewlib-arm-none-eabi"),
    Program(("qemu-system-arm",), Purpose.TEST, "runs the block tests on a Cortex-M4F; cycles", "qemu-system-arm",
            "6.0"),
    Program(("cppcheck",), Purpose.TEST, "static analysis with the sizes of the C28x", "cppcheck", "2.0"),
    Program(("clang-16", "clang-19", "clang-18", "clang-17", "clang-15"), Purpose.TEST, "evenspin cycles", "clang-16",
            "15"),
)  # fmt: skip


def check_program(program: Program) -> Finding:
    """Is it there, does it answer, is it recent enough?"""
    name = program.names[0]
    install = f"sudo apt-get install -y {program.package}"
    path = next(filter(None, map(shutil.which, program.names)), None)
    if path is None:
        return Finding(name, program.purpose, State.MISSING, "", program.needed_for, install)
    if not program.ask:
        return Finding(name, program.purpose, State.OK, path, program.needed_for)
    try:
        answer = ask(path, *program.ask)
    except (OSError, subprocess.SubprocessError) as error:
        reason = str(error) or type(error).__name__
        return Finding(name, program.purpose, State.BROKEN, f"{path}: {reason}", program.needed_for, install)
    version = version_in(answer)
    if older(version, program.least):
        step = f"install {program.least} or newer"
        return Finding(name, program.purpose, State.OLD, f"{version} ({path})", program.needed_for, step)
    return Finding(name, program.purpose, State.OK, version or path, program.needed_for)


def ask(*words: str) -> str:
    """What a command says about itself; a bad exit status is an error."""
    done = subprocess.run(
        words, capture_output=True, text=True, errors="replace", check=False, timeout=PATIENCE_S,
        stdin=subprocess.DEVNULL,
    )  # fmt: skip
    if done.returncode != 0:
        raise subprocess.SubprocessError(f"ends with status {done.returncode} when asked {' '.join(words[1:])}")
    return done.stdout or done.stderr
