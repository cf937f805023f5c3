"""Machines drawn at random, hidden behind the virtual drive, and commissioned: are the numbers right, does it run?

    motors_campaign.py [COUNT [FIRST_SEED]] [--no-methods] [--log FILE.jsonl] [--page FILE.md]

One line a machine, then how many keep each bound. Exit status 1 when one does not. The drive of each starts as a board
that was just flashed, and knows the largest current alone. Afterwards the tuned drive is simulated on the hidden
machine: start, load step, reversal and full speed, with pi and with every method against ripple that tuning calls
usable, and a slow motion with every such position method. With --log a machine that has its line there is not run
again; --page writes docs/motors.md from it.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from evenspin.bench import Drive
from evenspin.build import build
from evenspin.commission.limits import Bounds
from evenspin.commission.work import Commissioned, commission, drive_values
from evenspin.errors import EvenspinError
from evenspin.model import load_machine
from evenspin.tune.goals import GOALS
from evenspin.tune.methods import NO_HARM, POSITION_TURNS, Verdict
from evenspin.tune.trial import position_ripple, said, speed_trial
from motors_page import HEAD, NUMBERS, line, misses, page
from random_machines import RandomMachine, random_machine

FIELDS = {"R": "resistance", "Ld": "ld", "Lq": "lq", "psi": "psi", "J": "inertia"}
MORE_OVERSHOOT = 1.6  # of the goal's: the hidden machine is not the one that was measured


@dataclass(frozen=True)
class Row:
    """What became of one machine; `kept` is its line in the log."""

    machine: RandomMachine
    done: Commissioned
    kept: dict[str, Any] = field(repr=False)

    @property
    def misses(self) -> list[str]:
        return misses(self.kept)

    def __str__(self) -> str:
        return line(self.kept)


def run(machine: RandomMachine, *, methods: bool) -> Row:
    """Commission it, then try the result on the machine itself."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "hidden.toml"
        path.write_text(machine.toml())
        with Drive.connect(f"sim:{path}?fresh=1") as drive:
            virtual = drive.link.transport.drive
            virtual.record(("true_ia_a", "true_ib_a", "true_ic_a"))
            done = commission(drive, Bounds(machine.max_current_a), "smooth", methods=methods)
            peak = float(abs(virtual.recorded()).max())
        hidden = load_machine(path)
    known, plant = done.known, machine.plant
    errors = {name: getattr(known, FIELDS[name]).value / plant[key] - 1.0 for name, key in NUMBERS.items()}
    zero = math.remainder(known.offset_rad + machine.effects["encoder_offset"]["angle_el_rad"], 2.0 * math.pi)
    kept = {
        "seed": machine.seed, "power_w": machine.power_w, "plant": plant, "commit": build().commit, "error": done.error,
        "pole_pairs": known.pole_pairs, "counts": known.counts, "errors": errors, "zero_rad": zero,
        "peak_part": peak / machine.max_current_a, "bench_s": done.seconds, "with_methods": methods,
        "methods": on_the_machine(done, hidden.plant) if done.tuning is not None else [],
    }  # fmt: skip
    return Row(machine, done, kept | {"cpu_s": time.process_time() - began})


def on_the_machine(done: Commissioned, plant: dict[str, float]) -> list[dict[str, Any]]:
    """pi, and every method that tuning calls usable, with the drive that commissioning made."""
    assert done.tuning is not None
    # The angle of this plant is true, and no friction holds it.
    more = {"encoder_offset_rad": 0.0, "rdc_coulomb_nm": 0.0, "rdc_static_nm": 0.0, "method": 0.0}
    drive = drive_values(done) | more
    limit = MORE_OVERSHOOT * GOALS[done.goal].overshoot_part
    loops = {"method": "pi", "word": "reference", "problems": list(speed_trial(plant, drive, limit, "pi").problems)}
    found: list[dict[str, Any]] = [loops]
    for verdict in done.tuning.methods:
        problems: list[str] = []
        if verdict.usable:
            setup = {**drive, "method": verdict.changes["method"]}
            problems += speed_trial(plant, setup, 2.0 * limit, verdict.method, 5.0).problems
        found.append(_kept(verdict, problems))
    reference = math.inf
    for verdict in done.tuning.positions:
        problems = []
        if verdict.usable:
            setup = {**drive, "position_method": verdict.changes["position_method"]}
            ripple = position_ripple(plant, setup, verdict.speed_rad_s, POSITION_TURNS[verdict.method])
            if not ripple.outcome.good:
                problems.append(said(ripple.outcome))
            elif ripple.rms > NO_HARM * reference:
                problems.append(f"ripple of {ripple.rms:.3g} rad, {reference:.3g} without it")
            if verdict.word == "reference" and not problems:
                reference = ripple.rms
        found.append(_kept(verdict, problems))
    return found


def _kept(verdict: Verdict, problems: list[str]) -> dict[str, Any]:
    ratio = verdict.ratio if math.isfinite(verdict.ratio) and verdict.with_it > 0.0 else None
    return {"method": verdict.method, "word": verdict.word, "ratio": ratio, "text": verdict.text, "problems": problems}


def _one(seed: int, methods: bool) -> dict[str, Any]:
    try:
        return run(random_machine(seed), methods=methods).kept
    except EvenspinError as error:
        return {"seed": seed, "refused": str(error), "commit": build().commit, "with_methods": methods}


def campaign(seeds: list[int], log: Path | None, *, methods: bool) -> Iterator[dict[str, Any]]:
    """Two or more at a time, each with its line in the log as soon as it is done."""
    before = [json.loads(text) for text in log.read_text().splitlines()] if log is not None and log.is_file() else []
    known = {row["seed"]: row for row in before if row["with_methods"] == methods}
    yield from (known[seed] for seed in seeds if seed in known)
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for future in as_completed([pool.submit(_one, seed, methods) for seed in seeds if seed not in known]):
            row = future.result()
            if log is not None:
                with log.open("a") as lines:
                    lines.write(json.dumps(row) + "\n")
            yield row


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("count", nargs="?", type=int, default=30)
    parser.add_argument("first", nargs="?", type=int, default=0)
    parser.add_argument("--no-methods", action="store_true")
    parser.add_argument("--log", type=Path)
    parser.add_argument("--page", type=Path)
    given = parser.parse_args()
    rows = []
    print(HEAD, flush=True)
    if given.log is not None:
        given.log.parent.mkdir(parents=True, exist_ok=True)
    seeds = list(range(given.first, given.first + given.count))
    for row in campaign(seeds, given.log, methods=not given.no_methods):
        rows.append(row)
        print(line(row), flush=True)
    good = sum(not misses(row) for row in rows)
    longest = max((row.get("bench_s", 0.0) for row in rows), default=0.0)
    print(f"{good} of {given.count} good; longest {longest:.0f} s on the bench")
    if given.page is not None:
        given.page.write_text(page(rows))
    return 0 if good == given.count else 1


if __name__ == "__main__":
    sys.exit(main())
