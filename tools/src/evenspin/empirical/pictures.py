"""Found terms in the report: a table in words, and each over what it depends on with its band and the data over it."""

from __future__ import annotations

from collections.abc import Sequence

from evenspin.empirical.term import EmpiricalTerm
from evenspin.empirical.words import experiment, form, like, sentence
from evenspin.report.figures import Picture
from evenspin.report.style import OTHER_COLOURS, drawing, subplots, to_svg
from evenspin.tableview import TableView

BAND, DATA = OTHER_COLOURS[0], OTHER_COLOURS[1]


def terms_view(terms: Sequence[EmpiricalTerm]) -> TableView:
    rows = [(form(t), f"{100.0 * t.share:.0f} %", like(t), experiment(t)) for t in terms]
    text = (
        "What no effect of the table explains: share of the squared gap on stretches that no "
        "fit saw, and what it is like."
    )
    return TableView("Beyond the table of effects", text, ("form", "share", "like", "next experiment"), rows, left=1)


def term_pictures(terms: Sequence[EmpiricalTerm]) -> list[Picture]:
    return [_picture(term, number) for number, term in enumerate(terms, start=1) if term.curve is not None]


def _picture(term: EmpiricalTerm, number: int) -> Picture:
    curve = term.curve
    assert curve is not None
    with drawing():
        figure, axes = subplots(1, 1, height=3.2)
        panel = axes[0, 0]
        panel.fill_between(
            curve.x, curve.value - curve.half, curve.value + curve.half, alpha=0.3, color=BAND, linewidth=0
        )
        panel.plot(curve.x, curve.value, color=BAND, label="term, 95 %")
        panel.plot(curve.data_x, curve.data, "o", markersize=3.5, color=DATA, label="log")
        panel.set(xlabel=curve.over, ylabel=f"[{curve.unit}]")
        panel.legend()
        svg = to_svg(figure)
    data = {"x": curve.x, "term": curve.value, "half_width": curve.half, "log": curve.data}
    return Picture(f"beyond_{number}", f"Beyond the table: {', '.join(_title(term))}", f"{sentence(term)}.", svg, data)


def _title(term: EmpiricalTerm) -> list[str]:
    from evenspin.empirical.words import depends_on

    return depends_on(term)
