"""Which evenspin this is: version, commit and its date, as they stand beside every output."""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path

BAKED = Path("_lib") / "build.json"  # of an installed package; the build writes it
GIT_S = 5.0


@dataclass(frozen=True, slots=True)
class Build:
    """`commit` and `date` (of the commit, ISO 8601) are None where nobody knows them, such as in a source archive.
    `+changes` behind the commit: files of the checkout had been changed."""

    version: str
    commit: str | None
    date: str | None

    def __str__(self) -> str:
        where = f"commit {self.commit}, {self.date}" if self.commit else "commit not known"
        return f"evenspin {self.version} ({where})"

    def as_json(self) -> dict[str, str | None]:
        return {"version": self.version, "commit": self.commit, "commit_date": self.date}


@cache
def build() -> Build:
    """Of the checkout that runs, or else as it was when the package was built."""
    package = Path(__file__).resolve().parent
    commit, date = _of_checkout(package.parents[2]) or _baked(package) or (None, None)
    return Build(version(), commit, date)


def version() -> str:
    """Version of the installed package."""
    from importlib.metadata import PackageNotFoundError
    from importlib.metadata import version as installed

    try:
        return installed("evenspin")
    except PackageNotFoundError:
        return "0+unknown"


def _of_checkout(root: Path) -> tuple[str, str] | None:
    """Only of a repository whose top is this folder: never of one in which the package happens to lie."""
    if not (root / ".git").exists() or not (root / "tools" / "src" / "evenspin").is_dir():
        return None
    head = _git(root, "log", "-1", "--abbrev=12", "--format=%h %cI", "HEAD")
    changes = _git(root, "status", "--porcelain", "--untracked-files=no")
    commit, _, date = (head or "").partition(" ")
    if not commit or not date or changes is None:
        return None
    return commit + ("+changes" if changes else ""), date


def _git(root: Path, *words: str) -> str | None:
    clean = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}  # of a hook
    command = ["git", "--no-optional-locks", "-C", str(root), *words]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=GIT_S, env=clean)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def _baked(package: Path) -> tuple[str, str] | None:
    try:
        content = json.loads((package / BAKED).read_text(encoding="utf-8"))
        commit, date = content["commit"], content["date"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return (commit, date) if commit and date else None
