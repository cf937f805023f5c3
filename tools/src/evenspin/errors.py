"""User-facing errors, one line each: where, what was given, what is allowed, what to try next."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

SHOWN_CHARS = 60


class EvenspinError(Exception):
    """An error that is the answer to what the user asked; its text is one line."""

    exit_code = 2

    @property
    def bare(self) -> str:
        """The text without the command or option in front, for a page that shows it beside the control."""
        return str(self)


class NativeError(EvenspinError):
    """The compiled library is missing, does not fit, or refused a value."""


class CheckFailedError(EvenspinError):
    """The work was done and the result is not good enough."""

    exit_code = 1


@dataclass
class BlockError(EvenspinError, ValueError):
    """A control block refused a parameter."""

    field: str
    value: float | str
    limit: str

    def __str__(self) -> str:
        return f"{self.field} = {shown(self.value)}: {self.limit}"


@dataclass
class InputError(EvenspinError):
    """A file or an option is not what it has to be."""

    where: str | Path
    key: str
    value: object
    must: str
    hint: str
    line: int | None = None

    def __str__(self) -> str:
        place = str(self.where) if self.line is None else f"{self.where}:{self.line}"
        return one_line(f"{place}: {self._said}")

    @property
    def _said(self) -> str:
        return f"{self.key} = {shown(self.value)}: must be {self.must}; {self.hint}"

    @property
    def bare(self) -> str:
        return str(self) if isinstance(self.where, Path) else one_line(self._said)


class Missing:
    """Stands for a value that was not given."""

    def __repr__(self) -> str:
        return "(missing)"


MISSING = Missing()


def reason(error: BaseException) -> str:
    """Why something could not be read or written, in the words of the system."""
    if isinstance(error, OSError):
        return error.strerror or str(error)
    if isinstance(error, UnicodeDecodeError):
        return f"no text from octet {error.start} on"
    return str(error)


def one_line(text: str) -> str:
    return " ".join(text.split())


def shown(value: object) -> str:
    """The value as the user may have written it, short enough for a line; a path whole, to be copied."""
    if isinstance(value, Path):
        return f"'{one_line(''.join(c if c.isprintable() else '?' for c in str(value)))}'"
    try:
        text = str(value).lower() if isinstance(value, bool) else value if isinstance(value, str) else repr(value)
    except ValueError:  # an integer of thousands of digits
        text = "(a number of thousands of digits)"
    text = one_line("".join(c if c.isprintable() else "?" for c in text))
    text = f"'{text}'" if isinstance(value, str) else text
    return text if len(text) <= SHOWN_CHARS else f"{text[:SHOWN_CHARS]}..."


def did_you_mean(given: str, known: Iterable[str]) -> str:
    """A next step for a misspelt name."""
    known = list(known)
    close = difflib.get_close_matches(given, known, n=2, cutoff=0.6)
    if close:
        return f"did you mean {' or '.join(close)}?"
    return f"known: {', '.join(known)}" if len(known) <= 25 else f"{len(known)} names are known"
