"""Read a table from whatever file it is in: the content decides, then the ending of the name."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path

from evenspin.errors import MISSING, InputError
from evenspin.importer import binary
from evenspin.importer.delimited import Progress, read_delimited
from evenspin.importer.table import RawTable

MOST_ROWS_HINT = "docs/import.md says which files can be read"

# First octets of a file, and who reads it.
MAGIC: tuple[tuple[bytes, Callable[[Path], RawTable]], ...] = (
    (b"PAR1", binary.read_parquet),
    (b"MDF     ", binary.read_mdf),
    (b"UnFinMF ", binary.read_mdf),
    (b"TDSm", binary.read_tdms),
    (b"\x89MCAP0\r\n", binary.read_mcap),
    (b"MATLAB 5.0 MAT-file", binary.read_mat),
    (b"MATLAB 7.3 MAT-file", binary.read_mat),
    (b"\x89HDF\r\n\x1a\n", binary.read_mat),
    (b"\x93NUMPY", binary.read_npy),
)
BY_SUFFIX: dict[str, Callable[[Path], RawTable]] = {
    ".mat": binary.read_mat,
    ".npz": binary.read_npy,
    ".npy": binary.read_npy,
    ".parquet": binary.read_parquet,
    ".mf4": binary.read_mdf,
    ".mdf": binary.read_mdf,
    ".dat": binary.read_mdf,
    ".tdms": binary.read_tdms,
    ".mcap": binary.read_mcap,
}
NOT_TABLES = {".xlsx": "save it as CSV", ".xls": "save it as CSV", ".zip": "unpack it", ".7z": "unpack it"}


def read_table(path: Path, progress: Progress | None = None) -> RawTable:
    """Read a file; whatever it is, the answer is a table with at least two rows, or an InputError."""
    if path.is_dir():
        raise InputError(
            path, "file", "(a folder)", "a file", "a folder with meta.json is a case: `evenspin gap CASE_DIR`"
        )
    if path.suffix.lower() in NOT_TABLES:
        raise InputError(path, "file", path.suffix, "a text table or a log file", NOT_TABLES[path.suffix.lower()])
    start = _start_of(path)
    if not start:
        raise InputError(path, "file", "(empty)", "a table of numbers", MOST_ROWS_HINT)
    reader = next((reader for magic, reader in MAGIC if start.startswith(magic)), None)
    if reader is None and b"\0" in start[:4096]:
        reader = BY_SUFFIX.get(path.suffix.lower())
    table = reader(path) if reader is not None else read_delimited(path, progress)
    if len(table) < 2:
        raise InputError(path, "rows", len(table), "at least 2", MOST_ROWS_HINT)
    return table


def read_head(path: Path) -> str:
    """The first characters of a file, whatever it is."""
    return _start_of(path).decode("utf-8-sig", errors="replace")


def _start_of(path: Path) -> bytes:
    try:
        with gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb") as file:
            return file.read(4096)
    except FileNotFoundError:
        raise InputError(path, "file", MISSING, "an existing file", MOST_ROWS_HINT) from None
    except (EOFError, gzip.BadGzipFile) as error:
        raise InputError(path, "file", f"(damaged: {error})", "an undamaged .gz file", "copy it again") from None
    except OSError as error:
        raise InputError(path, "file", error.strerror or str(error), "a readable file", MOST_ROWS_HINT) from None
