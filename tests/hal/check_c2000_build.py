"""The build for the chip, from configuration to link, with stand-ins for TI's compiler and library.

    check_c2000_build.py <root of the repository> <folder for the build>

What is shown: the preset, the toolchain file, the search for driverlib and the link command fit together, and the
interrupts' code is compiled for RAM. The program in flash is built; of the one in RAM the commands are looked at.
What is not shown: that cl2000 takes it.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

HEADER = "device_support/f2837xd/common/include/driverlib.h"
MODULE = "driverlib/f2837xd/driverlib/sysctl.h"
ARCHIVE = "driverlib/f2837xd/driverlib/ccs/Release/driverlib_eabi.lib"
# cl2000 for this chip, from its guide: EABI, 32-bit float unit, trigonometric unit, divisions on it.
EVERY_CALL = ["-v28", "--abi=eabi", "--float_support=fpu32", "--tmu_support=tmu0", "--fp_mode=relaxed"]
IN_RAM = ["current_isr.c", "speed_isr.c", "position.c", "protection.c", "timing.c", "pi.c", "svm.c", "repetitive.c"]
IN_FLASH = ["configure.c", "state_machine.c", "parameters.c"]


def run(*words: str | Path, environment: dict[str, str]) -> str:
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, env=environment, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(str(w) for w in words[:2])} failed:\n{(done.stdout + done.stderr)[-3000:]}")
    return done.stdout


def make_tree(root: Path, work: Path) -> dict[str, str]:
    """Folders of compiler and library, and the variables that lead to them."""
    shutil.rmtree(work, ignore_errors=True)
    (work / "cgt/lib").mkdir(parents=True)
    shutil.copytree(root / "tests/hal/stand_in", work / "cgt/bin")
    for file in (HEADER, MODULE, ARCHIVE):
        (work / "sdk" / file).parent.mkdir(parents=True, exist_ok=True)
    (work / "sdk" / MODULE).touch()
    shutil.copy(root / "tests/hal/fake_driverlib/driverlib.h", work / "sdk" / HEADER)
    subprocess.run(["ar", "rcs", work / "sdk" / ARCHIVE], check=True)
    return {
        **os.environ,
        "C2000ROOT": str(work / "cgt"),
        "C2000WARE_ROOT": str(work / "sdk"),
    }


def faults(calls: list[list[str]], memory: str) -> list[str]:
    found = []
    compiled = {Path(word).name: call for call in calls for word in call if word.startswith("--c_file=")}
    for name, call in compiled.items():
        found += [f"{name}: compiled without {option}" for option in EVERY_CALL if option not in call]
    for name in IN_RAM + IN_FLASH:
        if name not in compiled:
            found.append(f"{name}: is not compiled")
        elif ("--ramfunc=on" in compiled[name]) != (name in IN_RAM):
            found.append(f"{name}: is {'not ' if name in IN_RAM else ''}compiled for RAM")
    flash = "-D_FLASH" in compiled.get("system.c", []) or "--define=_FLASH" in compiled.get("system.c", [])
    if flash != (memory == "flash"):
        found.append(f"system.c: _FLASH is {'' if flash else 'not '}defined in a build for {memory}")
    links = [call for call in calls if "--run_linker" in call and any("evenspin" in word for word in call)]
    if len(links) != 1:
        return [*found, f"{len(links)} programs are linked, not one"]
    parts = [f"f28379d_{memory}.cmd", "codestart.asm.obj", "driverlib_eabi.lib", "libc.a"]
    parts += ["libfirmware_float.a", "libcontrol_float.a", "libport_f28379d.a"]
    for wanted in (*parts, "--entry_point=code_start", "--reread_libs"):
        if not any(word.endswith(wanted) for word in links[0]):
            found.append(f"the link has no {wanted}")
    return found


def main(arguments: list[str]) -> int:
    root, work = Path(arguments[0]).resolve(), Path(arguments[1]).resolve()
    environment = make_tree(root, work)
    build = work / "build"
    os.chdir(root)  # where the presets are
    found = []
    for memory in ("flash", "ram"):
        run("cmake", "--preset", "c2000", "-B", build, f"-DEVENSPIN_C2000_MEMORY={memory}", environment=environment)
        commands = run("ninja", "-C", build, "-t", "commands", environment=environment)
        found += [f"{memory}: {fault}" for fault in faults([line.split() for line in commands.splitlines()], memory)]
        if memory == "flash":
            run("cmake", "--build", build, environment=environment)
            made = ("**/evenspin_f28379d_float.out", "**/*.map")
            found += [f"the build leaves no {pattern}" for pattern in made if not any(build.glob(pattern))]
    print("\n".join(found) or "built for flash, and the commands for RAM are right")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
