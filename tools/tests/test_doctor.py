"""`evenspin doctor`: on a PATH of fakes, with TI's tools in every state, with a library that is too old."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest
from evenspin.doctor import package, ti
from evenspin.doctor.finding import Finding, Purpose, State, older, version_in
from evenspin.doctor.programs import PROGRAMS, Program, check_program
from said import Said

TOOL = Program(("tool", "other-tool"), Purpose.TEST, "tests", "tool-package", "3.25")


def fake(folder: Path, name: str, script: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return path


@pytest.fixture
def bin_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only folder on the PATH."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    for name in ("C2000ROOT", "C2000WARE_ROOT", "CMOCK_DIR"):
        monkeypatch.delenv(name, raising=False)
    return folder


@pytest.mark.usefixtures("bin_folder")
def test_a_program_that_is_not_there_is_missing_with_its_package() -> None:
    finding = check_program(TOOL)

    assert (finding.state, finding.next_step) == (State.MISSING, "sudo apt-get install -y tool-package")


@pytest.mark.parametrize(
    ("says", "state"),
    [("tool version 3.25.0", State.OK), ("tool 3.24.9 (build 9.9)", State.OLD), ("tool v4.0", State.OK),
     ("tool (Distribution 1:7.2) 3.30", State.OK), ("no number", State.OK)],
)  # fmt: skip
def test_a_program_is_as_recent_as_it_says(bin_folder: Path, says: str, state: State) -> None:
    fake(bin_folder, "tool", f"echo '{says}'")

    if "1:7.2" in says:
        assert version_in(says) == "7.2"  # the first thing that looks like one
    assert check_program(TOOL).state is state


def test_another_name_of_the_program_will_do(bin_folder: Path) -> None:
    fake(bin_folder, "other-tool", "echo 3.30.1")

    assert check_program(TOOL).good


def test_a_program_that_fails_when_asked_is_broken(bin_folder: Path) -> None:
    fake(bin_folder, "tool", "exit 3")

    finding = check_program(TOOL)

    assert finding.state is State.BROKEN
    assert "status 3 when asked --version" in finding.found


@pytest.mark.parametrize(
    ("version", "least", "answer"),
    [("3.9", "3.10", True), ("3.10", "3.9", False), ("8", "8.0", False), ("8.0", "8", False), ("22.6.1", "22.6", False),
     ("21.12", "22.6", True), ("", "1", False), ("1", "", False)],
)  # fmt: skip
def test_versions_are_compared_number_by_number(version: str, least: str, answer: bool) -> None:
    assert older(version, least) is answer


# ---- TI ------------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("bin_folder")
def test_without_ti_s_tools_it_says_what_to_install_and_which_variable_to_set() -> None:
    compiler, library = ti.check_compiler(), ti.check_library()

    assert (compiler.state, library.state) == (State.MISSING, State.MISSING)
    assert "C2000ROOT" in compiler.next_step
    assert "C2000WARE_ROOT" in library.next_step


@pytest.mark.parametrize(("says", "state"), [("22.6.1.LTS", State.OK), ("21.6.0.LTS", State.OLD)])
@pytest.mark.usefixtures("bin_folder")
def test_the_compiler_below_its_variable_is_asked_for_its_version(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, says: str, state: State
) -> None:
    fake(tmp_path / "cgt/bin", "cl2000", f'[ "$1" = --compiler_revision ] && echo {says}')
    monkeypatch.setenv("C2000ROOT", str(tmp_path / "cgt"))

    assert ti.check_compiler().state is state


def test_a_compiler_on_the_path_alone_is_not_what_cmake_uses(bin_folder: Path) -> None:
    fake(bin_folder, "cl2000", "echo 22.6.1.LTS")

    finding = ti.check_compiler()

    assert finding.state is State.BROKEN
    assert finding.next_step == f"export C2000ROOT={bin_folder.parent}"


@pytest.mark.usefixtures("bin_folder")
def test_a_variable_that_leads_nowhere_is_shown_with_its_value(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("C2000ROOT", str(tmp_path / "a"))
    monkeypatch.setenv("C2000WARE_ROOT", str(tmp_path / "b"))

    assert ti.check_compiler().found == f"C2000ROOT = {tmp_path / 'a'}: no bin/cl2000"
    assert ti.check_library().found == f"C2000WARE_ROOT = {tmp_path / 'b'}: no driverlib/f2837xd"


def test_the_library_needs_its_header_and_a_release_build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("C2000WARE_ROOT", str(tmp_path))
    device = tmp_path / "driverlib/f2837xd"
    (device / "driverlib/ccs/Debug").mkdir(parents=True)
    assert "no device_support/f2837xd/common/include/driverlib.h" in ti.check_library().found

    (tmp_path / "device_support/f2837xd/common/include").mkdir(parents=True)
    (tmp_path / "device_support/f2837xd/common/include/driverlib.h").touch()
    assert "no driverlib/f2837xd/driverlib/sysctl.h" in ti.check_library().found

    (device / "driverlib/sysctl.h").touch()
    for name, word in ti.NEW_NAMES.items():
        (device / "driverlib" / name).write_text(f"typedef enum {{ {word} }} a_t;\n")
    (device / "driverlib/ccs/Debug/driverlib_eabi.lib").touch()
    assert "no Release" in ti.check_library().found

    (device / "driverlib/ccs/Release").mkdir()
    (device / "driverlib/ccs/Release/driverlib_eabi.lib").touch()
    assert ti.check_library().good
    assert "store neither parameters nor tables" in ti.check_library().found

    (tmp_path / ti.FLASH_API).parent.mkdir(parents=True)
    (tmp_path / ti.FLASH_API).touch()
    assert ti.check_library().found == str(device)


@pytest.mark.parametrize("name", ["spi.h", "gpio.h"])
def test_a_library_from_before_5_00_is_too_old_for_the_port(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("C2000WARE_ROOT", str(tmp_path))
    modules = tmp_path / "driverlib/f2837xd/driverlib"
    (modules / "ccs/Release").mkdir(parents=True)
    (modules / "ccs/Release/driverlib_eabi.lib").touch()
    (tmp_path / "device_support/f2837xd/common/include").mkdir(parents=True)
    (tmp_path / "device_support/f2837xd/common/include/driverlib.h").touch()
    (modules / "sysctl.h").touch()
    for other, word in ti.NEW_NAMES.items():
        (modules / other).write_text("SPI_MODE_MASTER\n" if other == name else f"{word}\n")

    finding = ti.check_library()

    assert finding.state is State.OLD
    assert f"{name}: no {ti.NEW_NAMES[name]}" in finding.found
    assert "5.00 or newer" in finding.next_step


# ---- Python and the library ----------------------------------------------------------------------------------------


def test_requirements_give_name_and_least_version() -> None:
    assert package.name_and_least("pydantic>=2") == ("pydantic", "2")
    assert package.name_and_least("gcovr>=8; extra == 'test'") == ("gcovr", "8")
    assert package.name_and_least("numpy") == ("numpy", "")


def test_a_package_is_missing_too_old_or_nothing_to_say() -> None:
    assert package.check_package("no-such-package-anywhere", "", Purpose.BUILD).state is State.MISSING
    assert package.check_package("numpy", "999", Purpose.BUILD).state is State.OLD
    assert package.check_package("numpy", "1", Purpose.BUILD) is None


def test_a_library_older_than_a_source_names_the_source(tmp_path: Path) -> None:
    library = tmp_path / "lib.so"
    source = tmp_path / "control/motor/pi.c"
    source.parent.mkdir(parents=True)
    source.touch()
    library.touch()
    for path in (source, source.parent, source.parent.parent):
        os.utime(path, (1000.0, 1000.0))
    os.utime(library, (2000.0, 2000.0))
    assert package.newer_source(tmp_path, library) is None

    os.utime(source, (3000.0, 3000.0))
    os.utime(source.parent, (3000.0, 3000.0))
    assert package.newer_source(tmp_path, library) == Path("control/motor/pi.c")

    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv/.installed").touch()  # setup has looked at it since
    assert package.newer_source(tmp_path, library) is None


# ---- the command ---------------------------------------------------------------------------------------------------


def everything(purpose: Purpose, state: State) -> list[Finding]:
    def one(p: Purpose) -> Finding:
        return Finding(f"tool for {p}", p, state if p is purpose else State.OK, "", "something", "a step")

    return [one(p) for p in Purpose]


@pytest.mark.parametrize(
    ("broken", "asked", "status"),
    [
        (Purpose.BUILD, "build", 1), (Purpose.TEST, "build", 0), (Purpose.CHIP, "build", 0),
        (Purpose.BUILD, "chip", 1), (Purpose.TEST, "chip", 0), (Purpose.CHIP, "chip", 1), (Purpose.TEST, "test", 1),
    ],
)  # fmt: skip
def test_the_exit_status_is_about_what_was_asked_for(
    evenspin: Callable[..., Said], monkeypatch: pytest.MonkeyPatch, broken: Purpose, asked: str, status: int
) -> None:
    monkeypatch.setattr("evenspin.doctor.run_checks", lambda: everything(broken, State.MISSING))

    said = evenspin("doctor", "--for", asked, "--json")

    assert said.status == status
    document = json.loads(said.out)
    assert document["ready"] is (status == 0)
    assert {f["purpose"]: f["state"] for f in document["findings"]}[broken.value] == "missing"
    assert "a step" in said.err


def test_with_nothing_on_the_path_every_program_is_missing_and_the_build_is_not_ready(
    evenspin: Callable[..., Said], bin_folder: Path
) -> None:
    said = evenspin("doctor", "--json")

    assert said.status == 1
    states = {f["name"]: f["state"] for f in json.loads(said.out)["findings"]}
    assert {states[program.names[0]] for program in PROGRAMS} == {"missing"}
    assert states["python"] == "ok"
    assert "gcc missing" in said.err

    for program in PROGRAMS:
        if program.purpose is Purpose.BUILD:
            fake(bin_folder, program.names[0], "echo version 99.1")
    states = {f["name"]: f["state"] for f in json.loads(evenspin("doctor", "--json").out)["findings"]}
    assert {states[p.names[0]] for p in PROGRAMS if p.purpose is Purpose.BUILD} == {"ok"}
    assert states["ruby"] == "missing"
