"""TI's compiler and library, where cmake/ti-c2000.cmake looks for them."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from evenspin.doctor.finding import Finding, Purpose, State, older, version_in
from evenspin.doctor.programs import ask

COMPILER_LEAST = "22.6"
COMPILER_FOR = "compiles for the F28379D"
LIBRARY_FOR = "driverlib, on which the port stands"
GET_COMPILER = "install TI C2000 code generation tools (ti.com, free) and set C2000ROOT to the folder with bin/cl2000"
GET_LIBRARY = (
    "install C2000Ware 5.00 or newer (ti.com, free) and set C2000WARE_ROOT to the folder with driverlib/f2837xd"
)
LIBRARY_LEAST = "5.00"
# Names that the port uses and that came with that version; hal/f28379d/CMakeLists.txt asks for the same.
MODULES = Path("driverlib/f2837xd/driverlib")
NEW_NAMES = {"spi.h": "SPI_MODE_CONTROLLER", "gpio.h": "GPIO_setControllerCore"}
# In the installer of C2000Ware, not in the clone of its core SDK; hal/f28379d/CMakeLists.txt builds without it, too.
FLASH_API = "libraries/flash_api/f2837xd/lib/F021_API_F2837xD_FPU32_EABI.lib"
HEADERS = ("device_support/f2837xd/common/include/driverlib.h", "driverlib/f2837xd/driverlib/sysctl.h")


def check_compiler() -> Finding:
    """cl2000 below C2000ROOT."""

    def finding(state: State, found: str, step: str = "") -> Finding:
        return Finding("cl2000", Purpose.CHIP, state, found, COMPILER_FOR, step)

    root = os.environ.get("C2000ROOT", "")
    if not root:
        path = shutil.which("cl2000")
        if path is None:
            return finding(State.MISSING, "C2000ROOT is not set", GET_COMPILER)
        return finding(State.BROKEN, f"{path}, but C2000ROOT is not set", f"export C2000ROOT={Path(path).parents[1]}")
    program = next((p for p in (Path(root, "bin", n) for n in ("cl2000", "cl2000.exe")) if p.is_file()), None)
    if program is None:
        return finding(State.MISSING, f"C2000ROOT = {root}: no bin/cl2000", GET_COMPILER)
    try:
        version = version_in(ask(str(program), "--compiler_revision"))
    except (OSError, subprocess.SubprocessError) as error:
        return finding(State.BROKEN, f"{program}: {error}", GET_COMPILER)
    if older(version, COMPILER_LEAST):
        return finding(State.OLD, version, f"install {COMPILER_LEAST} LTS or newer; tests have been made with none")
    return finding(State.OK, version or str(program))


def check_library() -> Finding:
    """The folders of driverlib below C2000WARE_ROOT that the build uses."""

    def finding(state: State, found: str, step: str = "") -> Finding:
        return Finding("C2000Ware", Purpose.CHIP, state, found, LIBRARY_FOR, step)

    root = os.environ.get("C2000WARE_ROOT", "")
    if not root:
        return finding(State.MISSING, "C2000WARE_ROOT is not set", GET_LIBRARY)
    device = Path(root, "driverlib", "f2837xd")
    if not device.is_dir():
        return finding(State.MISSING, f"C2000WARE_ROOT = {root}: no driverlib/f2837xd", GET_LIBRARY)
    for header in HEADERS:
        if not Path(root, header).is_file():
            return finding(State.BROKEN, f"{root}: no {header}", "install C2000Ware again, with device_support")
    for name, word in NEW_NAMES.items():
        path = Path(root) / MODULES / name
        if not path.is_file() or word not in path.read_text(encoding="utf-8", errors="replace"):
            found = f"{path}: no {word}, which came with {LIBRARY_LEAST}"
            return finding(State.OLD, found, f"install C2000Ware {LIBRARY_LEAST} or newer")
    if not any("Release" in path.parts for path in device.glob("**/*driverlib_eabi.lib")):
        step = "build driverlib with its project in ccs/, configuration Release (EABI)"
        return finding(State.BROKEN, f"{device}: no Release/driverlib_eabi.lib", step)
    if not Path(root, FLASH_API).is_file():
        return finding(State.OK, f"{device}; no {FLASH_API}: the drive will store neither parameters nor tables")
    return finding(State.OK, str(device))
