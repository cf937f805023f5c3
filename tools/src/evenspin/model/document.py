"""Read a TOML file, remember where its keys are, and say what is wrong with it in one line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.errors import MISSING, InputError
from evenspin.model.toml_lines import key_lines

MAX_BYTES = 1_000_000


@dataclass(frozen=True, slots=True)
class Document:
    """The values of a file and the line of each key."""

    path: Path
    data: dict[str, Any]
    lines: dict[tuple[str | int, ...], int]

    def line_of(self, keys: Sequence[str | int]) -> int:
        """Line of this key; of the table around it if it is not there."""
        keys = tuple(keys)
        while keys and keys not in self.lines:
            keys = keys[:-1]
        return self.lines.get(keys, 1)

    def value_of(self, keys: Sequence[str | int]) -> object:
        found: Any = self.data
        for key in keys:
            try:
                found = found[key]
            except (KeyError, IndexError, TypeError):
                return MISSING
        return found

    def with_values(self, values: Mapping[str, Any]) -> Document:
        """The same file with other values, as if they were written in it; tables are merged."""
        return replace(self, data=_merged(self.data, values))

    def error(self, keys: Sequence[str | int], must: str, hint: str) -> InputError:
        """The one line about this key."""
        name = ".".join(str(key) for key in keys if not isinstance(key, int))
        where, line = (self.path, self.line_of(keys)) if self.lines else (self.path.name, None)  # it stands in no file
        return InputError(where, name, self.value_of(keys), must, hint, line)


def document_of(data: Mapping[str, Any], name: str, beside: Path) -> Document:
    """What stands in no file, with the keys and values of TOML. `beside`: where file names in it start from."""
    return Document(beside / f"({name})", _merged({}, data), {})


def _merged(data: Any, values: Any) -> Any:
    """Tables key by key where both have them; else what is new. Numbers of NumPy become those of Python."""
    if isinstance(values, Mapping):
        before = data if isinstance(data, Mapping) else {}
        return {**before, **{key: _merged(before.get(key), value) for key, value in values.items()}}
    if isinstance(values, list | tuple):
        return [_merged(None, value) for value in values]
    return values.item() if isinstance(values, np.generic) else values


def read_document(path: Path) -> Document:
    """Read and parse; whatever the file is, the answer is a document or an InputError."""

    def refuse(key: str, value: object, must: str, hint: str, line: int | None = None) -> InputError:
        return InputError(path, key, value, must, hint, line)

    try:
        size = path.stat().st_size
        if not path.is_file():
            raise refuse("file", "not a file", "a TOML file", "give the name of a file")
        if size > MAX_BYTES:
            raise refuse("size", f"{size} bytes", f"at most {MAX_BYTES} bytes", "is this the right file?")
        raw = path.read_bytes()
    except FileNotFoundError:
        raise refuse("file", MISSING, "an existing file", "check the name") from None
    except (OSError, ValueError) as error:
        raise refuse("file", getattr(error, "strerror", None) or str(error), "readable", "check the name") from None
    try:
        text = raw.decode().removeprefix("\ufeff").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise refuse("byte", f"0x{raw[error.start]:02x}", "UTF-8 text", "is this the right file?", line) from None
    if not text.strip():
        hint = "`evenspin scenarios`, `models` and `motor new` write one to begin with"
        raise refuse("file", "(empty)", "a TOML file with keys", hint, 1)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _syntax_error(path, text, str(error)) from None
    except (RecursionError, ValueError) as error:
        must = "TOML without such nesting or numbers"
        raise refuse("file", str(error), must, "is this the right file?") from None
    return Document(path, data, key_lines(text))


def _syntax_error(path: Path, text: str, message: str) -> InputError:
    found = re.search(r"\(at line (\d+), column (\d+)\)", message)
    reason = re.sub(r"\s*\(at [^)]*\)$", "", message)
    lines = text.split("\n")
    line = int(found[1]) if found else len(lines)
    content = lines[line - 1].strip() if line <= len(lines) else ""
    return InputError(path, "text", content, f"TOML ({reason})", "correct this line", line)
