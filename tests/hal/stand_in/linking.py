"""The link of the stand-in for cl2000."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from guide import LINKER_OPTIONS, machine_of, refuse, unknown, value

# Symbols that a C program for this chip gets from run-time library, linker and driverlib, not from its objects.
RUN_TIME = {"_c_int00", "IER", "IFR", "memcpy", "memcmp", "memset", "memmove", "strcmp", "strlen"}
SYMBOL_IN_COMMAND_FILE = re.compile(
    r"(?:LOAD|RUN)_(?:START|SIZE|END)\((\w+)\)|crc_table\((\w+)|^\s*(\w+)\s*=", re.MULTILINE
)
ALGORITHMS = ("CRC32_PRIME", "CRC16_802_15_4", "CRC16_ALT", "CRC8_PRIME")  # of crc_tbl.h


def objects_of(words: list[str], folder: Path) -> list[Path]:
    """The objects of the link, those in archives taken out."""
    found = []
    for word in words:
        path = Path(word).resolve()
        if path.suffix in (".a", ".lib"):
            inside = folder / path.name
            inside.mkdir(parents=True, exist_ok=True)
            subprocess.run(["ar", "x", path], cwd=inside, check=True)
            found += sorted(inside.iterdir())
        else:
            found.append(path)
    return found


def made_for(parts: list[Path]) -> dict[str, str]:
    """For what each object was made."""
    dump = subprocess.run(["readelf", "-p", ".made_for", *parts], capture_output=True, text=True, check=False).stdout
    found: dict[str, str] = {}
    name = str(parts[0])
    for line in dump.splitlines():
        if line.startswith("File: "):
            name = line.removeprefix("File: ")
        elif row := re.match(r"\s+\[\s*0\]\s+(.*)", line):
            found[name] = row[1]
    return found


def symbols(parts: list[Path], *options: str) -> set[str]:
    done = subprocess.run(["nm", *options, *parts], capture_output=True, text=True, check=True)
    lines = (line for line in done.stdout.splitlines() if line.strip() and not line.endswith(":"))
    return {line.split()[-1] for line in lines}


def link(words: list[str]) -> int:
    """Everything that is named must be there, agree, and be complete."""
    at = words.index("--run_linker")
    machine, words = machine_of(words[:at]), words[at + 1 :]
    if bad := unknown(words, LINKER_OPTIONS):
        return refuse(f'unrecognized option or value "{bad}"')
    inputs = [word for word in words if not word.startswith("--")]
    for word in inputs:
        if not Path(word).is_file():
            return refuse(f'cannot find file "{word}"')
    places = [Path(word.removeprefix("--search_path=")) for word in words if word.startswith("--search_path=")]
    for name in (word.removeprefix("--library=") for word in words if word.startswith("--library=")):
        if not any((place / name).is_file() for place in places):
            return refuse(f'cannot find library "{name}"')
    out = Path(value(words, "--output_file="))
    parts = objects_of(
        [w for w in inputs if w.endswith((".obj", ".o", ".a", ".lib"))], out.parent / f"{out.name}.parts"
    )
    made = made_for(parts)
    for part in parts:
        if (other := made.get(str(part))) != machine:
            return refuse(
                f'"{part.name}" is made for "{other}", the link for "{machine}": object files of different ABIs'
            )
    defined = symbols(parts, "--defined-only")
    wanted = {value(words, "--entry_point=") or "_c_int00"} | symbols(parts, "--undefined-only")
    for name in re.findall(r"\{[^}]*-l (\S+\.lib)", "".join(Path(w).read_text() for w in inputs if w.endswith(".cmd"))):
        if "--define=EVENSPIN_FLASH_API=1" in words:
            if not any((place / name).is_file() for place in places):
                return refuse(f'cannot find library "{name}"')
            defined |= {symbol for symbol in wanted if symbol.startswith("Fapi_")}
    for word in inputs:
        if word.endswith(".cmd"):
            text = re.sub(r"/\*.*?\*/", "", Path(word).read_text(), flags=re.DOTALL)
            for algorithm in re.findall(r"crc_table\(\w+, algorithm=(\w+)\)", text):
                if algorithm not in ALGORITHMS:
                    return refuse(f'"{word}": there is no CRC algorithm {algorithm}')
            defined |= {name for pair in SYMBOL_IN_COMMAND_FILE.findall(text) for name in pair if name}
    if missing := sorted(wanted - defined - RUN_TIME - {"_GLOBAL_OFFSET_TABLE_"}):
        return refuse(f"unresolved symbols remain: {', '.join(missing)}")
    Path(value(words, "--map_file=")).write_text("")
    out.write_text(f"{machine}\n")
    return 0
