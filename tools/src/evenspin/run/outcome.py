"""What became of a run: did the drive run at all, did it trip, does it oscillate?

Ripple is tied to the angle of the rotor: sensor errors, cogging, dead time and eccentricity repeat turn by turn. An
unstable loop has a frequency of its own, and ends at its limits. So in the steady part of each stretch the q current is
examined without whatever repeats over the mechanical turn (1): more than OWN_PART of the limit of the current that
does not die away, or a reference that swings between both limits, is an oscillation. Below that nothing is reported.

    i_q(t) = mean + slope t + sum over n of a_n cos(n theta) + b_n sin(n theta) + what is left            (1)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.segments import Segment, segments
from evenspin.model.setup import Setup
from evenspin.native import tables
from evenspin.sim.record import Record

Array = NDArray[np.float64]

STATES = ("INIT", "OFFSET_CALIBRATION", "ALIGN", "READY", "RUN", "FAULT")
RUN = STATES.index("RUN")
OWN_PART = 0.05  # of iq_limit_a, rms
DYING = 0.7  # second half of the window over the first: below, it dies away
AT_LIMIT = 0.98
SWINGS = 4  # from limit to limit
LEAST_TURNS = 3.0  # fewer do not separate an order from a frequency
ORDERS, LEAST_ROWS, MOST_ROWS = 80, 200, 1600
ROWS_PER_ORDER = 12  # two unknowns each


@dataclass(frozen=True, slots=True)
class Outcome:
    """`word`: ran, stayed, tripped or oscillates; `text`: one line for a person, empty when it ran."""

    word: str
    text: str = ""
    t_s: float | None = None

    @property
    def good(self) -> bool:
        return self.word == "ran"

    def as_json(self) -> dict[str, Any]:
        return {"result": self.word, "text": self.text, "t_s": self.t_s}


def outcome_of(setup: Setup, record: Record) -> Outcome:
    """The first thing that went wrong."""
    if (early := _stopped(setup, record)) is not None:
        return early
    for segment in segments(setup):
        steady = record.between(segment.steady_s, segment.end_s)
        found = _oscillation(setup, steady, segment) if (steady["state"] == RUN).all() else ""
        if found:
            return Outcome("oscillates", found, segment.steady_s)
    return Outcome("ran")


def stopped(setup: Setup, record: Record) -> str:
    """Why the drive did not run to the end; "" when it did. Reads `state` and `fault` only."""
    found = _stopped(setup, record)
    return "" if found is None else found.text


def _stopped(setup: Setup, record: Record) -> Outcome | None:
    tripped = record["fault"] > 0.0
    if tripped.any():
        row = int(tripped.argmax())
        fault, t_s = tables().faults[int(record["fault"][row])], float(record["t_s"][row])
        text = f"The drive tripped at {t_s:g} s: {fault.name}. {fault.cause} Check first: {fault.check}"
        return Outcome("tripped", text, t_s)
    running = record["state"] == RUN
    if not running.any():
        state = STATES[int(record["state"][-1])]
        hint = "" if setup.drive["auto_run"] else "; nothing starts it: set auto_run = true in [drive]"
        more = "" if hint else "; calibration and alignment did not end within duration_s"
        return Outcome("stayed", f"The drive never ran: it stayed in {state}{hint}{more}.")
    return None


def _oscillation(setup: Setup, steady: Record, segment: Segment) -> str:
    """Empty when there is none that can be distinguished from ripple."""
    if len(steady) < LEAST_ROWS:
        return ""
    limit_a = setup.drive["iq_limit_a"]
    where = f"from {segment.steady_s:.4g} to {segment.end_s:.4g} s"
    advice = "check the gains: `evenspin design rc --model MODEL` judges the speed loop"
    if swings(steady["iq_ref_a"], limit_a) >= SWINGS:
        return f"The drive oscillates: {where} the q-current reference swings between both limits; {advice}."
    own_a = own_current(steady)
    if own_a is None or not own_a > OWN_PART * limit_a:
        return ""
    what = f"{own_a:.3g} A rms of q current that neither repeats over the turn nor dies away"
    return f"The drive oscillates: {where} {what}; {advice}."


def swings(reference_a: Array, limit_a: float) -> int:
    """How often it goes from one limit to the other."""
    ends = np.sign(reference_a[np.abs(reference_a) >= AT_LIMIT * limit_a])
    return int(np.count_nonzero(np.diff(ends)))


def own_current(steady: Record) -> float | None:
    """rms of the q current without (1), A; 0 when it dies away, None when the rotor turns too little to decide."""
    every = -(-len(steady) // MOST_ROWS)
    theta = np.unwrap(steady["true_theta_m_rad"])[::every]
    current = steady["true_iq_a"][::every]
    rows = len(theta)
    if abs(theta[-1] - theta[0]) < LEAST_TURNS * 2.0 * np.pi:
        return None
    angles = np.outer(theta, np.arange(1, min(ORDERS, rows // ROWS_PER_ORDER) + 1))
    basis = np.column_stack((np.ones(rows), np.linspace(-1.0, 1.0, rows), np.cos(angles), np.sin(angles)))
    square = basis.T @ basis
    square[np.diag_indices_from(square)] *= 1.0 + 1e-9  # orders that cannot be separated in these rows
    left = current - basis @ np.linalg.solve(square, basis.T @ current)
    half = rows // 2
    early, late = float(left[:half].std()), float(left[half:].std())
    return late if late > DYING * early else 0.0
