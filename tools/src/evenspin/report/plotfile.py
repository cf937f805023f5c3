"""A picture that goes to a file of the user's choice."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from evenspin.errors import InputError

FORMATS = (".svg", ".png", ".pdf")


def check_plot_file(path: Path) -> None:
    """Refuse a place or a format before any work is done."""
    if path.suffix not in FORMATS or path.is_dir() or not path.parent.is_dir():
        raise InputError("--plot", "file", str(path), f"a file {', '.join(FORMATS)} in an existing folder", "rename it")


def save_figure(path: Path, figure: Any) -> None:
    """A figure always gives the same SVG; call it within `drawing`."""
    figure.savefig(path, dpi=150, metadata={"Date": None} if path.suffix == ".svg" else None)
