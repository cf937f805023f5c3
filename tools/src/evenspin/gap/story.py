"""The report of a case as a story: where the gap is, what explains it, how much it shrinks, what is left."""

from __future__ import annotations

import math

from evenspin.empirical.pictures import term_pictures, terms_view
from evenspin.gap.finding import Finding
from evenspin.gap.headline import is_open, numbers_of, start, summary_of
from evenspin.gap.pictures import (
    gap_pictures,
    left_pictures,
    much_pictures,
    new_effect,
    tried_costs,
    what_pictures,
    where_pictures,
    words_of,
)
from evenspin.gap.result import CaseResult, inseparable, separator
from evenspin.gap.thresholds_effects import GAIN_MIN, LINE_RATIO
from evenspin.gap.verdict import because
from evenspin.gap.where import Contribution, ranked
from evenspin.log.gap import GAP_SIGNALS, GAP_UNITS
from evenspin.native import tables
from evenspin.report.figures import Picture
from evenspin.report.page import Chapter, Page
from evenspin.tableview import TableView, number

RANKED_ROWS = 12
LINES = 8


def page_of(result: CaseResult, command: str) -> Page:
    motor = result.case.meta["motor"]
    facts = [
        (
            "motor",
            f"{motor['pole_pairs']:g} pole pairs, {motor['rated_torque_nm']:g} N m, {motor['rated_current_a']:g} A",
        ),
        ("experiments", ", ".join(result.case.experiments)),
        ("work", f"{result.finding.simulations} simulations of the log in {result.seconds:.0f} s"),
    ]
    return Page(
        title=f"Gap: {result.name}",
        summary="\n".join(summary_of(result)),
        facts=facts,
        tables=[_notes(result)] if result.warnings else [],
        pictures=gap_pictures(result),
        command=command,
        chapters=[_where(result), _what(result), *_beyond(result), _how_much(result), _left(result)],
    )


def tables_of(result: CaseResult) -> list[TableView]:
    """For the terminal."""
    tables = [_effects(result)] if result.finding.named else []
    if result.before.traces:
        tables.append(_gap_table(result))
    if result.rest.terms:
        tables.append(terms_view(result.rest.terms))
    return [*tables, _notes(result)] if result.warnings else tables


def _where(result: CaseResult) -> Chapter:
    contributions = ranked(result.subjects, result.residual_before, result.residual_after)[:RANKED_ROWS]
    text = (
        "The log is reduced to features: mean, trend and angle orders of every steady stretch, short bins "
        "after every step and along every ramp. Each is compared with a closed-loop simulation of the nominal "
        "machine, and the difference is given in standard deviations of what healthy units scatter. The validation "
        "records take no part."
    )
    table = _contributions(contributions, result)
    return Chapter("Where is the gap?", text, [table, *where_pictures(result)])


def _contributions(contributions: list[Contribution], result: CaseResult) -> TableView:
    rows = [
        (s.record, s.signal, s.what, s.strongest or "-", f"{100.0 * s.share:.1f}", number(s.before), number(s.after))
        for s in contributions
    ]
    header = ("record", "signal", "what", "strongest at", "share of excess %", "before sigma", "after sigma")
    beyond = result.finding.expected_cost.excess(result.finding.before)
    noise = "" if result.finding.unknown or result.finding.named else " All of it is within noise."
    text = f"sigma: rms residual; 1 is noise. The nominal machine costs {beyond:.0f} more than healthy units do.{noise}"
    return TableView("Ranked by share of the excess", text, header, rows, left=4)


def _what(result: CaseResult) -> Chapter:
    if result.partial:
        text = (
            "What is named has one size over the whole log, and records that no fit has seen are simulated better with "
            "it. Other effects that were tried needed another size in each part of the log, and are not named."
        )
    elif result.finding.unknown:
        text = (
            "No effect is named, because the best explanation leaves more than noise. The names below are what was "
            "tried; none of them is added to the model."
        )
    elif result.finding.named:
        text = "One effect at a time, each refined with the simulation in the loop, then all together."
    else:
        text = (
            "No effect earns a place: none explains a share of the residual and is larger than the tolerance at once."
        )
    parts: list[TableView | Picture] = [_effects(result)] if result.finding.named else []
    parts += [_support(result), _candidates(result), *what_pictures(result), _weighed(result)]
    return Chapter("What explains it?", text, [part for part in parts if not isinstance(part, TableView) or part.rows])


