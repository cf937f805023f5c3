"""The build for the chip, from configuration to link, with stand-ins for TI's compiler and library.

    check_c2000_build.py <root of the repository> <folder for the build>

What is shown: the preset, the toolchain file, the search for driverlib and the link command fit together; every call of
the tools, of the assembler and the linker, too, has the options of this chip; the interrupts' code is compiled for RAM;
nothing is missing at the link, in a debug build either, where driverlib calls back. The folders of compiler, library
and build have blanks in their names, one is given with backslashes. A library that is too old is refused.
What is not shown: that cl2000 takes it.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

HEADER = "device_support/f2837xd/common/include/driverlib.h"
MODULE = "driverlib/f2837xd/driverlib/sysctl.h"
ARCHIVE = "driverlib/f2837xd/driverlib/ccs/Release/driverlib_eabi.lib"
# cl2000 for this chip, from its guide: EABI, 32-bit float unit, trigonometric unit; for every kind of object.
EVERY_CALL = ["-v28", "-ml", "-mt", "--abi=eabi", "--float_support=fpu32", "--tmu_support=tmu0"]
EVERY_CALL += ["--cla_support=cla1", "--vcu_support=vcu2"]
COMPILED = [
    *EVERY_CALL,
    "--fp_mode=relaxed",
    "--gen_func_subsections=on",
]  # divisions on the TMU; unused functions left out
IN_RAM = ["current_isr.c", "speed_isr.c", "position.c", "protection.c", "timing.c", "pi.c", "svm.c", "repetitive.c"]
IN_FLASH = ["configure.c", "state_machine.c", "parameters.c"]


# What the header of driverlib does in a debug build: its functions call back.
ASSERTION = """
#ifdef DEBUG
extern void __error__(const char *filename, uint32_t line);
static void __attribute__((used)) driverlib_assertion(void) { __error__(__FILE__, __LINE__); }
#endif
"""
FLASH_API = "libraries/flash_api/f2837xd"
MODULES = {"sysctl.h": "", "spi.h": "SPI_MODE_CONTROLLER", "gpio.h": "GPIO_setControllerCore"}


def attempt(*words: str | Path, environment: dict[str, str]) -> tuple[int, str]:
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, env=environment, check=False)
    return done.returncode, done.stdout + done.stderr


def run(*words: str | Path, environment: dict[str, str]) -> str:
    status, said = attempt(*words, environment=environment)
    if status != 0:
        sys.exit(f"{' '.join(str(w) for w in words[:2])} failed:\n{said[-3000:]}")
    return said


def make_archive(tools: Path, header: str, archive: Path) -> None:
    """driverlib: its functions without their bodies, made for EABI."""
    names = sorted(set(re.findall(r"^\w[\w *]*?\b(\w+)\([^;{}]*\);", header, flags=re.MULTILINE)))
    source = archive.with_suffix(".asm")
    source.write_text("".join(f"        .global {name}\n{name}:\n" for name in names))
    made = archive.with_suffix(".obj")
    words = [tools / "bin/cl2000", *EVERY_CALL, "--compile_only", f"--asm_file={source}", f"--output_file={made}"]
    subprocess.run(words, check=True)
    subprocess.run(["ar", "rcs", archive, made], check=True)


def make_tree(root: Path, work: Path) -> dict[str, str]:
    """Folders of compiler and library, and the variables that lead to them."""
    shutil.rmtree(work, ignore_errors=True)
    tools, sdk = work / "TI tools/cgt", work / "C2000 ware"
    for folder in ("lib", "include"):
        (tools / folder).mkdir(parents=True)
    (tools / "lib/libc.a").touch()
    shutil.copy(root / "tests/hal/fake_driverlib/crc_tbl.h", tools / "include")
    shutil.copytree(root / "tests/hal/stand_in", tools / "bin")
    for file in (HEADER, MODULE, ARCHIVE):
        (sdk / file).parent.mkdir(parents=True, exist_ok=True)
    for name, text in MODULES.items():
        (sdk / MODULE).with_name(name).write_text(f"{text}\n")
    header = (root / "tests/hal/fake_driverlib/driverlib.h").read_text()
    (sdk / HEADER).write_text(header + ASSERTION)
    make_archive(tools, header, sdk / ARCHIVE)
    for folder in ("include", "lib"):
        (sdk / FLASH_API / folder).mkdir(parents=True)
    shutil.copy(root / "tests/hal/fake_driverlib/F021_F2837xD_C28x.h", sdk / FLASH_API / "include")
    (sdk / FLASH_API / "lib/F021_API_F2837xD_FPU32_EABI.lib").touch()
    # The stand-in runs hundreds of times, by the interpreter of this script: that of PATH may be a slow script itself.
    own = work / "python"
    own.mkdir()
    (own / "python3").symlink_to(Path(sys.executable).resolve())
    path = f"{own}{os.pathsep}{os.environ['PATH']}"
    return {
        **os.environ,
        "PATH": path,
        "C2000ROOT": str(tools).replace("/TI tools", "\\TI tools"),
        "C2000WARE_ROOT": str(sdk),
    }


def faults(calls: list[list[str]], memory: str) -> list[str]:
    found = []
    compiled = {Path(word).name: call for call in calls for word in call if word.startswith("--c_file=")}
    assembled = {Path(word).name: call for call in calls for word in call if word.startswith("--asm_file=")}
    if "codestart.asm" not in assembled:
        found.append("codestart.asm: is not assembled")
    for wanted, some in ((COMPILED, compiled), (EVERY_CALL, assembled)):
        for name, call in some.items():
            found += [f"{name}: made without {option}" for option in wanted if option not in call]
    for name in IN_RAM + IN_FLASH:
        if name not in compiled:
            found.append(f"{name}: is not compiled")
        elif ("--ramfunc=on" in compiled[name]) != (name in IN_RAM):
            found.append(f"{name}: is {'not ' if name in IN_RAM else ''}compiled for RAM")
    flash = "-D_FLASH" in compiled.get("system.c", []) or "--define=_FLASH" in compiled.get("system.c", [])
    if flash != (memory == "flash"):
        found.append(f"system.c: _FLASH is {'' if flash else 'not '}defined in a build for {memory}")
    api = any(word.endswith("EVENSPIN_FLASH_API") for word in compiled.get("storage.c", []))
    if api != (memory == "flash"):
        found.append(f"storage.c: the flash API is {'' if api else 'not '}used in a build for {memory}")
    links = [call for call in calls if "--run_linker" in call and any("evenspin" in word for word in call)]
    if len(links) != 1:
        return [*found, f"{len(links)} programs are linked, not one"]
    before = links[0][: links[0].index("--run_linker")]
    found += [f"the link has no {option} before --run_linker" for option in EVERY_CALL if option not in before]
    parts = [f"f28379d_{memory}.cmd", "codestart.asm.obj", "driverlib_eabi.lib", "libc.a"]
    if memory == "flash":
        parts += ["--define=EVENSPIN_FLASH_API=1", "flash_api/f2837xd/lib"]
    parts += ["libfirmware_float.a", "libcontrol_float.a", "libport_f28379d.a"]
    for wanted in (*parts, "--entry_point=code_start", "--reread_libs"):
        if not any(word.endswith(wanted) for word in links[0]):
            found.append(f"the link has no {wanted}")
    return found


def old_library_faults(build: Path, environment: dict[str, str]) -> list[str]:
    """Configuring with a C2000Ware before 5.00 ends with what to install."""
    found = []
    for name, word in MODULES.items():
        if word:
            header = (Path(environment["C2000WARE_ROOT"]) / MODULE).with_name(name)
            header.write_text("")
            status, said = attempt("cmake", "--preset", "c2000", "-B", build, environment=environment)
            said = " ".join(said.split())
            if status == 0 or word not in said or "5.00 or newer" not in said:
                found.append(f"a library without {word} is not refused with what to install:\n{said[-500:]}")
            header.write_text(f"{word}\n")
    return found


def main(arguments: list[str]) -> int:
    root, work = Path(arguments[0]).resolve(), Path(arguments[1]).resolve()
    environment = make_tree(root, work)
    build = work / "build of the chip"
    os.chdir(root)  # where the presets are
    found = []
    for memory, kind in (("flash", "RelWithDebInfo"), ("ram", "RelWithDebInfo"), ("flash", "Debug")):
        given = (f"-DEVENSPIN_C2000_MEMORY={memory}", f"-DCMAKE_BUILD_TYPE={kind}")
        run("cmake", "--preset", "c2000", "-B", build, *given, environment=environment)
        commands = run("ninja", "-C", build, "-t", "commands", environment=environment)
        calls = [shlex.split(line) for line in commands.splitlines()]
        found += [f"{memory}, {kind}: {fault}" for fault in faults(calls, memory)]
        if not found and kind == "Debug":  # its objects call all that the others call, and __error__
            run("cmake", "--build", build, environment=environment)
            made = ("**/evenspin_f28379d_float.out", "**/*.map")
            found += [f"the build leaves no {pattern}" for pattern in made if not any(build.glob(pattern))]
    found += old_library_faults(build, environment)
    shutil.rmtree(Path(environment["C2000WARE_ROOT"]) / FLASH_API)
    said = run("cmake", "--fresh", "--preset", "c2000", "-B", build, environment=environment)
    if "store neither parameters nor tables" not in " ".join(said.split()):
        found.append("a library without the flash API is not said to store nothing")
    print("\n".join(found) or "built for flash, for a debugger and for RAM")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
