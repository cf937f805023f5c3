"""A memory that changes by itself: one flipped bit in every part of the state of a running drive. What does it lead to?

*reported*: the drive trips. *wrong speed*: nothing is reported, and at the end the speed is off by more than 2 %
of what is asked for, or it swings. *bridge*: nothing is reported, and the bridge is off while the state says RUN,
or the other way round. *heals*: neither. Each bit is flipped in RUN at a steady speed, and watched for a second.
`python tools/tests/bit_flips.py --count 300`, or as part of `make single-faults`.
"""

from __future__ import annotations

import argparse
import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from evenspin.model.machine import builtin_models, load_machine
from evenspin.native import tables
from evenspin.native.simulation import Simulation
from evenspin.run.outcome import RUN

SPEED_RAD_S = 150.0
BEFORE_S, WATCHED_S = 0.3, 1.0
PERIODS = 10000
WRONG = 0.02
TAIL = 2000  # rows that count at the end
SIGNALS = ("fault", "state", "true_speed_rad_s", "true_ia_a", "true_ib_a", "true_ic_a", "gate_periods")
METHODS = {"pi": {}, "fal-forc": {"method": 3.0}, "aro": {"method": 6.0, "speed_source": 0.0}}
REPORTED, WRONG_SPEED, BRIDGE, HEALS = "reported", "wrong speed", "bridge", "heals"


@dataclass(frozen=True)
class Flip:
    region: str
    method: str
    bit: int
    outcome: str
    fault: str
    ms: float  # until the report
    current: float  # largest, over over_current_a
    speed: float  # largest, rad/s


def running(method: str, numeric: str) -> Simulation:
    machine = load_machine(builtin_models()["guo2024"])
    simulation = Simulation(numeric)
    for name, value in machine.plant.items():
        simulation.set_model(name, value)
    drive = {
        **machine.drive,
        **METHODS[method],
        "offset_calibration_periods": 0.0,
        "align_periods": 0.0,
        "auto_run": 1.0,
    }
    for name, value in drive.items():
        simulation.set_param(name, value)
    simulation.set_input("speed_ref_rad_s", (0.0,), (SPEED_RAD_S,))
    simulation.set_input("load_brake_nm", (0.0,), (0.02,))
    simulation.start()
    simulation.record(SIGNALS)
    return simulation


def flip(region: str, method: str, at: random.Random, numeric: str = "float") -> Flip:
    simulation = running(method, numeric)
    simulation.skip(round(BEFORE_S * PERIODS) + at.randrange(20))
    bit = at.randrange(simulation.regions()[region])
    simulation.flip(region, bit)
    rows = simulation.run(round(WATCHED_S * PERIODS))
    found = np.nonzero(rows[:, 0])[0]
    end = int(found[0]) + 1 if found.size else len(rows)
    current = float(np.abs(rows[:end, 3:6]).max()) / 20.0
    speed = float(np.abs(rows[:end, 2]).max())
    fault = tables().faults[int(rows[end - 1, 0])].name if found.size else "none"
    if found.size:
        outcome = REPORTED
    else:
        tail = rows[-TAIL:]
        gates = tail[-1, 6] - tail[0, 6] > 0.5 * len(tail)
        bridge = gates != bool((tail[:, 1] == RUN).all()) or not (tail[:, 1] == RUN).all()
        off = np.abs(tail[:, 2] - SPEED_RAD_S).max() > WRONG * SPEED_RAD_S
        outcome = BRIDGE if bridge else WRONG_SPEED if off else HEALS
    return Flip(region, method, bit, outcome, fault, end / 10.0, current, speed)


def campaign(count: int, numeric: str = "float", regions: tuple[str, ...] = ()) -> Iterator[Flip]:
    """`count` flips in each region and method, spread over bits and moments."""
    names = regions or tuple(running("pi", numeric).regions())
    for region in names:
        for method in METHODS:
            at = random.Random(f"{region} {method} {numeric}")
            for _ in range(count):
                yield flip(region, method, at, numeric)


TITLE = "\n## A memory that changes by itself\n"
TEXT = """
One bit flips in one part of the state of a drive that turns at {speed:g} rad/s in speed mode (`guo2024`; pi,
fal-forc and aro in turn), simulated for {watched:g} s: {count} flips each. *Reported*: the drive trips, after
so many ms. *Wrong speed*: nothing is reported, and at the end the speed is off by more than {wrong:.0%}.
*Bridge*: nothing is reported, and the bridge is off although the state says that it runs, or the other way
round. *Heals*: neither. *Current*: the largest, over `over_current_a`. What stays as it is while the drive runs
(command, parameters, their copies in the controllers, zero, offsets, state) is held against sums and copies in
the main loop (`memory_changed`); what changes in every period the loops correct, or other checks find. Pointers
are not here: a flipped one leaves the memory of the simulator, and on the chip it is an address that is none,
or a wrong one, which nothing finds for certain. What is left: the q current reference, in the time between two
interrupts: the observer of aro takes it for what acted, and its table has to be learned again, which took 2 s.

"""


def chapter(count: int) -> str:
    """For docs/single-faults.md."""
    flips = list(campaign(count))
    text = TEXT.format(speed=SPEED_RAD_S, watched=WATCHED_S, count=count * len(METHODS), wrong=WRONG)
    total = Counter(one.outcome for one in flips)
    counts = ", ".join(f"{total[word]} {word}" for word in (REPORTED, HEALS, WRONG_SPEED, BRIDGE))
    return TITLE + text + "\n".join(table(flips)) + f"\n\nAll {len(flips)}: {counts}.\n"


def table(flips: list[Flip]) -> list[str]:
    lines = [
        "| state | flips | reported | median ms | longest | wrong speed | bridge | heals | current | first report |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for region in dict.fromkeys(one.region for one in flips):
        of = [one for one in flips if one.region == region]
        counts = Counter(one.outcome for one in of)
        times = sorted(one.ms for one in of if one.outcome == REPORTED)
        names = Counter(one.fault for one in of if one.outcome == REPORTED)
        report = ", ".join(f"`{name}` {n}" for name, n in names.most_common(3)) or "-"
        ms = f"{times[len(times) // 2]:.1f} | {times[-1]:.1f}" if times else "- | -"
        lines.append(
            f"| {region} | {len(of)} | {counts[REPORTED]} | {ms} | {counts[WRONG_SPEED]} | {counts[BRIDGE]} | "
            f"{counts[HEALS]} | {max(one.current for one in of):.2f} | {report} |"
        )
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--numeric", default="float", choices=("float", "fixed"))
    parser.add_argument("--region", action="append", default=[])
    parser.add_argument("--bits", action="store_true", help="print each flip that is not reported and does not heal")
    options = parser.parse_args()
    flips = list(campaign(options.count, options.numeric, tuple(options.region)))
    print("\n".join(table(flips)))
    if options.bits:
        for one in flips:
            if one.outcome in (WRONG_SPEED, BRIDGE):
                print(one)
    total = Counter(one.outcome for one in flips)
    print(f"{len(flips)} flips: {dict(total)}; largest current {max(one.current for one in flips):.2f}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
