"""Torque balances of logs drawn at random: names that are wrong or missing, and intervals that hold the truth.

    python tools/tests/balance/numpy_campaign.py FIRST COUNT

The seeds of the development were 0 to 39, 500 to 539, 700 to 739, 900 to 939, 1100 to 1139 and 1200 to 1239. Of three
logs one comes with its model, one with a model that has no inertia, one with none.
"""

from __future__ import annotations

import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy_drive as drive
from evenspin.balance import run_balance


def judged(seed: int) -> tuple[int, str, drive.Machine, dict[str, Any]]:
    profile, machine = drive.drawn(seed)
    with tempfile.TemporaryDirectory() as folder:
        log = drive.write(Path(folder) / "log.csv", drive.run(machine))
        model = None
        if seed % 3 != 2:
            model = drive.model_file(Path(folder) / "model.toml", machine, inertia=seed % 3 == 0)
        return seed, profile, machine, run_balance(log, model, None).verdict


def main(first: int, count: int) -> None:
    right = held = given = 0
    with ProcessPoolExecutor(2) as pool:
        for seed, profile, machine, verdict in pool.map(judged, range(first, first + count)):
            wrong = drive.names_wrong(verdict, machine)
            rows = drive.intervals(verdict, machine)
            missed = [row for row in rows if abs(row[2] - row[1]) > row[3]]
            right, held, given = right + (not wrong), held + len(rows) - len(missed), given + len(rows)
            what = f"cogging {1e3 * machine.cogging_a:.0f} mA at {machine.order}, {machine.counts} counts"
            print(f"{seed:4d} {profile:9s} {what}: {', '.join(verdict['verdict'])}", *wrong, sep="; ", flush=True)
            for name, truth, value, half in missed:
                print(f"          {name}: {value:.4g} +- {half:.2g}, truth {truth:.4g}", flush=True)
    print(
        f"names right in {right} of {count}; {held} of {given} intervals hold the truth ({100.0 * held / given:.1f} %)"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
