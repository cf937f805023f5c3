"""Friction or a load that changes with time, and is gone at one end of the log, is no second cause of constant size."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evenspin.driven.analysis import Explained
from evenspin.driven.judge import Verdict
from evenspin.empirical.term import EmpiricalTerm

CONSTANT = {"time_friction": "coulomb_friction", "time_load": "load_torque"}  # what each is beside, from the start on


def without_faded(found: Explained, verdict: Verdict, evidence: Sequence[EmpiricalTerm]) -> None:
    """Take away the name of an effect that the term beside it has brought below its least size when the log ends. Its
    size at the start belongs to the term, and stays in the model that is written."""
    for term in evidence:
        effect = CONSTANT.get(term.family.name)
        named = next((name for name in found.named if found.term(name).effect == effect), None)
        if effect not in verdict.names or named is None:
            continue
        start = found.point[named]
        end = start + np.sum(term.coefficients[:2])
        if float(start[0] * end[0]) > 0.0 and found.term(named).least(end) >= 1.0:
            continue
        verdict.names.remove(effect)
        verdict.at_start += [each for each in verdict.effects if each[0] == effect]
        verdict.effects = [each for each in verdict.effects if each[0] != effect]
        for table in (verdict.confidence, verdict.intervals, verdict.cannot_separate, verdict.called):
            table.pop(effect, None)
