"""What mutate.py has found: rows by file, the survivors, and the page."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

from mutants import Mutant

REVIEWED = Path(__file__).resolve().parent / "reviewed.toml"
GOALS = {
    "firmware/app/protection.c": 1.0,
    "firmware/app/state_machine.c": 1.0,
    "firmware/app/faults.c": 1.0,
    "firmware/storage/*": 1.0,
    "control/*": 0.97,
}


@dataclass(frozen=True, slots=True)
class Outcome:
    """`fate`: killed, alive, same (object code), refused (by the compiler); `by`: the test that has noticed."""

    file: str
    mutant: Mutant
    fate: str
    by: str = ""


@cache
def reviewed() -> dict[tuple[str, str], str]:
    """Reasons why no input shows a difference to the original."""
    rows = tomllib.loads(REVIEWED.read_text(encoding="utf-8")).get("equivalent", [])
    keys = [json.dumps([row["line"], row["old"], row["new"], row.get("nth", 0)]) for row in rows]
    return {(row["file"], key): row["reason"] for row, key in zip(rows, keys, strict=True)}


def reason_for(outcome: Outcome) -> str:
    return reviewed().get((outcome.file, outcome.mutant.key), "") if outcome.fate == "alive" else ""


def survivors(outcomes: Sequence[Outcome]) -> list[Outcome]:
    return [o for o in outcomes if o.fate == "alive" and not reason_for(o)]


def counts(outcomes: Sequence[Outcome]) -> tuple[int, int, int]:
    """Killed, alive, equivalent."""
    killed = sum(o.fate == "killed" for o in outcomes)
    alive = len(survivors(outcomes))
    return killed, alive, sum(o.fate == "alive" for o in outcomes) - alive


def share(killed: int, alive: int) -> str:
    return f"{100.0 * killed / (killed + alive):.1f} %" if killed + alive else "-"


def rows_of(outcomes: Sequence[Outcome]) -> list[str]:
    rows = []
    for file in sorted({o.file for o in outcomes}):
        killed, alive, equivalent = counts([o for o in outcomes if o.file == file])
        rows.append(f"| `{file}` | {killed + alive} | {killed} | {alive} | {equivalent} | {share(killed, alive)} |")
    return rows


def met(outcomes: Sequence[Outcome]) -> bool:
    for pattern, goal in GOALS.items():
        killed, alive, _ = counts([o for o in outcomes if fnmatch(o.file, pattern)])
        if killed < goal * (killed + alive):
            return False
    return True


def said(outcomes: Sequence[Outcome]) -> tuple[list[str], bool]:
    """Lines for the screen, and whether the goals are met."""
    left = [f"{o.file}:{o.mutant.line}: {o.mutant}" for o in survivors(outcomes)]
    return ["| file | mutants | killed | alive | equivalent | share |", *rows_of(outcomes), *left], met(outcomes)


INTRODUCTION = """<!-- Made by tests/mutate/mutate.py (`make mutate`). Do not edit. -->

# Mutation

How much of the code the tests hold: it is broken on purpose, one small change at a time, and a test has to fail. A
change is a comparison or its boundary, `&&` and `||`, a dropped `!`, plus and minus, times and divided by, `num_add`
and `num_sub`, true and false, a constant one more (a fraction half as much again), or a statement left out. A mutant is
killed by the first test that fails, crashes or does not end: its own first, then every other in C that has the file in
it. One with the same object code in both numerics is no mutant. A pattern with a number behind it is a sample.

Goals: all of protection, state machine, faults and storage, 97 % of `control/`. A survivor is either a gap of the
tests, or equivalent to the original; the latter stand in `tests/mutate/reviewed.toml` with the reason.
"""


def page(outcomes: Sequence[Outcome], patterns: Sequence[str], sample: int, seed: int) -> str:
    killed, alive, equivalent = counts(outcomes)
    same, refused = (sum(o.fate == fate for o in outcomes) for fate in ("same", "refused"))
    drawn = f"{sample} mutants of each" if sample else "every mutant, or so many as stand behind the pattern"
    control = [o for o in outcomes if o.file.startswith("control/")]
    control_said = f", of `control/` {share(*counts(control)[:2])}" if control else ""
    text = [
        INTRODUCTION,
        f"{', '.join(f'`{pattern}`' for pattern in patterns)}: {drawn}, seed {seed}. "
        f"{killed} of {killed + alive} are killed, "
        f"{share(killed, alive)}{control_said}; {equivalent} more are equivalent, {same} give the same object code, "
        f"{refused} do not compile. The goals are {'met' if met(outcomes) else 'not met'}.",
        "",
        "| file | mutants | killed | alive | equivalent | share |",
        "| --- | --- | --- | --- | --- | --- |",
        *rows_of(outcomes),
        "",
        "## Alive",
        "",
        *([f"* {o.file}:{o.mutant.line}: {o.mutant}" for o in survivors(outcomes)] or ["None."]),
        "",
        "## Equivalent",
        "",
        *([f"* {o.file}:{o.mutant.line}: {o.mutant}: {reason_for(o)}" for o in outcomes if reason_for(o)] or ["None."]),
        "",
    ]
    return "\n".join(text)
