"""Parameters of the drive as a file that the page hands over or takes away."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from evenspin.bench import Drive
from evenspin.bench.config import diff_error, differences, read_config, same_schema, shortest
from evenspin.bench.errors import RefusedError
from evenspin.errors import EvenspinError
from evenspin.native import Field

NAME = "drive.toml"


def changes_of(text: str, name: str, drive: Drive) -> dict[str, float]:
    """What a file changes in this drive; nothing is written. A file that is not right is refused as a whole."""
    if not text.strip():
        raise RefusedError(f"{name} = '(empty)': must be a file with a table [drive]; saving as drive.toml makes one")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / NAME
        path.write_text(text, encoding="utf-8")
        try:
            if not same_schema(path, drive):
                raise diff_error(path)
            return {each.field.name: each.file for each in differences(read_config(path, drive), drive)}
        except EvenspinError as error:
            raise RefusedError(str(error).replace(str(path), name)) from None


def shown(changes: dict[str, float], drive: Drive) -> list[dict[str, Any]]:
    held = drive.get(list(changes)) if changes else {}
    fields = drive.parameters
    return [
        {"name": name, "file": text_of(fields[name], value), "drive": text_of(fields[name], held[name])}
        | {"unit": fields[name].unit}
        for name, value in changes.items()
    ]


def text_of(field: Field, value: float) -> str:
    return field.to_text(value) if field.kind in ("choice", "flag") else f"{shortest(value):g}"
