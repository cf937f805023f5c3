"""Everything that is known about a case after its investigation; what is written and drawn is made from this alone."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.ambiguities import Ambiguity, ambiguities
from evenspin.gap.candidate import Model
from evenspin.gap.finding import Finding, alternatives
from evenspin.gap.intervals import Intervals, intervals
from evenspin.gap.investigate import Investigation, tolerated
from evenspin.gap.outcome import Outcome, Validation
from evenspin.gap.partial import validated_shares
from evenspin.gap.rest import Rest
from evenspin.gap.rest_model import closed
from evenspin.gap.support import Support, support_of
from evenspin.gap.thresholds_effects import GAIN_MIN, LINE_RATIO, PARTIAL_SPREAD, TOLERATED, VARIES_SPREAD
from evenspin.gap.thresholds_evidence import (
    CONFIDENCE_MAX,
    INSEPARABLE_WEIGHT,
    LEFTOVER_SHARE,
    PERIODIC_RATIO,
    REST_DOUBT,
    UNKNOWN_DOUBT,
    UNKNOWN_RISE,
)
from evenspin.gap.where import Subject, subjects
from evenspin.log.case import Case
from evenspin.log.gap import RecordGap, gap_of_records
from evenspin.log.nominal import Nominal
from evenspin.log.tolerance import SIGMA, TOLERANCES, unit_of
from evenspin.log.unit import Unit
from evenspin.native import tables

Array = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True, slots=True)
class Step:
    """The model after so many effects."""

    names: tuple[str, ...]
    effects: Effects
    delta: Array
    outcome: Outcome
    cost: float


@dataclass(frozen=True, slots=True)
class CaseResult:
    case: Case
    name: str
    finding: Finding
    effects: Effects  # that are named, with all their parameters
    delta: Array  # deviations of the unit
    unit: Unit  # both together: what model.toml holds
    before: Outcome
    after: Outcome
    noise_floor: tuple[RecordGap, ...]
    nearest: Outcome | None  # of an explanation that does not explain
    steps: tuple[Step, ...]
    intervals: Intervals
    residual_before: Array  # in sigmas
    residual_after: Array
    other: tuple[tuple[tuple[str, ...], float], ...]  # explanations and their weights
    ambiguities: tuple[Ambiguity, ...]
    warnings: tuple[str, ...]
    subjects: tuple[Subject, ...]  # what each residual is about
    nominal: Nominal  # machine and drive of the case as they are simulated
    sizes: Mapping[str, float]  # of each effect of the best explanation, in units of what counts as no effect
    nearest_effects: Effects  # parameters of the best explanation, named or not
    seconds: float
    confidence: Mapping[str, float] = field(default_factory=dict)
    shares: Mapping[str, float] = field(default_factory=dict)  # of the squared gap on validation records, of each name
    support: Mapping[str, tuple[Support, ...]] = field(default_factory=dict)  # features that speak for each name
    rest: Rest = field(default_factory=Rest)  # terms for what no known effect explains; none where nothing is left
    known: Outcome | None = None  # with the known effects alone, where there are terms beside them
    rest_cost: float | None = None  # of the fit records, with these terms

    @property
    def verdict(self) -> tuple[str, ...]:
        """Names, strongest first; `unknown` stands for what they leave."""
        return (*self.finding.named, *(("unknown",) if self.finding.unknown else ()))

    @property
    def partial(self) -> bool:
        return self.finding.unknown and bool(self.finding.named)

    @property
    def closed(self) -> float:
        """Share of the gap above the noise floor that is closed; nan where there is none to close."""
        noise_floor = gap_of_records(self.noise_floor)
        wide = self.before.gap - noise_floor
        return (self.before.gap - self.after.gap) / wide if wide > 0.0 else math.nan


def investigate(
    case: Case,
    workers: int | None = None,
    progress: Callable[[str, float], None] | None = None,
    warnings: tuple[str, ...] = (),
) -> CaseResult:
    """Find, name, add, validate."""
    started = time.monotonic()
    say = progress or (lambda what, share: None)
    investigation = Investigation(case, workers, lambda what, share: say(what, 0.9 * share))
    try:
        early = investigation.without_tones(PERIODIC_RATIO)
        finding = investigation.run()
        if finding.unknown and not early and investigation.without_tones(LINE_RATIO, finding.model):
            finding = investigation.run()
        say("validating", 0.9)
        return result_of(case, investigation, finding, warnings, started, say)
    finally:
        investigation.forward.close()


def result_of(
    case: Case,
    investigation: Investigation,
    finding: Finding,
    warnings: tuple[str, ...] = (),
    started: float = 0.0,
    say: Callable[[str, float], None] = lambda what, share: None,
) -> CaseResult:
    """The validation of a finding; `started`: time.monotonic() when the work began."""
    fitter, model = investigation.search.fitter, finding.model
    effects = fitter.effects({name: model.z[name] for name in finding.named})
    # where nothing known explains the log, what the fit did to the machine explains nothing either
    nothing_stands = finding.unknown and not finding.named
    delta = np.zeros(len(SIGMA)) if nothing_stands else tolerated(model.delta) if finding.unknown else model.delta
    unit = Unit() if nothing_stands else unit_of(effects, delta)
    validation = Validation(case)
    before = validation.outcome(Unit())
    after = before if nothing_stands else validation.outcome(unit)
    nearest = validation.outcome(unit_of(fitter.effects(model.z), model.delta)) if nothing_stands else None
    beyond = closed(investigation, finding, validation, after, say) if finding.unknown and before.traces else None
    known, gap_of, left = after, investigation.gap_of(model), model
    sizes = {name: investigation.library[name].magnitude(z) for name, z in model.z.items()}
    if beyond is not None:
        finding, left, gap_of, nearest = beyond.finding, beyond.model, beyond.gap_of, None
        effects, delta, unit, after = beyond.effects, beyond.delta, beyond.unit, beyond.after
        sizes |= {name: investigation.library[name].magnitude(z) for name, z in left.z.items()}
    found = intervals(beyond.fitter, left) if beyond is not None and left.z else intervals(fitter, model)
    if finding.unknown and finding.named:  # what is left biases every parameter by as much as it can
        found = found.widened(math.sqrt(max(1.0, left.cost / finding.expected_cost.mean)))
    shares = validated_shares(finding.named, gap_of)
    other = () if beyond is not None else tuple(alternatives(finding))  # those were weighed without the terms
    unclear = tuple(ambiguities(case.experiments, case.meta["motor"]))
    messages = [*warnings, *(str(each) for each in unclear), *found.warnings(), *_intolerant(delta)]
    if not before.traces:
        messages.append("no validation record: the gap is not known, and nothing is validated")
    if not finding.unknown and finding.expected_cost.is_significant(model.cost):
        share = finding.expected_cost.excess(model.cost) / finding.expected_cost.mean
        messages.append(f"what is left is {100.0 * share:.0f} % more than noise: something smaller may be missing, too")
    if before.traces and effects and not after.gap < before.gap:
        messages.append("what was named does not make the gap on the validation records smaller: do not trust it")
    nothing = investigation.search.nothing.residual
    about = subjects(investigation.forward.keys, (each.layout for each in investigation.forward.sets))
    return CaseResult(
        case,
        str(case.meta.get("case", case.path.name)),
        finding,
        effects,
        delta,
        unit,
        before,
        after,
        validation.noise_floor(unit),
        nearest,
        tuple(_step(investigation, validation, each) for each in finding.steps),
        found,
        nothing,
        left.residual,
        other,
        unclear,
        tuple(dict.fromkeys(messages)),
        about,
        investigation.forward.replays[0].nominal,
        sizes,
        fitter.effects(model.z),
        time.monotonic() - started,
        confidence(finding, other),
        shares,
        {name: support_of(finding, name, nothing, about) for name in finding.named},
        Rest() if beyond is None else beyond.rest,
        None if beyond is None else known,
        None if beyond is None else left.cost,
    )


def _step(investigation: Investigation, validation: Validation, model: Model) -> Step:
    effects = investigation.search.fitter.effects(model.z)
    return Step(model.names, effects, model.delta, validation.outcome(unit_of(effects, model.delta)), model.cost)


def _intolerant(delta: Array) -> list[str]:
    return [
        f"{t.name}: this unit is {abs(d) / t.sigma:.1f} standard deviations of the tolerance off its data sheet"
        for t, d in zip(TOLERANCES, delta, strict=True)
        if abs(d) > TOLERATED * t.sigma
    ]


def confidence(finding: Finding, other: tuple[tuple[tuple[str, ...], float], ...]) -> dict[str, float]:
    """How likely each name is right. `evenspin gap blind score` holds it against the truth of blind cases.

    A name stands less firm when other explanations do without it, when what it takes away could be chance or what a
    larger effect leaves because the machine has it a little differently, and when the residual is near the noise.
    """
    excess = finding.expected_cost.excess(finding.model.cost)
    nearly = excess / max(finding.expected_cost.limit, 1.0)
    nearly = max([nearly, *(finding.size_spread[name] / VARIES_SPREAD for name in finding.changes)])
    unknown = CONFIDENCE_MAX * (1.0 - UNKNOWN_DOUBT * math.exp(-UNKNOWN_RISE * max(0.0, nearly - 1.0)))
    if finding.unknown and not finding.named:
        return {"unknown": unknown}
    total = sum(max(gain, 0.0) for gain in finding.weights.values()) or 1.0
    out = {}
    for name in finding.named:
        against = sum(weight for names, weight in other if name not in names)
        gain = max(finding.weights.get(name, 0.0), 0.0)
        real = (1.0 - math.exp(-gain / GAIN_MIN)) * (1.0 - math.exp(-gain / (LEFTOVER_SHARE * total)))
        doubt = REST_DOUBT * min(max(nearly, 0.0), 1.0) ** 2
        if finding.unknown:  # what is left need not speak against a name that has one size over the log
            doubt = REST_DOUBT * min(finding.size_spread[name] / PARTIAL_SPREAD, 1.0) ** 2
        out[name] = CONFIDENCE_MAX * (1.0 - against) * real * (1.0 - doubt)
    return out | ({"unknown": unknown} if finding.unknown else {})


def inseparable(result: CaseResult, name: str) -> tuple[str, ...]:
    """What else it may be, as far as these experiments can show."""
    partners = [p for each in result.ambiguities if name in each.effects for p in each.effects if p != name]
    near = [n for names, weight in result.other if weight > INSEPARABLE_WEIGHT and name not in names for n in names]
    return tuple(dict.fromkeys(n for n in (*partners, *near) if n not in result.finding.named))


def separator(name: str) -> str:
    """The experiments that make an effect identifiable, and what separates it from similar effects."""
    effect = tables().effects[name]
    shown = ", ".join(f"{name} {condition}".strip() for name, condition in effect.shown_by.items()) or "any"
    return f"{shown}: {effect.told_apart}" if effect.told_apart else shown
