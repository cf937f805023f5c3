"""Where the truth about hidden effects is written: never among what is made to be solved."""

from __future__ import annotations

from pathlib import Path

from evenspin.errors import InputError


def place_of_truth(out: Path, truth: Path | None) -> Path:
    """The file of `--truth`, or one named after `out` beside it. A missing parent of `out` is made.

    Refuses a folder that holds something, and a truth inside of it.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError("--out", "folder", str(out), "new or empty", "choose another folder")
    place = truth or out.absolute().parent / f"{out.name}_truth.json"
    if place.absolute().is_relative_to(out.absolute()):
        raise InputError("--truth", "file", str(place), f"apart from {out}", "choose a place outside of --out")
    out.absolute().parent.mkdir(parents=True, exist_ok=True)
    return place
