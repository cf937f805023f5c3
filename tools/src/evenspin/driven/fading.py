"""Friction or a load that changes with time, and is gone when the log ends or when it has settled, is no second cause
of constant size."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.driven.judge import Verdict
from evenspin.empirical.effect import CONSTANT
from evenspin.empirical.term import EmpiricalTerm
from evenspin.weakform.analysis import Explained

Array = NDArray[np.float64]


def without_faded(found: Explained, verdict: Verdict, evidence: Sequence[EmpiricalTerm]) -> None:
    """Take away the name of an effect that the term beside it brings below its least size. Its size at the start
    belongs to the term, and stays in the model that is written."""
    for term in evidence:
        effect = CONSTANT.get(term.family.name)
        named = next((name for name in found.named if found.term(name).effect == effect), None)
        if effect not in verdict.names or named is None:
            continue
        start = found.point[named]
        if all(start[0] * z[0] > 0.0 and found.term(named).least(z) >= 1.0 for z in _later(start, term)):
            continue
        verdict.names.remove(effect)
        verdict.at_start += [each for each in verdict.effects if each[0] == effect]
        verdict.effects = [each for each in verdict.effects if each[0] != effect]
        for table in (verdict.confidence, verdict.intervals, verdict.cannot_separate, verdict.called):
            table.pop(effect, None)


def _later(start: Array, term: EmpiricalTerm) -> Iterator[Array]:
    """The size when the log ends, and where it tends to with the least and the largest time constant of its interval:
    an exponential that the log does not see the end of is no constant as far as it could still fall."""
    grown, at_start = term.coefficients[:2]
    yield start + at_start + grown
    for turn in (-1.0, 1.0):
        time_constant_s = max(term.shape[0] + turn * term.shape_half[0], 1e-6)
        yield start + at_start + grown / -math.expm1(-term.facts["span_s"] / time_constant_s)
