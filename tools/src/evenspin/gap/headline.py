"""The story of a case in a few sentences: what is missing, how much it explains, what is left, how sure that is."""

from __future__ import annotations

from evenspin.empirical.words import sentence
from evenspin.gap.intervals import reported_parameters
from evenspin.gap.result import CaseResult, inseparable, separator
from evenspin.gap.thresholds_evidence import OPEN_GAP
from evenspin.gap.verdict import because
from evenspin.gap.where import ranked
from evenspin.log.gap import gap_of_records
from evenspin.native import tables


def summary_of(result: CaseResult) -> list[str]:
    """One thing a sentence, the most important first."""
    terms = [f"{start(sentence(term))}." for term in result.rest.terms]
    sentences = [
        _missing(result),
        *terms,
        *_explained(result),
        _left(result),
        *(f"{start(r)}." for r in because(result)),
    ]
    return [*sentences, *(_settled_by(result, name) for name in result.finding.named if inseparable(result, name))]


def numbers_of(result: CaseResult, name: str) -> str:
    """Parameters with units and the half of their 95 % intervals."""
    halves = {interval.parameter: interval.half for interval in result.intervals.of(name)}
    fields = tables().effects[name].params
    sentences = []
    for key, value in reported_parameters(name, result.effects[name]).items():
        unit = fields[key].unit if key in fields else ""
        half = f" +- {halves[key]:.2g}" if halves.get(key) else ""
        sentences.append(f"{key} = {value:.4g}{half}{' ' + unit if unit else ''}")
    return ", ".join(sentences)


def is_open(result: CaseResult) -> bool:
    """Whether there was a gap to close, and something was named that may have closed it."""
    known = not result.finding.unknown or bool(result.finding.named) or bool(result.rest.effects)
    return known and result.before.gap > OPEN_GAP * gap_of_records(result.noise_floor)


def start(text: str) -> str:
    return text[:1].upper() + text[1:]


def _missing(result: CaseResult) -> str:
    finding = result.finding
    if finding.named:
        named = "; ".join(
            f"{name} ({numbers_of(result, name)}; {100.0 * result.confidence[name]:.0f} % sure)"
            for name in finding.named
        )
        return f"Missing in the model: {named}."
    if finding.unknown:
        sure = 100.0 * result.confidence["unknown"]
        described = " What it depends on:" if result.rest.terms else ""
        return f"Something is missing that no known effect explains: unknown ({sure:.0f} % sure).{described}"
    return "Nothing is missing: the nominal machine within its tolerance explains the log."


def _explained(result: CaseResult) -> list[str]:
    if not result.before.traces:
        return []
    floor = gap_of_records(result.noise_floor)
    gaps = f"{result.before.gap:.3f} before, {result.after.gap:.3f} after, {floor:.3f} by noise alone"
    where = "on validation records, which nothing was fitted to"
    if not is_open(result):
        return [f"Gap {where}: {gaps}."]
    share = 100.0 * min(1.0, result.closed)
    return [f"With that {share:.0f} % of the gap above noise is explained: {gaps} ({where})."]


def _left(result: CaseResult) -> str:
    finding = result.finding
    if not finding.unknown:
        share = finding.expected_cost.excess(finding.model.cost) / finding.expected_cost.mean
        more = finding.expected_cost.is_significant(finding.model.cost)
        return f"What is left is {100.0 * share:.0f} % more than noise." if more else "What is left is noise."
    most = ranked(result.subjects, result.residual_after, result.residual_after)[0]
    at = f" at {most.strongest}" if most.strongest else ""
    place = f"largest in {most.signal} of {most.record}, {most.what}{at}: {most.after:.1f} times the noise"
    if result.rest.terms:
        return f"What is left beside that is {place}."
    if finding.named:
        sure = 100.0 * result.confidence["unknown"]
        return f"Beside that something is left that no known effect explains, {place}; unknown ({sure:.0f} % sure)."
    return f"What is left is {place}."


def _settled_by(result: CaseResult, name: str) -> str:
    return f"{name} may also be {' or '.join(inseparable(result, name))}; what would settle it: {separator(name)}"
