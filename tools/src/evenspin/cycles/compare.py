"""Measured beside estimated: the interrupts' durations in a log against the estimate of the same method."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.cycles.measure import Result
from evenspin.cycles.rows import ISR_FRAME, PLAIN_CONTROLLER
from evenspin.errors import MISSING, InputError, did_you_mean
from evenspin.log import read_csv
from evenspin.sim import Record

TIMING_FILE = "timing.csv"
FRAME_CYC = ISR_FRAME // 10  # entry and exit: in the estimate, not in what the interrupt itself can measure
BIN_CYC = 512  # TIMING_BIN_CYC of firmware/app/timing.h
BINS = 17  # TIMING_BINS; the last takes what is longer
UNITS = {
    "isr_cycles": "cycle",
    "isr_min_cycles": "cycle",
    "isr_max_cycles": "cycle",
    "speed_isr_cycles": "cycle",
    "speed_isr_min_cycles": "cycle",
    "speed_isr_max_cycles": "cycle",
    "isr_bin": "",
    "isr_bin_count": "",
    "speed_isr_bin_count": "",
}
INTERRUPTS = {"current_isr": "isr", "speed_isr": "speed_isr"}  # row of the estimate: prefix of the signals
HINT = "log the signals isr_max_cycles, speed_isr_max_cycles and isr_bin, isr_bin_count of a run"


@dataclass(frozen=True, slots=True)
class Measured:
    """One interrupt in a log; None where the log does not say."""

    last: int
    shortest: int | None
    longest: int
    bins: tuple[int, ...] | None


@dataclass(frozen=True, slots=True)
class Compared:
    """One interrupt, measured and estimated, both without entry and exit."""

    name: str
    measured_last: int
    measured_min: int | None
    measured_max: int
    estimated_mean: int
    estimated_worst: int
    expected: tuple[int, int]  # what may be measured when the estimate is off by the band
    verdict: str  # inside, below, above

    @property
    def difference_pct(self) -> float:
        return 100.0 * (self.measured_max / self.estimated_worst - 1.0)

    def document(self) -> dict[str, Any]:
        return {**asdict(self), "difference_pct": self.difference_pct}


def timing_columns(names: Sequence[str]) -> tuple[str, ...]:
    return tuple(name for name in UNITS if name in names)


def log_file(log: Path) -> Path:
    """The CSV file in a folder that has the durations, or the file itself."""
    if not log.is_dir():
        return log
    files = [log / TIMING_FILE, *sorted(log.glob("*.csv")), *sorted(log.glob("*.csv.gz"))]
    for file in files:
        if file.is_file() and "isr_max_cycles" in header_of(file):
            return file
    must = "a folder with a CSV file that has the column isr_max_cycles"
    raise InputError(log, "--compare", str(log), must, f"{HINT}; a simulation has them with isr_load_cyc in an event")


def header_of(file: Path) -> list[str]:
    import gzip

    opener = gzip.open if file.suffix == ".gz" else open
    try:
        with opener(file, "rt", encoding="utf-8") as text:
            return text.readline().strip().split(",")
    except FileNotFoundError:
        raise InputError(file, "--compare", MISSING, "an existing file or folder", HINT) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(file, "file", str(error), "a readable CSV file", HINT) from None


def read_measured(file: Path) -> dict[str, Measured]:
    """Durations of the two interrupts in a log, of those that it has."""
    found = timing_columns(header_of(file))
    if "isr_max_cycles" not in found:
        raise InputError(file, "column", "isr_max_cycles", "in the header", HINT, 1)
    record = read_csv(file, found, [UNITS[name] for name in found])
    if len(record) == 0:
        raise InputError(file, "rows", 0, "at least one row", HINT)
    measured = {}
    for row, prefix in INTERRUPTS.items():
        if f"{prefix}_max_cycles" in record and record[f"{prefix}_max_cycles"][-1] > 0.0:
            longest = int(record[f"{prefix}_max_cycles"][-1])
            last = int(record[f"{prefix}_cycles"][-1]) if f"{prefix}_cycles" in record else longest
            shortest = int(record[f"{prefix}_min_cycles"][-1]) if f"{prefix}_min_cycles" in record else None
            measured[row] = Measured(last, shortest, longest, histogram(record, f"{prefix}_bin_count"))
    if "current_isr" not in measured:
        raise InputError(file, "isr_max_cycles", 0, "above 0", "the clock stood still: set isr_load_cyc in an event")
    return measured


def histogram(record: Record, column: str) -> tuple[int, ...] | None:
    """A row shows one bin: of each, what was shown last."""
    if "isr_bin" not in record or column not in record:
        return None
    counts = [0] * BINS
    for shown in range(BINS):
        rows = np.flatnonzero(record["isr_bin"] == shown)
        if rows.size:
            counts[shown] = int(record[column][rows[-1]])
    return tuple(counts)


def variant_of(drive: Mapping[str, Any], position: bool) -> str:
    """Name of the estimate's rows for these drive parameters, choices by their names."""
    if position:
        return f"position {drive['position_method']}"
    name = str(drive["method"])
    if name == "fal-forc" and drive["rc_memory"] == "angle":
        name += " angle"
    if name == "aro" and drive["aro_read"] == "cubic":
        name += " extended"
    controller = str(drive["current_controller"])
    return name if controller == PLAIN_CONTROLLER else f"{name} {controller}"


def variant_beside(log: Path) -> str | None:
    """The variant by the files beside the log: the summary of a run, or a meta.json with the drive's parameters."""
    folder = log if log.is_dir() else log.parent
    for name in ("summary.json", "meta.json"):
        try:
            document = json.loads((folder / name).read_text(encoding="utf-8"))
            return variant_of(document["drive"], bool(document.get("position_control", False)))
        except (OSError, ValueError, KeyError, TypeError):
            continue
    return None


def compare(measured: Mapping[str, Measured], result: Result, variant: str) -> list[Compared]:
    """Each interrupt that both know."""
    rows = {row.name: row for row in result.rows if row.kind == "isr"}
    known = sorted(name.removeprefix("current_isr ") for name in rows if name.startswith("current_isr "))
    if variant not in known:
        raise InputError("cycles", "--variant", variant, f"one of {', '.join(known)}", did_you_mean(variant, known))
    low, high = result.band
    compared = []
    for interrupt, seen in measured.items():
        row = rows[f"{interrupt} {variant}"]
        mean, worst = row.cycles_est - FRAME_CYC, row.cycles_worst - FRAME_CYC
        expected = (round(worst / (1.0 + high)), round(worst / (1.0 + low)))
        verdict = "below" if seen.longest < expected[0] else "above" if seen.longest > expected[1] else "inside"
        compared.append(
            Compared(f"{interrupt} {variant}", seen.last, seen.shortest, seen.longest, mean, worst, expected, verdict)
        )
    return compared
