"""`make flash`: the right command, or one line with what is missing. No board, no DSLite: a script stands in for it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "setup/flash.py"
VARIABLES = ("DSLITE", "UNIFLASH_ROOT", "CCS_ROOT", "CCXML", "C2000WARE_ROOT")


@pytest.fixture
def place(tmp_path: Path) -> dict[str, str]:
    """An environment in which everything is there, in folders with blanks; DSLite writes down what it was asked."""
    dslite = tmp_path / "uni flash/dslite.sh"
    dslite.parent.mkdir()
    dslite.write_text(f'#!/bin/sh\nprintf "%s\\n" "$@" > "{tmp_path}/asked"\nexit "${{ENDS:-0}}"\n')
    dslite.chmod(0o755)
    target = tmp_path / "C2000 ware/device_support/f2837xd/common/targetConfigs/TMS320F28379D.ccxml"
    target.parent.mkdir(parents=True)
    target.touch()
    (tmp_path / "drive.out").touch()
    clean = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    return clean | {"UNIFLASH_ROOT": str(dslite.parent), "C2000WARE_ROOT": str(tmp_path / "C2000 ware")}


def run(place: dict[str, str], *words: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(SCRIPT), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, env=place, check=False)


def test_flash_loads_and_verifies_and_erases_only_what_the_program_needs(place: dict[str, str], tmp_path: Path) -> None:
    done = run(place, tmp_path / "drive.out")

    assert done.returncode == 0, done.stderr
    asked = (tmp_path / "asked").read_text().splitlines()
    assert asked[0] == f"--config={tmp_path}/C2000 ware/device_support/f2837xd/common/targetConfigs/TMS320F28379D.ccxml"
    assert asked[asked.index("-s") + 1] == "FlashEraseSelection=Necessary Sectors Only (for Program Load)"
    assert {"-f", "-v"} <= set(asked)
    assert asked[-1] == str(tmp_path / "drive.out")


def test_flash_print_runs_nothing(place: dict[str, str], tmp_path: Path) -> None:
    done = run(place, "--print", tmp_path / "drive.out")

    assert done.returncode == 0
    assert "dslite.sh" in done.stdout
    assert not (tmp_path / "asked").exists()


def test_flash_that_fails_says_so(place: dict[str, str], tmp_path: Path) -> None:
    done = run(place | {"ENDS": "3"}, tmp_path / "drive.out")

    assert done.returncode == 1
    assert "DSLite ended with status 3" in done.stderr
    assert "loaded" not in done.stdout


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"UNIFLASH_ROOT": None, "PATH": "/nowhere"}, "install UniFlash"),
        ({"UNIFLASH_ROOT": "/nowhere"}, "UNIFLASH_ROOT = /nowhere: no dslite in it"),
        ({"DSLITE": "/nowhere"}, "DSLITE = /nowhere: not there"),
        ({"C2000WARE_ROOT": None}, "no target configuration"),
        ({"CCXML": "/nowhere"}, "CCXML = /nowhere: not there"),
    ],
)
def test_flash_without_a_part_says_in_one_line_what_to_do(
    change: dict[str, str | None], said: str, place: dict[str, str], tmp_path: Path
) -> None:
    changed = {name: value for name, value in (place | change).items() if value is not None}
    done = run(changed, tmp_path / "drive.out")

    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_flash_of_a_program_that_is_not_there(place: dict[str, str], tmp_path: Path) -> None:
    done = run(place, tmp_path / "other.out")

    assert done.returncode == 2
    assert "build it with" in done.stderr
