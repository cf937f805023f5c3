"""A case: a folder with meta.json and one CSV per experiment. What only a simulation knows is not part of it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.errors import InputError
from evenspin.log.columns import LOG_COLUMNS, LOG_UNITS
from evenspin.log.csvfile import read_csv, write_csv
from evenspin.log.textfile import HINT, META_BYTES, read_text
from evenspin.sim.record import Record

META = "meta.json"


@dataclass(frozen=True, slots=True)
class Case:
    """What was read from a case folder."""

    path: Path
    meta: Mapping[str, Any]
    experiments: Mapping[str, Record]

    def file(self, name: str) -> Path:
        """Where this experiment was read from."""
        return _find(self.path, name) or self.path / f"{name}.csv"

    def starts_s(self) -> dict[str, float]:
        """When each record begins if they followed each other without a pause, as they are listed."""
        starts, clock_s = {}, 0.0
        for name, record in self.experiments.items():
            starts[name] = clock_s
            t_s = record["t_s"]
            clock_s += float(t_s[-1] - t_s[0]) + (float(np.median(np.diff(t_s))) if len(t_s) > 1 else 0.0)
        return starts


def write_case(folder: Path, meta: Mapping[str, Any], records: Mapping[str, Record]) -> None:
    """Write meta.json and the log of each experiment into an existing folder."""
    write_json(folder / META, meta)
    for name, record in records.items():
        write_csv(folder / f"{name}.csv", LOG_COLUMNS, record.pick(LOG_COLUMNS).values)


def read_case(folder: Path) -> Case:
    """Read a case; an experiment of meta.json without a file is left out."""
    meta = read_meta(folder / META)
    found = {name: _find(folder, name) for name in meta["experiments"]}
    records = {name: read_csv(path, LOG_COLUMNS, LOG_UNITS) for name, path in found.items() if path is not None}
    if not records:
        raise InputError(folder, "experiments", meta["experiments"], "at least one file NAME.csv or .csv.gz", HINT)
    return Case(folder, meta, records)


RECORDING = "recording.csv"  # what `evenspin bench record` leaves instead of a case


def recording_in(place: Path) -> Path | None:
    """The log in the folder of a recording, which is no case; None for anything else."""
    log = place / RECORDING
    return log if log.is_file() and not (place / META).exists() else None


def read_meta(path: Path) -> dict[str, Any]:
    if path.parent.is_file():
        raise InputError(path.parent, "case", "a file", f"a folder with {META}", "`evenspin gap` takes a log by itself")
    if (log := recording_in(path.parent)) is not None:
        hint = f"`evenspin gap {log} --model MODEL --out DIR` takes it; `evenspin bench run` makes a case"
        raise InputError(path.parent, "case", "a recording", f"a folder with {META}", hint)
    try:
        meta = json.loads(read_text(path, HINT, META_BYTES, "JSON"))
    except (ValueError, RecursionError) as error:
        reason = "(nested too deeply)" if isinstance(error, RecursionError) else str(error)
        raise InputError(path, "file", reason, "JSON", HINT) from None
    names = meta.get("experiments") if isinstance(meta, dict) else None
    if not isinstance(names, list) or not all(isinstance(name, str) and name == Path(name).name for name in names):
        raise InputError(path, "experiments", names, "a list of names", HINT)
    return meta


def write_json(path: Path, value: object) -> None:
    path.write_text(json.dumps(value, indent=1) + "\n", encoding="utf-8")


def _find(folder: Path, name: str) -> Path | None:
    return next((path for path in (folder / f"{name}.csv", folder / f"{name}.csv.gz") if path.is_file()), None)