def _effects(result: CaseResult) -> TableView:
    rows = []
    for name in result.finding.named:
        also = inseparable(result, name)
        rows.append(
            (
                name,
                numbers_of(result, name),
                ", ".join(also) or "nothing",
                f"{result.confidence[name]:.3f}",
                f"{result.finding.weights.get(name, math.nan):.0f}",
                f"{result.sizes[name]:.1f}",
            )
        )
    text = (
        f"cost: what the residual grows by without the effect ({GAIN_MIN:g} is the least that counts). size: in "
        "units of the largest deviation that tolerance and format call no effect. Intervals are 95 %."
    )
    header = ("effect", "parameters", "may also be", "confidence", "cost", "size")
    return TableView("Named, strongest first", text, header, rows, left=3)


def _support(result: CaseResult) -> TableView:
    """What speaks for each name, to follow the verdict back into the log."""
    rows = [
        (name, s.record, s.signal, s.what, f"{100.0 * s.share:.0f}", number(s.without), number(s.with_it))
        for name in result.finding.named
        for s in result.support[name]
    ]
    header = ("effect", "record", "signal", "what", "share %", "without sigma", "with it sigma")
    text = "Where the residual grows most when the effect is left out and all others are fitted again; 1 is noise."
    return TableView("What speaks for each name", text, header, rows, left=4)


def _candidates(result: CaseResult) -> TableView:
    """For and against each explanation that was tried."""
    finding = result.finding
    weights = {frozenset(names): weight for names, weight in result.other}
    chosen = frozenset(finding.model.names)
    rows, marks = [], []
    for names, cost in tried_costs(result):
        key = frozenset(names)
        excess = finding.expected_cost.excess(cost)
        if key == chosen:
            why = "does not explain all of the log" if finding.unknown else "chosen" if key else "enough"
        elif key > chosen and not finding.unknown:
            why = "its addition does not earn a place: too little gain, or within tolerance"
        else:
            why = f"leaves {cost - finding.model.cost:.0f} more"
        rows.append((words_of(names), why, f"{cost:.0f}", f"{excess:.0f}", number(weights.get(key))))
        marks.append(("bad" if finding.unknown else "good") if key == chosen else "")
    text = (
        f"Healthy units have a cost of {_expected(finding)} (from simulation); what is beyond is evidence against. "
        "weight: how likely beside the chosen one."
    )
    header = ("explanation", "for or against", "cost", "beyond noise", "weight")
    return TableView("Candidates", text, header, rows, marks, left=2)


def _weighed(result: CaseResult) -> TableView:
    """What each effect in question shows, and what would separate it from its neighbours."""
    names = list(result.finding.model.names)
    for other in (*(names for names, _ in result.other[:3]), *(model.names for model in result.finding.tried[:2])):
        names += [name for name in other if name not in names]
    effects = tables().effects
    names += [n for name in result.finding.named for n in effects[name].confused_with if n not in names]
    rows = [
        (name, effects[name].signature, ", ".join(effects[name].confused_with) or "-", separator(name))
        for name in dict.fromkeys(names)
        if name in effects
    ]
    header = ("effect", "shows as", "confused with", "experiment that separates them, and how")
    return TableView("What would separate them", "The effects in question and their neighbours.", header, rows, left=4)


def _beyond(result: CaseResult) -> list[Chapter]:
    """Terms that no effect of the table is."""
    terms = result.rest.terms
    if not terms:
        return []
    text = (
        "What the known effects leave was held against a library of terms, in the equations of the machine without a "
        "controller. These are the fewest that explain it, and the validation record, which no fit has seen, confirms "
        "each. The model has them as the effect `empirical`."
    )
    if result.rest.not_simulated:
        text += f" Not simulated: {', '.join(result.rest.not_simulated)}."
    return [Chapter("What does it depend on?", text, [terms_view(terms), *term_pictures(terms)])]


