"""docs/circle.md, from what the machines of a campaign left."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
from evenspin.correct.rules import Rule, rule_of

WORSE, AGREES = 0.05, 0.25
HEAD = """<!-- Made by `make circle`. Do not edit. -->

# From cause to correction, on blind machines

Of the {wanted} machines of `make circle CIRCLE_COUNT={wanted} CIRCLE_SEED={seed}` {count} were run, and
{tried} corrections tried. Motors, units and hidden effects are drawn as for `make blind`; the tool gets the nominal
model and the log. The machine is that of the virtual drive, so that its effects are those of the simulator that also
predicts; [blind.md](blind.md) has verdicts on machines of a second simulator. `plausibility_share = 0`: at the larger
effects that check would trip.

| | goal | measured |
|---|---|---|
| what the effect spoils is smaller | 95 % | {better} |
| it is more than 5 % larger | none | {worse} |
| median reduction, of what stands above a healthy machine | 80 % | {median} |
| median reduction, as measured | | {median_measured} |
| predicted change within 25 % of the measured one | 90 % | {agrees} |

A correction that does not help is taken back; the figures count it as it was measured. *predicted* is the mean of seven
machines within the intervals, in brackets the least and the largest of them. *of the effect*: of what stands above a
healthy machine, as simulated, in the square.

## Every correction

| case | hidden (size) | correction | before | predicted | after | unit | less % | of the effect % | kept |
|---|---|---|---|---|---|---|---|---|---|
"""
NOT = """
## Not corrected

| case | hidden (size) | verdict | effect | why |
|---|---|---|---|---|
"""

Case = dict[str, Any]


def page_of(cases: list[Case], seed: int, wanted: int) -> str:
    """`wanted`: machines of the set; `cases`: those that were run."""
    rows = [(case, row) for case in cases if case.get("applied") for row in case["applied"]["corrections"]]
    agreements = [row["predicted_change_over_measured"] for _, row in rows]
    text = HEAD.format(
        wanted=wanted,
        seed=seed,
        count=len(cases),
        tried=len(rows),
        better=_share([row["after"] < row["before"] for _, row in rows]),
        worse=_share([row["after"] > (1.0 + WORSE) * row["before"] for _, row in rows]),
        median=_median([row["reduction_of_effect"] for _, row in rows]),
        median_measured=_median([row["reduction"] for _, row in rows]),
        agrees=_share([ratio is not None and abs(ratio - 1.0) <= AGREES for ratio in agreements]),
    )
    text += "".join(f"| {' | '.join(_cells(case, row))} |\n" for case, row in rows) + NOT
    text += "".join(
        f"| {case['case']} | {_hidden(case)} | {' | '.join(line)} |\n" for case in cases for line in _left(case)
    )
    counts = Counter(isinstance(rule_of(name), Rule) for case in cases for name in case["hidden"])
    return (
        f"{text}\nOf the hidden effects {counts[True]} have a correction in the drive and {counts[False]} have none.\n"
    )


def _cells(case: Case, row: dict[str, Any]) -> list[str]:
    low, high = row["predicted_low"], row["predicted_high"]
    return [
        case["case"],
        _hidden(case),
        row["name"],
        f"{row['before']:.3g}",
        f"{row['predicted']:.3g} ({low:.3g} .. {high:.3g})",
        f"{row['after']:.3g}",
        row["unit"],
        f"{100 * row['reduction']:.0f}",
        f"{100 * row['reduction_of_effect']:.0f}",
        "yes" if row["kept"] else "no",
    ]


def _left(case: Case) -> list[tuple[str, str, str]]:
    """Verdict, effect and reason of what was not corrected."""
    if "error" in case:
        return [("-", "-", f"the experiments could not be done: {case['error']}")]
    verdict = ", ".join(case["verdict"]) or "nothing"
    left = [(verdict, each["effect"], each["reason"]) for each in case["left"]]
    return left + [(verdict, name, "not named") for name in case["hidden"] if name not in case["verdict"]]


def _hidden(case: Case) -> str:
    return f"{', '.join(case['hidden'])} ({case.get('size', '-')})"


def _share(values: list[bool]) -> str:
    return f"{100.0 * sum(values) / len(values):.0f} % ({sum(values)} of {len(values)})" if values else "-"


def _median(values: list[float]) -> str:
    return f"{100.0 * float(np.median(values)):.0f} %" if values else "-"
