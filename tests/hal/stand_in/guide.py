"""What cl2000 22.6 LTS takes, by its compiler guide, for its stand-in."""

from __future__ import annotations

import re
import sys

# Options of the guide that the build may use: a pattern for what stands behind the name.
OPTIONS = {
    "-v": "28", "-m": "[lt]", "--abi": "=(eabi|coffabi)", "--float_support": "=(softlib|fpu32|fpu64)",
    "--tmu_support": "=(tmu0|tmu1|none)", "--cla_support": "=(cla0|cla1|cla2)", "--vcu_support": "=(vcu0|vcu2|vcrc)",
    "--fp_mode": "=(strict|relaxed)", "--rpt_threshold": r"=(\d|[1-9]\d|1\d\d|2[0-4]\d|25[0-6])",
    "--gen_func_subsections": "=(on|off)", "--diag_warning": r"=\d+",
    "--diag_suppress": r"=\d+", "--display_error_number": "", "--define": "=.+", "-D": ".+", "--include_path": "=.+",
    "--opt_level": "=(off|[0-4])", "--opt_for_speed": "=[0-5]", "-g": "", "--symdebug:none": "",
    "--ramfunc": "=(on|off)",
    "--compile_only": "", "--c_file": "=.+", "--asm_file": "=.+", "--output_file": "=.+", "--c99": "",
    "--preproc_with_compile": "", "--preproc_dependency": "=.+", "--relaxed_ansi": "", "--strict_ansi": "",
    "--c11": "", "--c89": "",
}  # fmt: skip
LINKER_OPTIONS = {
    "--output_file": "=.+", "--map_file": "=.+", "--entry_point": r"=\w+", "--stack_size": "=0x[0-9A-Fa-f]+",
    "--heap_size": r"=\d+", "--rom_model": "", "--ram_model": "", "--reread_libs": "", "--search_path": "=.+",
    "--library": "=.+", "--warn_sections": "", "--define": "=.+", "--unused_section_elimination": "=(on|off)",
}  # fmt: skip
MACHINE = ("--abi=", "--float_support=", "--tmu_support=")


def refuse(reason: str) -> int:
    print(f"cl2000: fatal error: {reason}", file=sys.stderr)
    return 1


def value(words: list[str], option: str) -> str | None:
    return next((word.removeprefix(option) for word in words if word.startswith(option)), None)


def unknown(words: list[str], options: dict[str, str]) -> str | None:
    """The first option that the guide does not have, or not with that value."""
    for word in words:
        if word.startswith("-") and not any(
            re.fullmatch(re.escape(name) + rest, word) for name, rest in options.items()
        ):
            return word
    return None


def machine_of(words: list[str]) -> str:
    """What an object is made for; the linker takes only objects that agree."""
    abi = "eabi" if "--abi=eabi" in words else "coffabi"
    return f"{abi} {value(words, '--float_support=') or 'softlib'} {value(words, '--tmu_support=') or 'none'}"
