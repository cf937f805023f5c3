"""Find and load the compiled library, one for each numeric. The C header beside it is its declaration."""

from __future__ import annotations

import functools
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evenspin.errors import NativeError, did_you_mean

NUMERICS = ("float", "fixed")
HEADER = "evenspin_capi.h"
SUPPORTED_ABI = 6
REINSTALL = "install the package again: make setup"


@dataclass(frozen=True, slots=True)
class Library:
    """A loaded library: `lib` has the functions of the header, `ffi` makes their arguments."""

    ffi: Any
    lib: Any
    path: Path
    numeric: str

    def text(self, pointer: Any) -> str:
        """A C string; NULL gives an empty one."""
        return self.ffi.string(pointer).decode() if pointer != self.ffi.NULL else ""


def load(numeric: str = "float") -> Library:
    """The library of this numeric, loaded once per process."""
    return _loaded(numeric)  # the cache takes load() and load("float") for two calls


@functools.cache
def _loaded(numeric: str) -> Library:
    from cffi import FFI

    if numeric not in NUMERICS:
        raise NativeError(f"numeric = {numeric!r}: must be float or fixed; {did_you_mean(numeric, NUMERICS)}")
    folder = library_folder(HEADER)
    path = _library_file(folder, numeric)
    ffi = FFI()
    try:
        ffi.cdef(declarations((folder / HEADER).read_text()))
        lib = ffi.dlopen(str(path))
        abi = lib.es_abi_version()
    except OSError as error:
        raise NativeError(f"{path}: cannot be loaded ({error}); {REINSTALL}") from None
    if abi != SUPPORTED_ABI:
        raise NativeError(f"{path}: interface {abi}, this package wants {SUPPORTED_ABI}; {REINSTALL}")
    library = Library(ffi, lib, path, numeric)
    if library.text(lib.es_numeric()) != numeric:
        raise NativeError(f"{path}: is built as {library.text(lib.es_numeric())}; {REINSTALL}")
    return library


def declarations(header: str) -> str:
    """The prototypes of a C header without its comments and preprocessor lines."""
    text = re.sub(r"/\*.*?\*/|//[^\n]*", " ", header, flags=re.DOTALL)
    text = re.sub(r"#\s*ifdef\s+__cplusplus.*?#\s*endif[^\n]*", "", text, flags=re.DOTALL)
    return "\n".join(line for line in text.splitlines() if not line.lstrip().startswith("#"))


def library_folder(header: str) -> Path:
    """evenspin/_lib, with this header in it; an editable installation keeps it in site-packages."""
    candidates = [Path(entry) / "_lib" for entry in sys.modules["evenspin"].__path__] + _installed_folders()
    for candidate in candidates:
        if (candidate / header).is_file():
            return candidate
    raise NativeError(f"evenspin/_lib/{header} is not installed; {REINSTALL}")


def _installed_folders() -> list[Path]:
    import site

    return [Path(entry) / "evenspin" / "_lib" for entry in [*sys.path, *site.getsitepackages()] if entry]


def _library_file(folder: Path, numeric: str) -> Path:
    for name in (f"libevenspin_{numeric}.so", f"libevenspin_{numeric}.dylib", f"evenspin_{numeric}.dll"):
        if (folder / name).is_file():
            return folder / name
    raise NativeError(f"{folder}/libevenspin_{numeric}.so is not installed; {REINSTALL}")
