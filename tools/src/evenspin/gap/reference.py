"""The page of the manual that is made from the thresholds of the search."""

from __future__ import annotations

from evenspin.gap.threshold import Section
from evenspin.gap.thresholds import SECTIONS
from evenspin.report.reference import escape, page

TEXT = (
    "Every threshold by which `evenspin gap CASE_DIR` decides. Costs are robust chi-squares of all features; *excess* "
    "is cost beyond what simulated healthy units have. A value was set on the data named beside it, which is blind no "
    "longer: check a change by `make blind` with a seed that nobody has used."
)
HEAD = "| name | value | separates | set on | too low | too high |\n| --- | --- | --- | --- | --- | --- |"


def pages() -> dict[str, str]:
    """File name and content."""
    return {"gap-thresholds.md": page("Thresholds of the gap search", TEXT, "\n\n".join(map(_table, SECTIONS)))}


def _table(section: Section) -> str:
    rows = [
        f"| `{t.name}` | {t.value:g} {escape(t.unit)} | {escape(t.separates)} | {escape(t.set_on)} | "
        f"{escape(t.too_low)} | {escape(t.too_high)} |"
        for t in section.rows
    ]
    return "\n".join([f"## {section.title}", "", HEAD, *rows])
