"""Check that the layers stay layers, and that code for the chip stays code for the chip.

    check_layers.py <root of the repository>

Every violation is printed as `file:line: rule`. Exit status: 0 none, 1 some, 2 there was nothing to check.

Inside    Services do not look inside the drive.
Layers    A folder includes only what LAYERS allows it to; a header of ours is named from the root.
Target    In TARGET_FOLDERS nothing stands that the C28x does not have or cannot afford: types of 8 bits, double and
          what silently calculates in double, the heap, and the library's slow functions.
Ports     Every folder of hal/ but include/ is the port of a board, under both rules from its first file on; it knows
          the contract, itself and the vendor's headers of VENDOR; only its program, firmware/main_<port>.c, knows it.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

SUFFIXES = frozenset({".c", ".h", ".def"})

FREESTANDING = frozenset({"stdint.h", "stdbool.h", "stddef.h", "math.h", "float.h", "limits.h"})
STANDARD = FREESTANDING | {
    "assert.h", "complex.h", "ctype.h", "errno.h", "inttypes.h", "signal.h", "stdarg.h", "stdio.h", "stdlib.h",
    "string.h", "time.h",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Layer:
    """What the files of a folder may include."""

    folder: str
    own: tuple[str, ...]  # folders of ours, from the root
    system: frozenset[str] | None  # headers in <>; None: any
    vendor: frozenset[str] = frozenset()  # quoted headers that are not ours, such as a chip's driver library
    closed: tuple[str, ...] = ()  # folders below `own` that stay closed
    port: str | None = None  # the one port, a folder of hal/, that it may know


# Quoted headers that are not ours, for the port of each board that needs some.
VENDOR = {"f28379d": frozenset({"driverlib.h", "device.h", "F021_F2837xD_C28x.h", "crc_tbl.h"})}

# The first folder that a file is in decides.
LAYERS = (
    Layer("control", ("control",), FREESTANDING),
    Layer("hal/include", ("hal",), FREESTANDING),
    Layer("hal", ("hal",), None),  # files of a port are in PORT_FILE
    Layer("firmware/link", ("firmware/link",), FREESTANDING),
    Layer("firmware/storage", ("firmware/storage", "firmware/link", "hal"), FREESTANDING),
    Layer(
        "firmware/app",
        ("control", "hal", "firmware"),
        FREESTANDING | {"string.h"},
        closed=("firmware/link", "firmware/services"),
    ),
    Layer("firmware/services", ("control", "hal", "firmware"), FREESTANDING | {"string.h"}),
    Layer("firmware", ("control", "hal", "firmware"), FREESTANDING | {"string.h"}),
    Layer("sim_host/plant", ("sim_host/plant", "sim_host/effects"), STANDARD),
    Layer("sim_host/effects", ("sim_host/plant", "sim_host/effects"), STANDARD),
    Layer("sim_host/trace", ("hal", "sim_host/trace"), STANDARD),
    Layer("sim_host/replay", ("control", "hal", "firmware", "sim_host/trace", "sim_host/replay"), STANDARD),
    Layer("sim_host/board", ("control", "hal", "firmware", "sim_host"), None, closed=("sim_host/referee",)),
    Layer("sim_host/capi", ("control", "hal", "firmware", "sim_host"), None, closed=("sim_host/referee",)),
    Layer(
        "sim_host/fmu",
        ("control", "hal", "firmware", "sim_host"),
        None,
        vendor=frozenset({"fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"}),
        closed=("sim_host/referee",),
    ),
    Layer("sim_host/referee", ("sim_host/referee",), STANDARD),  # shares nothing with what it judges
    Layer("sim_host", ("control", "sim_host"), None, closed=("sim_host/referee",)),
)
OUR_FOLDERS = frozenset({"control", "hal", "firmware", "sim_host", "tests", "tools"})
TARGET_FOLDERS = ("control", "firmware", "hal")

PORT_FILE = re.compile(r"hal/(?!include/)(?P<port>[^/]+)/.")
PORT_PROGRAM = re.compile(r"firmware/main_(?P<port>\w+)\.c")

DOUBLE_MATH = (
    "acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs fdim floor fma "
    "fmax fmin fmod frexp hypot ldexp lgamma llrint llround log log10 log1p log2 logb lrint lround modf nearbyint pow "
    "remainder rint round sin sinh sqrt tan tanh tgamma trunc"
).split()
SLOW_MATH = (
    "acosf acoshf asinf asinhf atanf atan2f atanhf cbrtf cosf coshf erff erfcf expf exp2f expm1f fmodf hypotf lgammaf "
    "logf log10f log1pf log2f powf remainderf sinf sinhf sqrtf tanf tanhf tgammaf"
).split()

POISON = (
    (re.compile(r"\bu?int(?:_least|_fast)?8_t\b"), "the C28x has no type of 8 bits"),
    (re.compile(r"\bdouble\b"), "no double on the chip"),
    (re.compile(r"\b(?:malloc|calloc|realloc|free)\s*\("), "no heap"),
    (re.compile(rf"\b(?:{'|'.join(DOUBLE_MATH)})\s*\("), "this function of libm calculates in double"),
    (re.compile(rf"\b(?:{'|'.join(SLOW_MATH)})\s*\("), "this function of libm costs too much; see control/numeric"),
)
# What a folder does not touch: the members of an object that has functions.
INSIDE = (
    ("firmware/services", re.compile(r"\b(?:d|drive)->\w+"), "the drive is asked through firmware/app/status.h"),
    ("firmware/main_", re.compile(r"\bdrive(?:\.|->)\w+"), "the drive is asked through firmware/app/status.h"),
)
# A decimal literal with a point or an exponent. Not: the middle of a name, of a hexadecimal number.
DECIMAL = re.compile(r"(?<![\w.])(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][+-]?\d+)?(?P<suffix>\w*)")

TOKEN = re.compile(
    r"""(?P<comment>/\*.*?(?:\*/|\Z)|//(?:\\\n|[^\n])*)|(?P<literal>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')""",
    re.DOTALL,
)
INCLUDE = re.compile(r"^[ \t]*#[ \t]*include[ \t]*(?P<what>.*?)[ \t]*$", re.MULTILINE)