def _how_much(result: CaseResult) -> Chapter:
    if not result.before.traces:
        return Chapter("How much does it shrink?", "There is no validation record: this is not known.")
    closed = f"{100.0 * result.closed:.0f} % of what is above the noise floor is closed." if is_open(result) else ""
    text = f"On the validation records the gap goes from {result.before.gap:.3f} to {result.after.gap:.3f}. {closed}"
    if result.nearest is not None and result.finding.model.z and not result.rest.effects:
        text = (
            f"The gap on the validation records stays at {result.before.gap:.3f}: nothing was added. What comes "
            f"nearest, {' and '.join(result.finding.model.names)}, would make it {result.nearest.gap:.3f}."
        )
    return Chapter("How much does it shrink?", text, [_gap_table(result), _steps(result), *much_pictures(result)])


def _gap_table(result: CaseResult) -> TableView:
    header = ("record", "", *(f"{s} [{u}]" for s, u in zip(GAP_SIGNALS, GAP_UNITS, strict=True)), "gap")
    rows = []
    for before, after, noise in zip(result.before.records, result.after.records, result.noise_floor, strict=True):
        for name, gap in (("before", before), ("after", after), ("noise floor", noise)):
            rows.append((gap.record, name, *(f"{gap.rms[s]:.4f}" for s in GAP_SIGNALS), f"{gap.gap:.4f}"))
    text = "rms of simulation less log. Noise floor: the found machine against its own noisy log."
    return TableView("Gap on validation records", text, header, rows)


def _steps(result: CaseResult) -> TableView:
    rows = [("nominal machine", f"{result.finding.before:.0f}", f"{result.before.gap:.4f}")]
    for i, step in enumerate(result.steps):
        what = "its deviations within tolerance" if i == 0 else f"+ {new_effect(result, i)}"
        rows.append((what, f"{step.cost:.0f}", f"{step.outcome.gap:.4f}"))
    text = "One effect at a time. cost: of the fit records, with today's noise level; gap: of the validation records."
    return TableView("Step by step", text, ("model", "cost", "gap"), rows, left=1)


def _left(result: CaseResult) -> Chapter:
    finding = result.finding
    noise = f"The residual costs {finding.model.cost:.0f}; simulated healthy units have {_expected(finding)}."
    if result.rest_cost is not None:
        noise += f" With the terms that no known effect is it costs {result.rest_cost:.0f}."
    text = (
        f"More than noise. {noise} {' '.join(start(t) + '.' for t in because(result))}"
        if finding.unknown
        else f"{noise} That is noise: nothing significant is left."
    )
    left = [line for line in finding.lines if line.ratio > LINE_RATIO][:LINES]
    parts = [_lines(result)] if left else []
    return Chapter("What is left?", text, [*left_pictures(result), *parts])


def _lines(result: CaseResult) -> TableView:
    rows = [
        (
            line.record,
            line.signal,
            f"{line.speed_rad_s * 30.0 / math.pi:.0f}",
            f"{line.hz:.1f}",
            number(line.order),
            number(line.amplitude),
            number(line.ratio),
        )
        for line in result.finding.lines
        if line.ratio > LINE_RATIO
    ][:LINES]
    header = ("record", "signal", "rpm", "Hz", "order", "amplitude", "power over noise")
    text = "Spectral lines of steady running that the model has not. The same Hz at several speeds: not tied to angle."
    return TableView("Lines left over", text, header, rows)


def _notes(result: CaseResult) -> TableView:
    rows = [(text,) for text in result.warnings]
    return TableView("What to know", "Repairs, limits and warnings.", ("",), rows, left=1)


def _expected(finding: Finding) -> str:
    return f"{finding.expected_cost.mean:.0f} +- {finding.expected_cost.sigma:.0f}"
