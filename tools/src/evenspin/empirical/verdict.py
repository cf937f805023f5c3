"""A found term in verdict.json."""

from __future__ import annotations

from typing import Any

from evenspin.empirical import words
from evenspin.empirical.term import EmpiricalTerm


def term_json(term: EmpiricalTerm) -> dict[str, Any]:
    return {
        "depends_on": words.depends_on(term),
        "family": term.family.name,
        "form": words.form(term),
        "like": words.like(term),
        "share": term.share,
        "parameters": term.parameters(),
        "intervals": term.intervals(),
        "unseen_t": term.t,
        "looks_alike": [{"family": each.family, "behind": each.behind} for each in term.look_alikes],
        "next_experiment": words.experiment(term),
        "log": term.log,
        "measured_over": dict(term.facts),
    }
