"""The bounds of `make motors`, a line of it, and docs/motors.md from all of them."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

NUMBERS = {"R": "resistance_ohm", "Ld": "ld_h", "Lq": "lq_h", "psi": "psi_wb", "J": "inertia_kgm2"}
WITHIN = 0.03
ZERO_RAD = 0.035  # 2 degrees electrical
BENCH_S = 180.0
USABLE = ("helps", "no use", "reference")
HEAD = (
    "seed  power    V  pp sal.  J kgm2   counts   R %  Ld %  Lq % psi %   J %  zero peak bench methods\n"
    "         W                                                               deg  /max    s"
)

TOP = """<!-- Made by `make motors`. Do not edit. -->

# Machines drawn at random, commissioned

`make motors` draws machines (10 W to 5 kW, 12 to 560 V, 1 to 14 pole pairs, salient or not, 0.2 to 20 times the
inertia of a common rotor of their torque, encoders of 4000 to 2^20 counts, converters with noise, steps and offsets,
dry and viscous friction, an encoder mounted at any angle), hides each behind the virtual drive, and commissions it
with nothing but its largest current ([your motor](your-motor.md#without-a-data-sheet)). {count} machines, seeds
{seeds}, commit {commits}. All of it is simulation.

| | bound | measured |
|---|---|---|
| good in everything below | all | {good} |
| R, Ld, Lq, flux linkage and inertia, each | within {within:.0f} % | {numbers}; largest error {largest} |
| pole pairs and counts of the encoder | right | {counts} |
| electrical zero | within {zero:.0f} deg electrical | {zeros} |
| largest phase current, of the one allowed | 1 | {peak} |
| time on the bench | {bench:.0f} s | {longest} |
| stable and within the goal `smooth` with every method that tuning calls usable | all | {stable} |
| trips | none | {trips} |

Processor time of a machine, of the simulation and the search for gains: {cpu} s in the mean.

## Every machine

Errors in percent of the true value; zero in degrees electrical; current: largest of a phase over the one allowed;
methods: that hold on the hidden machine, of those that tuning calls usable. Held against start, load step, reversal
and full speed; position methods against a slow motion under a torque tied to the angle, where none may trip,
oscillate, or be worse than `ppi`.

| seed | W | V | pole pairs | Lq/Ld | J kgm2 | counts | R % | Ld % | Lq % | flux % | J % | zero | current | bench s \
| methods | |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|
"""
METHODS = """
## Methods

What tuning said of each method on each machine. `helps`: less than 70 % of the ripple without it; `no use`: up to 105
%; the others are not to be used there, and tuning says why.

| method | helps | ripple left, median | no use | harms | cannot | failed on the hidden machine |
|---|---|---|---|---|---|---|
"""
WHY = """
What stood in the way, where a method harms or cannot:

| seed | method | | |
|---|---|---|---|
"""

Row = dict[str, Any]


def misses(row: Row) -> list[str]:
    """Every bound that this machine does not keep."""
    if "refused" in row:
        return [row["refused"]]
    plant = row["plant"]
    found = [row["error"]] if row["error"] else []
    found += [f"{name} {100.0 * error:+.1f} %" for name, error in row["errors"].items() if not abs(error) <= WITHIN]
    if row["pole_pairs"] != plant["pole_pairs"]:
        found.append(f"{row['pole_pairs']} pole pairs")
    if row["counts"] != plant["counts_per_rev"]:
        found.append(f"{row['counts']:g} counts")
    if not abs(row["zero_rad"]) <= ZERO_RAD:
        found.append(f"zero {row['zero_rad']:+.3f} rad")
    if not row["peak_part"] <= 1.0:
        found.append(f"{row['peak_part']:.2f} of the largest current")
    if not row["bench_s"] <= BENCH_S:
        found.append(f"{row['bench_s']:.0f} s")
    return found + failures(row)


def failures(row: Row) -> list[str]:
    return [f"{each['method']}: {problem}" for each in row["methods"] for problem in each["problems"]]


def numbers(row: Row) -> list[str]:
    """The cells of a row, but for what was missed."""
    plant, usable = row["plant"], [each for each in row["methods"] if each["word"] in USABLE]
    held = sum(not each["problems"] for each in usable)
    return [
        f"{row['seed']}", f"{row['power_w']:.0f}", f"{plant['dc_link_v']:.0f}", f"{plant['pole_pairs']}",
        f"{plant['lq_h'] / plant['ld_h']:.2f}", f"{plant['inertia_kgm2']:.2g}", f"{plant['counts_per_rev']}",
        *(f"{100.0 * row['errors'][name]:+.1f}" for name in NUMBERS), f"{math.degrees(row['zero_rad']):+.1f}",
        f"{row['peak_part']:.2f}", f"{row['bench_s']:.0f}", f"{held}/{len(usable)}",
    ]  # fmt: skip


def line(row: Row) -> str:
    """As it is printed below HEAD."""
    if "refused" in row:
        return f"{row['seed']:4} {row['refused']}"
    widths = (4, 6, 4, 3, 4, 8, 8, 5, 5, 5, 5, 5, 5, 5, 5, 6)
    cells = (cell.rjust(width) for cell, width in zip(numbers(row), widths, strict=True))
    return f"{' '.join(cells)}  {'; '.join(misses(row)) or 'good'}"


def page(rows: list[Row]) -> str:
    rows = sorted(rows, key=lambda row: row["seed"])
    done = [row for row in rows if "refused" not in row]
    seeds = [row["seed"] for row in rows]
    errors = [(abs(error), name) for row in done for name, error in row["errors"].items()]
    largest, name = max(errors, default=(math.nan, "-"))
    text = TOP.format(
        count=len(rows), seeds=f"{seeds[0]} to {seeds[-1]}", within=100.0 * WITHIN, zero=math.degrees(ZERO_RAD),
        bench=BENCH_S, commits=", ".join(sorted({str(row["commit"]) for row in rows})),
        good=_share([not misses(row) for row in rows]),
        numbers=_share([max(map(abs, row["errors"].values())) <= WITHIN for row in done]),
        largest=f"{100.0 * largest:.1f} % ({name})",
        counts=_share([row["pole_pairs"] == row["plant"]["pole_pairs"]
                       and row["counts"] == row["plant"]["counts_per_rev"] for row in done]),
        zeros=_share([abs(row["zero_rad"]) <= ZERO_RAD for row in done]),
        peak=f"{max(row['peak_part'] for row in done):.2f} at most",
        longest=f"{min(row['bench_s'] for row in done):.0f} to {max(row['bench_s'] for row in done):.0f} s",
        stable=_share([not failures(row) and bool(row["methods"]) for row in rows if "refused" not in row]),
        trips=str(sum("tripped" in problem for row in done for problem in misses(row)) or "none"),
        cpu=f"{sum(row['cpu_s'] for row in done) / len(done):.0f}",
    )  # fmt: skip
    for row in rows:
        cells = numbers(row) if "refused" not in row else [f"{row['seed']}", *[""] * 15]
        text += f"| {' | '.join(cells)} | {'; '.join(misses(row)) or 'good'} |\n"
    return text + _methods(done)


def _methods(rows: list[Row]) -> str:
    text = METHODS
    names = dict.fromkeys(each["method"] for row in rows for each in row["methods"])
    for name in names:
        found = [each for row in rows for each in row["methods"] if each["method"] == name]
        words = Counter(each["word"] for each in found)
        ratios = sorted(each["ratio"] for each in found if each["word"] == "helps" and each["ratio"] is not None)
        left = f"{100.0 * ratios[len(ratios) // 2]:.3g} %" if ratios else "-"
        failed = sum(bool(each["problems"]) for each in found)
        cells = [str(words[word]) for word in ("no use", "harms", "cannot")]
        helps = "-" if words["reference"] else str(words["helps"])
        text += f"| `{name}` | {helps} | {left} | {' | '.join(cells)} | {failed} |\n"
    text += WHY
    for row in rows:
        for each in row["methods"]:
            if each["word"] not in USABLE:
                text += f"| {row['seed']} | `{each['method']}` | {each['word']} | {each['text'].replace('|', ',')} |\n"
    return text


def _share(kept: list[bool]) -> str:
    return f"{sum(kept)} of {len(kept)}"
