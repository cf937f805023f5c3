"""Corrections tried on a drive: the experiments that show what the effects spoil, before and after.

What does not help is taken back. Whatever goes wrong, the drive gets its old parameters, or the error says which ones
it has.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from evenspin.bench.client import Drive
from evenspin.bench.config import shortest
from evenspin.bench.errors import LinkLostError
from evenspin.bench.experiments import ExperimentList
from evenspin.bench.operator import Operator
from evenspin.bench.runner import Performed, perform
from evenspin.correct.changes import Change, composed
from evenspin.correct.fitting import check_fitting
from evenspin.correct.predict import designed, reduction
from evenspin.correct.proposal import Correction, Proposal
from evenspin.correct.quantities import KINDS, Quantity
from evenspin.correct.quantities import Drive as Known
from evenspin.errors import EvenspinError
from evenspin.native import Field

HELPS = 0.95  # of the quantity before: what leaves more did not help
UNEVEN = 1.25  # of all ripple of the speed before: what makes more does harm
ROUNDS = 3
BESIDE = Quantity("unevenness", ("staircase", "staircase_load"))

Raw = Callable[[str], Path | None]  # a folder for the recordings of a run, by the name of the run
Progress = Callable[[str, float], None]
Say = Callable[[str], None]


class TrialError(EvenspinError):
    """Something went wrong while parameters were changed; the text says which ones the drive has now."""

    def __init__(self, text: str, exit_code: int) -> None:
        super().__init__(text)
        self.exit_code = exit_code


@dataclass(frozen=True, slots=True)
class Row:
    """One correction: its quantity before and after, and whether the drive keeps it."""

    correction: Correction
    before: float
    after: float  # with it in the drive, at the last run that had it
    kept: bool
    why: str  # it was taken back

    @property
    def reduction(self) -> float:
        """Of the quantity as it was measured."""
        return 1.0 - self.after / self.before if self.before > 0.0 else math.nan

    @property
    def of_effect(self) -> float:
        """Of what stands above a healthy machine, as far as simulation says what that has."""
        healthy = self.correction.predicted.healthy
        return reduction(self.before, self.after, healthy if math.isfinite(healthy) else 0.0)

    @property
    def agreement(self) -> float:
        """Predicted change over the measured one."""
        p = self.correction.predicted
        return (p.without - p.corrected) / (self.before - self.after) if self.before != self.after else math.nan


@dataclass(frozen=True, slots=True)
class Trial:
    rows: tuple[Row, ...]
    runs: Mapping[str, Performed]  # before, after, after-2, ...
    values_before: Mapping[str, float]  # of all parameters that were tried
    values: Mapping[str, float]  # of the same parameters, in the drive now
    uneven: tuple[float, float]  # all ripple of the speed before and after, r/min; nan where no run shows it

    @property
    def kept(self) -> tuple[str, ...]:
        return tuple(row.correction.name for row in self.rows if row.kept)


def run_trial(
    drive: Drive, operator: Operator, proposal: Proposal, what: ExperimentList, progress: Progress, say: Say, raw: Raw
) -> Trial:
    """Before, all corrections, and again without those that did not help."""
    held = drive.get()
    check_fitting(proposal.corrections, held, drive.parameters)
    values = _rounded(composed(_changes(proposal.corrections), held))
    before = {name: held[name] for name in values}
    runs = {"before": _performed(drive, operator, what, progress, say, raw("before"))}
    measure = _Measure(runs["before"])
    first = {c.name: measure.of(c.spoils, runs["before"]) for c in proposal.corrections}
    after = dict.fromkeys(first, math.nan)
    why = dict.fromkeys(first, "")
    kept = list(proposal.corrections)
    uneven = (measure.of(BESIDE, runs["before"]), math.nan)
    with _Guarded(drive, before, say) as guarded:
        for number in range(1, ROUNDS + 1):
            guarded.put(_rounded(composed(_changes(kept), held)))
            label = "after" if number == 1 else f"after-{number}"
            runs[label] = _performed(drive, operator, what, progress, say, raw(label))
            after |= {c.name: measure.of(c.spoils, runs[label]) for c in kept}
            uneven = (uneven[0], measure.of(BESIDE, runs[label]))
            found = _harm(kept, first, after, uneven)
            why |= found
            kept = [c for c in kept if not why[c.name]]
            for name, reason in found.items():
                say(f"{name}: taken back: {reason}")
            if not found or not kept:
                break
        else:
            why |= {c.name: "what is beside it was taken back, and it was not tried alone" for c in kept}
            kept = []
        if not kept:
            guarded.back()
        now = drive.get(list(before))
        guarded.done()
    rows = tuple(Row(c, first[c.name], after[c.name], not why[c.name], why[c.name]) for c in proposal.corrections)
    return Trial(rows, runs, before, now, uneven)


def _changes(corrections: Sequence[Correction]) -> dict[str, tuple[Change, ...]]:
    return {correction.name: correction.changes for correction in corrections}


def _rounded(values: Mapping[str, float]) -> dict[str, float]:
    return {name: shortest(value) for name, value in values.items()}


def _harm(
    kept: Sequence[Correction], before: Mapping[str, float], after: Mapping[str, float], uneven: tuple[float, float]
) -> dict[str, str]:
    """Why corrections are taken back, by their names."""
    found = {}
    for each in kept:
        one, other = before[each.name], after[each.name]
        if not (math.isfinite(one) and math.isfinite(other)):
            found[each.name] = f"the records do not show {each.spoils.what}"
        elif not other <= HELPS * one:
            found[each.name] = f"{each.spoils.what} went from {one:.3g} to {other:.3g} {each.spoils.unit}"
    if not found and math.isfinite(uneven[0]) and uneven[1] > UNEVEN * uneven[0]:
        return {c.name: f"all ripple of the speed went from {uneven[0]:.3g} to {uneven[1]:.3g} r/min" for c in kept}
    return found


class _Measure:
    """Quantities of what was performed; the designed drive is that of the run before any change."""

    def __init__(self, before: Performed) -> None:
        self._meta = before.meta

    def of(self, quantity: Quantity, performed: Performed) -> float:
        records = {name: r for name, r in performed.records.items() if name in quantity.records}
        needs = KINDS[quantity.kind].designed
        reference = designed(Path("records"), self._meta, records) if needs and records else {}
        return quantity.measured(records, Known.of(self._meta, reference))


def _performed(
    drive: Drive, operator: Operator, what: ExperimentList, progress: Progress, say: Say, raw: Path | None
) -> Performed:
    if raw is not None:
        raw.mkdir(parents=True, exist_ok=True)
    done = perform(drive, operator, what, progress, say, raw)
    if done.ended_by is not None:
        raise done.ended_by
    return done


class _Guarded:
    """While parameters are changed: any end but `done` puts the old ones back, or says which ones the drive has."""

    def __init__(self, drive: Drive, before: Mapping[str, float], say: Say) -> None:
        self._drive, self._before, self._say = drive, dict(before), say
        self._now: dict[str, float] = {}
        self._done = False

    def __enter__(self) -> _Guarded:
        return self

    def put(self, values: Mapping[str, float]) -> None:
        wanted = {**self._before, **values}
        self._now = wanted
        self._drive.set(wanted)

    def back(self) -> None:
        self.put({})

    def done(self) -> None:
        self._done = True

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if self._done or error is None:
            return
        text = str(error) or "interrupted"
        status = getattr(error, "exit_code", 130 if isinstance(error, KeyboardInterrupt) else 1)
        raise TrialError(f"{text}; {self._restored(error)}", status) from error

    def _restored(self, error: BaseException) -> str:
        if not isinstance(error, LinkLostError) and not self._drive.link.lost:
            try:
                self._drive.stop()
                self._drive.set(self._before)
                return "the drive has the parameters from before again"
            except EvenspinError:
                pass
        return (
            f"the drive may still have {self._listed(self._now)}, and nothing was saved: switch it off, or put back "
            f"what it had: `evenspin bench set {self._listed(self._before)}`"
        )

    def _listed(self, values: Mapping[str, float]) -> str:
        fields = self._drive.parameters
        return " ".join(f"{name}={shown(fields[name], value)}" for name, value in values.items())


def shown(field: Field, value: float) -> str:
    """As `evenspin bench set` takes it."""
    return field.to_text(value) if field.kind in ("choice", "flag") else f"{shortest(value):.9g}"


def only(proposal: Proposal, names: Sequence[str]) -> Proposal:
    """The corrections of these names."""
    return replace(proposal, corrections=tuple(c for c in proposal.corrections if c.name in names))
