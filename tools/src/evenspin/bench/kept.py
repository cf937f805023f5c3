"""Recordings grow beside the place where they end up, and stay there until that place is complete. So whatever goes
wrong, what was recorded is in a file, and the message says in which, and how it becomes a CSV."""

from __future__ import annotations

import contextlib
import shlex
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from evenspin.bench.raw import rows_in
from evenspin.errors import EvenspinError, InputError
from evenspin.output.origin import absolute

RAW = ".raw.mcap"  # of one recording: NAME.raw.mcap
FOLDER = ".raw"  # of a list of experiments: NAME.raw/EXPERIMENT.mcap
INTERRUPTED = 130  # exit status


class KeptError(EvenspinError):
    """Something went wrong after something was recorded. The exit status is that of what went wrong."""

    def __init__(self, text: str, exit_code: int) -> None:
        super().__init__(text)
        self.exit_code = exit_code


def beside(out: Path, ending: str) -> Path:
    """Where what is recorded for this output grows."""
    place = out if out.name not in ("", "..") else absolute(out)
    name = place.name
    for suffix in (".gz", ".csv"):
        name = name.removesuffix(suffix) if ending == RAW else name
    return place.parent / f"{name}{ending}"


def convert_command(raw: Path) -> str:
    """The command that makes a CSV of it."""
    name, place = raw.name.removesuffix(".mcap").removesuffix(".raw"), raw.parent
    if place.name.endswith(FOLDER):  # beside the folder, which only holds recordings
        name, place = f"{place.name.removesuffix(FOLDER)}-{name}", place.parent
    return f"`evenspin bench convert {shlex.quote(str(raw))} --out {shlex.quote(str(place / f'{name}.csv'))}`"


def where_it_is(raws: Sequence[Path]) -> str:
    """For the end of a message; empty when nothing was recorded."""
    held = [(raw, rows) for raw in raws if (rows := rows_in(raw))]
    if not held:
        return ""
    raw, rows = held[-1]
    others = f", and {len(held) - 1} more beside it" if len(held) > 1 else ""
    return f"what was recorded is kept, {rows} rows in {raw}{others}: {convert_command(raw)} makes a CSV of it"


def recordings_in(place: Path) -> list[Path]:
    """A file, or the recordings in a folder, in the order in which they were begun."""
    if place.is_dir():
        return sorted(place.glob("*.mcap"), key=lambda path: path.stat().st_mtime_ns)
    return [place] if place.is_file() else []


def refuse_rescued(place: Path, force: bool) -> None:
    """What a recording that broke off has left is not written over. What holds no row is nothing, and goes."""
    held = [raw for raw in recordings_in(place) if rows_in(raw)]
    if held and not force:
        raise InputError(
            "--out", "recording", held[0], "converted and moved away first",
            f"it holds {rows_in(held[0])} rows of a recording that broke off: {convert_command(held[0])} makes a CSV "
            "of it; or choose another name, or replace it with --force",
        )  # fmt: skip
    if place.is_symlink() or (place.exists() and not _is_ours(place)):
        raise InputError("--out", "recording", place, "free for the raw recording", "choose another name")


@contextlib.contextmanager
def room_for(place: Path) -> Iterator[None]:
    """What `refuse_rescued` has let pass is moved away while something new is recorded there. It is removed when that
    holds a row; else it comes back."""
    replaced = place.with_name(f".{place.name}.replaced")
    if place.exists():
        _away(replaced)
        place.rename(replaced)
    try:
        yield
    finally:
        if replaced.exists() and any(rows_in(raw) for raw in recordings_in(place)):
            _away(replaced)
        elif replaced.exists():
            _away(place)
            replaced.rename(place)


def _away(place: Path) -> None:
    if place.is_dir():
        shutil.rmtree(place)
    else:
        place.unlink(missing_ok=True)


def _is_ours(place: Path) -> bool:
    """A folder of raw recordings and nothing else, or a raw recording that never had a row."""
    if place.is_dir():
        return all(path.suffix == ".mcap" and path.is_file() for path in place.iterdir())
    return place.stat().st_size == 0 or place.open("rb").read(5) == b"\x89MCAP"


@contextlib.contextmanager
def keeping(place: Path, also: Callable[[], str] = str) -> Iterator[None]:
    """An error in this block says where the recording is. `also`: another source of what is not in a file."""
    try:
        yield
    except (EvenspinError, OSError, KeyboardInterrupt) as error:
        where = where_it_is(recordings_in(place)) or also()
        if not where and not isinstance(error, OSError):
            raise
        text = "; ".join(part for part in (_text(error), where) if part)
        raise KeptError(text, _status(error)) from error


def _text(error: BaseException) -> str:
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, OSError):
        place = f"{error.filename}: " if error.filename else ""
        return f"{place}{error.strerror or error}"
    return str(error)


def _status(error: BaseException) -> int:
    return INTERRUPTED if isinstance(error, KeyboardInterrupt) else getattr(error, "exit_code", 2)
