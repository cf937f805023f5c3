"""The text of a log file, plain or compressed. Whatever the file is, the answer is its text or one line."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterator, Sequence
from io import BufferedIOBase
from pathlib import Path

from evenspin.errors import MISSING, InputError

MOST_BYTES = 256_000_000  # unpacked; documented in docs/log-format.md
META_BYTES = 1_000_000
BLOCK = 1 << 20  # bytes read at a time: what a small file unpacks to is known before memory is full of it
LINES_BLOCK = 1 << 23  # characters split into lines at a time
HINT = "`evenspin run` writes this format"


def read_text(path: Path, hint: str = HINT, most_bytes: int = MOST_BYTES, kind: str = "CSV") -> str:
    try:
        with _opened(path) as file:
            raw = _bounded(path, file, most_bytes)
        return raw.decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError(path, "file", MISSING, "an existing file", hint) from None
    except EOFError:
        raise InputError(path, "file", "(cut off)", "a complete .gz file", "copy it again") from None
    except (zlib.error, gzip.BadGzipFile) as error:
        raise InputError(path, "file", f"(damaged: {error})", "an undamaged .gz file", "copy it again") from None
    except UnicodeDecodeError as error:
        given = f"(byte {error.start} is no text)"
        raise InputError(path, "file", given, f"a readable {kind} file in UTF-8", hint) from None
    except OSError as error:
        raise InputError(path, "file", error.strerror or str(error), f"a readable {kind} file", hint) from None


def line_blocks(text: str, start: int = 0, first_line: int = 1) -> Iterator[tuple[int, Sequence[str]]]:
    """All lines from `start` on, some thousand at a time, each block with the number of its first line."""
    while start < len(text):
        end = text.find("\n", min(start + LINES_BLOCK, len(text) - 1))
        end = len(text) if end < 0 else end
        lines = text[start:end].split("\n")
        yield first_line, lines
        start, first_line = end + 1, first_line + len(lines)


def _opened(path: Path) -> BufferedIOBase:
    return gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb")


def _bounded(path: Path, file: BufferedIOBase, most_bytes: int) -> bytearray:
    raw = bytearray()
    while block := file.read(BLOCK):
        raw += block
        if len(raw) > most_bytes:
            given = f"more than {most_bytes / 1e6:g} MB" + (" unpacked" if path.suffix == ".gz" else "")
            hint = "cut it into parts, or leave out columns or rows that are not needed"
            raise InputError(path, "size", given, f"at most {most_bytes / 1e6:g} MB", hint)
    return raw
