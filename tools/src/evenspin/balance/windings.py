"""Which slots and pole pairs would make the orders that were found. A suggestion, with what else would.

Source   Unequal magnets make cogging at multiples of the slots, unequal teeth at multiples of the poles, and an ideal
         machine at multiples of lcm(slots, poles). Sensor offsets make the electrical frequency, order p, and unequal
         sensor gains twice that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

MOST_SLOTS, MOST_PAIRS = 60, 30
MULTIPLES = 4
PENALTY = 0.25  # of the strongest line, for an ideal-cogging order that should be there and is not
FEW = 3  # lines; with fewer, the strongest is taken to be the cogging of the ideal machine
PREDICTION_COST = 0.004  # of the sum, per predicted order: slots and poles that predict everything explain nothing


@dataclass(frozen=True, slots=True)
class Winding:
    slots: int
    pole_pairs: int
    covered: float  # share of the found amplitude that it explains
    score: float
    meaning: Mapping[int, str]


def suggest(
    lines: Sequence[tuple[int, float]], highest: int, pole_pairs: int | None = None, count: int = 4
) -> list[Winding]:
    """Best first. `lines`: (order, amplitude); `highest`: order up to which the log can show lines."""
    lines = [(order, amplitude) for order, amplitude in lines if order > 2]
    if not lines:
        return []
    pairs = range(1, MOST_PAIRS + 1) if pole_pairs is None else (pole_pairs,)
    found = [
        _evidence_of(slots, p, lines, highest)
        for slots in range(3, MOST_SLOTS + 1, 3)
        for p in pairs
        if _balanced(slots, p)
    ]
    found = [winding for winding in found if winding.covered > 0.5]
    return sorted(found, key=lambda w: (-round(w.score, 6), w.slots + 2 * w.pole_pairs))[:count]


def _balanced(slots: int, p: int) -> bool:
    """Three equal phases, and a winding factor worth building: slots per pole and phase between 1/4 and 1."""
    return slots % (3 * math.gcd(slots, p)) == 0 and 0.25 <= slots / (6.0 * p) <= 1.0


def meaning_of(order: int, slots: int, p: int) -> str | None:
    if order % math.lcm(slots, 2 * p) == 0:
        return "cogging of the ideal machine, lcm(slots, poles)"
    if order == p:
        return "1st electrical order: current-sensor offset or an unequal pole pair"
    if order % slots == 0:
        return "multiple of the slots: unequal magnets"
    if order % (2 * p) == 0:
        return "multiple of the poles: unequal teeth, or unequal current-sensor gains (2nd electrical order)"
    return None


def _evidence_of(slots: int, p: int, lines: Sequence[tuple[int, float]], highest: int) -> Winding:
    total = sum(amplitude for _, amplitude in lines)
    meaning = {order: text for order, _ in lines if (text := meaning_of(order, slots, p)) is not None}
    covered = sum(amplitude for order, amplitude in lines if order in meaning) / total
    ideal = math.lcm(slots, 2 * p)
    strongest = max(amplitude for _, amplitude in lines)
    missing = PENALTY * strongest / total if ideal <= highest and ideal not in meaning else 0.0
    if len(lines) < FEW and strongest > max((a for order, a in lines if order == ideal), default=0.0):
        missing += PENALTY
    predicted = sum(1 for order in range(1, highest + 1) if meaning_of(order, slots, p) is not None)
    return Winding(slots, p, covered, covered - missing - PREDICTION_COST * predicted, meaning)