def blank(text: str) -> str:
    """Spaces in place of everything but line ends, so that what follows keeps its line."""
    return re.sub(r"[^\n]", " ", text)


def without_comments(source: str) -> str:
    return TOKEN.sub(lambda token: token[0] if token["literal"] else blank(token[0]), source)


def without_comments_and_literals(source: str) -> str:
    return TOKEN.sub(lambda token: blank(token[0]), source)


def is_below(path: str, folder: str) -> bool:
    return path.startswith(folder + "/")


def include_fault(layer: Layer, what: str) -> str | None:
    """What is wrong with `#include <what>` in a layer, or None."""
    if what.startswith("<") and what.endswith(">"):
        if layer.system is None or what[1:-1] in layer.system:
            return None
        return f"{layer.folder}/ does not include {what}"
    if not (len(what) > 2 and what.startswith('"') and what.endswith('"')):
        return f"an include names its file: {what}"
    path = what[1:-1]
    if ".." in path.split("/"):
        return f"a header of ours is named from the root: {what}"
    port = PORT_FILE.match(path)
    closed = any(is_below(path, folder) for folder in layer.closed) or (port is not None and port["port"] != layer.port)
    if not closed and any(is_below(path, folder) for folder in layer.own):
        return None
    if path.split("/")[0] in OUR_FOLDERS:
        return f"{layer.folder}/ does not include {what}"
    return None if path in layer.vendor else f"a header of ours is named from the root: {what}"


def layer_of(path: str) -> Layer | None:
    """The layer that a file is in, given its path from the root; None for a file of no layer."""
    if match := PORT_FILE.match(path):
        port = match["port"]
        system = FREESTANDING | {"string.h"}
        return Layer(f"hal/{port}", ("hal",), system, vendor=VENDOR.get(port, frozenset()), port=port)
    layer = next((layer for layer in LAYERS if is_below(path, layer.folder)), None)
    if layer is not None and (program := PORT_PROGRAM.fullmatch(path)):
        return replace(layer, port=program["port"])
    return layer


def violations(path: str, source: str) -> Iterator[tuple[int, str]]:
    """Line and rule of everything in a file, given its path from the root, that should not be there."""
    layer = layer_of(path)
    if layer is not None:
        text = without_comments(source)
        for match in INCLUDE.finditer(text):
            fault = include_fault(layer, match["what"])
            if fault is not None:
                yield text.count("\n", 0, match.start()) + 1, fault

    for start, pattern, rule in INSIDE:
        if path.startswith(start):
            for number, line in enumerate(without_comments_and_literals(source).splitlines(), start=1):
                for match in pattern.finditer(line):
                    yield number, f"{match[0]}: {rule}"

    if any(is_below(path, folder) for folder in TARGET_FOLDERS):
        text = without_comments_and_literals(source)
        for number, line in enumerate(text.splitlines(), start=1):
            for pattern, rule in POISON:
                for match in pattern.finditer(line):
                    yield number, f"{match[0].rstrip(' (')}: {rule}"
            for match in DECIMAL.finditer(line):
                if match["suffix"] not in ("f", "F"):
                    yield number, f"{match[0]}: a float literal ends in f"


def source_files(root: Path) -> list[Path]:
    tops = sorted({layer.folder.split("/")[0] for layer in LAYERS})
    files = (file for top in tops for file in (root / top).rglob("*"))
    return sorted(file for file in files if file.suffix in SUFFIXES and file.is_file())


def main(arguments: list[str]) -> int:
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    root = Path(arguments[0])
    files = source_files(root)
    if not files:
        print(f"check_layers: no source files below {root}", file=sys.stderr)
        return 2
    count = 0
    for file in files:
        path = file.relative_to(root).as_posix()
        for line, rule in sorted(violations(path, file.read_text(encoding="utf-8"))):
            print(f"{path}:{line}: {rule}")
            count += 1
    print(f"check_layers: {len(files)} files, {count} violations")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
