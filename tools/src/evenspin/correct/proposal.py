"""What is proposed for the causes that a verdict names, and what is not, with the reason. No harm first: a correction
that the intervals leave in doubt is none."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from evenspin.correct.changes import Change
from evenspin.correct.found import Found
from evenspin.correct.predict import Prediction, Simulated
from evenspin.correct.quantities import Quantity
from evenspin.correct.rules import LINES, NoRule, Rule, line_changes, rule_of
from evenspin.errors import EvenspinError
from evenspin.gap.result import CaseResult
from evenspin.log.case import Case

WORTH = 0.25  # least share of what the effects add that a correction must take away to be proposed...
SEEN = 0.1  # ...and of the quantity as it is measured
STEADY = ("speed_ripple", "commutation")  # what any steady stretch shows
INSTEAD = {"staircase": "staircase_load"}
MORE = 1.05  # of what a correction must not make larger
SURE = 1.0  # of the quantity without it: a machine at an end of the intervals must not end up above this

Progress = Callable[[float], None]


@dataclass(frozen=True, slots=True)
class Correction:
    """Of one effect, or of several that are counteracted together."""

    name: str
    effects: tuple[str, ...]
    changes: tuple[Change, ...]
    spoils: Quantity
    predicted: Prediction


@dataclass(frozen=True, slots=True)
class NotCorrected:
    effect: str
    reason: str


@dataclass(frozen=True, slots=True)
class Proposal:
    case: str
    verdict: tuple[str, ...]
    corrections: tuple[Correction, ...]
    left: tuple[NotCorrected, ...]

    @property
    def unknown(self) -> bool:
        return "unknown" in self.verdict


def proposal_of(result: CaseResult, progress: Progress = lambda _: None) -> Proposal:
    """What is proposed for the verdict on a case."""
    return propose(result.case, result.name, result.verdict, Found.of(result), progress)


def propose(
    case: Case, name: str, verdict: Sequence[str], found: Found, progress: Progress = lambda _: None
) -> Proposal:
    """From named effects to corrections whose effect on their own quantity has been simulated."""
    named = [effect for effect in verdict if effect in found.effects]
    left = [NotCorrected(effect, rule.reason) for effect in named if isinstance(rule := rule_of(effect), NoRule)]
    drafts = [replace(draft, spoils=_recorded(case, draft.spoils)) for draft in _drafts(found, named, left)]
    simulated = Simulated(case, found)
    kept: list[Correction] = []
    for number, draft in enumerate(drafts):
        progress(number / len(drafts))
        reason = _missing(case, draft)
        predicted = None
        if not reason:
            try:
                draft = _tuned(simulated, draft)
                predicted = simulated.predict(draft.spoils, {draft.name: draft.changes}, draft.effects)
                reason = _doubt(draft, predicted) or _harm(simulated, draft)
            except EvenspinError as error:
                reason = f"the drive refuses it: {error.bare}"
        if reason or predicted is None:
            left += [NotCorrected(effect, reason) for effect in draft.effects]
        else:
            kept.append(Correction(draft.name, draft.effects, draft.changes, draft.spoils, predicted))
    corrections = _together(simulated, kept, left)
    return Proposal(name, tuple(verdict), corrections, tuple(left))


@dataclass(frozen=True, slots=True)
class _Draft:
    name: str
    effects: tuple[str, ...]
    changes: tuple[Change, ...]
    spoils: Quantity


def _drafts(found: Found, named: Sequence[str], left: list[NotCorrected]) -> list[_Draft]:
    groups: dict[str, list[str]] = {}
    for effect in named:
        rule = rule_of(effect)
        if isinstance(rule, Rule):
            groups.setdefault(rule.group or effect, []).append(effect)
    drafts, line = [], 1
    for name, effects in groups.items():
        rule = rule_of(effects[0])
        assert isinstance(rule, Rule)
        if reason := rule.unless(found, effects):
            left += [NotCorrected(effect, reason) for effect in effects]
            continue
        changes = rule.changes(found, effects)
        if rule.lines is not None:
            lines = rule.lines(found, effects[0])
            if line + len(lines) - 1 > LINES:
                left.append(
                    NotCorrected(name, f"the drive has {LINES} lines of torque over the angle, and others use them")
                )
                continue
            changes += line_changes(lines, line)
            line += len(lines)
        drafts.append(_Draft(name, tuple(effects), tuple(changes), rule.spoils(found, effects)))
    return drafts


def _tuned(simulated: Simulated, draft: _Draft) -> _Draft:
    """With the parameter that simulation chooses, where the rule has one."""
    rule = rule_of(draft.effects[0])
    if not isinstance(rule, Rule) or rule.chosen is None:
        return draft
    quantity = draft.spoils
    if rule.beside is not None:
        quantity = replace(quantity, records=(*quantity.records, *rule.beside(simulated.found, draft.effects).records))
    chosen = simulated.best(quantity, draft.changes, rule.chosen(simulated.found))
    return replace(draft, changes=(*draft.changes, *chosen))


def _harm(simulated: Simulated, draft: _Draft) -> str:
    """What the correction makes larger beside; empty where it is nothing."""
    rule = rule_of(draft.effects[0])
    if not isinstance(rule, Rule) or rule.beside is None:
        return ""
    quantity = rule.beside(simulated.found, draft.effects)
    without, corrected = simulated.grows(quantity, draft.changes)
    where = " or ".join(quantity.records)
    if not math.isfinite(without) or not math.isfinite(corrected):
        return f"what it may do beside ({quantity.what}) shows in {where}, which was not recorded"
    if corrected > MORE * without:
        return f"{quantity.what} in {where} would grow from {without:.3g} to {corrected:.3g} {quantity.unit}"
    return ""


def _recorded(case: Case, spoils: Quantity) -> Quantity:
    """From other records where its own were not recorded, or were left out because they did not start at rest."""
    if spoils.kind not in STEADY or any(name in case.experiments for name in spoils.records):
        return spoils
    return replace(spoils, records=tuple(INSTEAD.get(name, name) for name in spoils.records))


def _missing(case: Case, draft: _Draft) -> str:
    if any(name in case.experiments for name in draft.spoils.records):
        return ""
    return f"what it spoils ({draft.spoils.what}) shows in {' or '.join(draft.spoils.records)}, which was not recorded"


def _doubt(draft: _Draft | Correction, predicted: Prediction) -> str:
    """Why it is not proposed; empty where it is."""
    unit, what = draft.spoils.unit, draft.spoils.what
    if not math.isfinite(predicted.without) or not math.isfinite(predicted.corrected):
        return f"the records do not show what it spoils ({what})"
    if predicted.high > SURE * predicted.without:
        return (
            f"uncertain: at an end of its interval the correction would make {predicted.high:.3g} {unit} of "
            f"{predicted.without:.3g} {unit} ({what})"
        )
    if predicted.reduction < WORTH or predicted.corrected > (1.0 - SEEN) * predicted.without:
        return f"not worth it: {what} would be {predicted.corrected:.3g} instead of {predicted.without:.3g} {unit}"
    if predicted.high > SURE * predicted.without_low:
        chance = f"{what} may be {predicted.without_low:.3g} {unit} by chance alone"
        return f"uncertain: {chance}, and up to {predicted.high:.3g} {unit} with the correction"
    return ""


def _together(simulated: Simulated, kept: list[Correction], left: list[NotCorrected]) -> tuple[Correction, ...]:
    """The prediction of each with all of them in the drive: that is what will be measured.

    One that the others spoil is left out; of several, that which takes away least.
    """
    while len(kept) > 1:
        all_of_them = {each.name: each.changes for each in kept}
        kept = [replace(c, predicted=simulated.predict(c.spoils, all_of_them, c.effects)) for c in kept]
        doubts = {each.name: _doubt(each, each.predicted) for each in kept}
        if not any(doubts.values()):
            break
        worst = min((each for each in kept if doubts[each.name]), key=lambda each: each.predicted.reduction)
        beside = ", ".join(each.name for each in kept if each is not worst)
        left += [
            NotCorrected(effect, f"beside the correction of {beside} {doubts[worst.name]}") for effect in worst.effects
        ]
        alone = [each for each in kept if each is not worst]
        kept = [replace(c, predicted=simulated.predict(c.spoils, {c.name: c.changes}, c.effects)) for c in alone]
    return tuple(kept)
