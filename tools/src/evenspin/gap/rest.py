"""What no known effect explains in a case folder, as terms of the empirical library.

The records in which the shaft turns are one log of one drive, held against the equations of the machine in weak form:
its voltages and currents drive them, no controller is in between. They follow each other by one clock, without pauses,
as they are listed. The terms compete with the effects of the table; those stay that the validation record confirms,
which no fit sees.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import Scale
from evenspin.empirical.effect import CONSTANT, Effects, at_start, bounded, effects_of, together
from evenspin.empirical.term import EmpiricalTerm
from evenspin.log.case import Case
from evenspin.log.experiments import LOCKED, VALIDATION
from evenspin.log.nominal import Nominal
from evenspin.weakform.analysis import explain
from evenspin.weakform.beyond import Beyond, look_beyond
from evenspin.weakform.beyond_search import Search
from evenspin.weakform.evidence import confirmed
from evenspin.weakform.signals import Signals, joined, signals_of
from evenspin.weakform.terms import SHAFT
from evenspin.weakform.tolerances import LABORATORY

Array = NDArray[np.float64]

COLUMNS = ("theta_m_rad", "speed_rad_s", "id_a", "iq_a", "vd_v", "vq_v", "vdc_v", "load_torque_nm")
SAME_RATE = 0.01
STRETCH_S, EVERY = 1.0, 4  # every fourth second of the other records fits no term
ROUNDS = 4  # of the search for terms; most rest after three
LEAST_RECORDS = 2  # turning, that are fitted


@dataclass(frozen=True, slots=True)
class Rest:
    """Confirmed terms, largest share first. `effects`: what the simulator runs for them; `not_simulated`: what it has
    no place for; `beside`: coordinates of the effects of the table that were chosen along with them."""

    terms: tuple[EmpiricalTerm, ...] = ()
    effects: Effects = field(default_factory=dict)
    not_simulated: tuple[str, ...] = ()
    beside: Mapping[str, Array] = field(default_factory=dict)


def rest_of(
    case: Case,
    nominal: Nominal,
    scale: Scale,
    known: Mapping[str, Mapping[str, float]],
    say: Callable[[str, float], None] = lambda what, share: None,
) -> Rest:
    """`known`: effects that are named, with their parameters. No term: nothing of the library explains the rest."""
    records = turning_records(case)
    fitted = [name for name in records if name not in VALIDATION]
    if len(fitted) < LEAST_RECORDS or len(fitted) == len(records):
        return Rest()
    signals = joined(case.path.name, list(records.values()))
    plant = {
        **nominal.machine,
        **nominal.supply,
        "counts_per_rev": nominal.counts_per_rev,
        "current_noise_a": nominal.current_noise_a,
    }
    # All but a shaft is chosen again: a name may stand for what a term says better.
    base = [(name, dict(values)) for name, values in known.items() if name == SHAFT]
    validation = np.concatenate([np.full(len(part), name in VALIDATION) for name, part in records.items()])
    # What has settled before the validation record is confirmed on stretches of the others that then fit nothing.
    stretches = (signals.t_s // STRETCH_S).astype(np.int64) % EVERY == EVERY - 1
    for kept in (validation, validation | stretches):
        found = explain([signals], plant, base, scale, LABORATORY, say, shafts=False, kept=[kept])
        search = Search(found)
        beyond = confirmed(search, look_beyond(search, say, ROUNDS))
        if beyond.evidence:
            return _rest(beyond, plant, known)
        if not beyond.dropped:  # none was chosen at all
            break
    return Rest()


def _rest(beyond: Beyond, plant: Mapping[str, float], known: Mapping[str, Mapping[str, float]]) -> Rest:
    terms = beyond.evidence
    effects, left = effects_of(terms)
    effects = together(effects, at_start(terms, plant))
    constant = {CONSTANT[term.family.name] for term in terms if term.family.name in CONSTANT} - set(known)
    beside: dict[str, Array] = {}
    for name in beyond.found.named:
        term = beyond.found.term(name)
        if term.hypothesis is None or term.effect == SHAFT:
            continue
        if term.effect in constant:  # the term of the time goes on from there
            size = term.hypothesis.to_params(beyond.found.point[name])["torque_nm"]
            effects = together(effects, {term.effect: {"torque_nm": size}})
        else:
            beside[term.effect] = beyond.found.point[name]
    return Rest(terms, bounded(effects), tuple(left), beside)


def turning_records(case: Case) -> dict[str, Signals]:
    """The records in which the shaft turns, of one rate, in their order, on one clock."""
    starts, found = case.starts_s(), {}
    for name, record in case.experiments.items():
        if name in LOCKED:
            continue
        columns = {key: np.array(record[key], dtype=np.float64) for key in COLUMNS}
        columns["theta_m_rad"] = np.unwrap(columns["theta_m_rad"])
        columns["t_s"] = record["t_s"] - record["t_s"][0] + starts[name]
        found[name] = signals_of(name, columns)
    if not found:
        return {}
    period_s = float(np.median([part.period_s for part in found.values()]))
    return {name: part for name, part in found.items() if math.isclose(part.period_s, period_s, rel_tol=SAME_RATE)}
