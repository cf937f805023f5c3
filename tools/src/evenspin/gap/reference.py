"""The page of the manual that is made from the thresholds of the search."""

from __future__ import annotations

from evenspin.gap.thresholds import TABLE
from evenspin.report.reference import escape, page

TEXT = (
    "Every threshold by which `evenspin gap CASE_DIR` decides. Costs are robust chi-squares of all features; *excess* "
    "is cost beyond what simulated healthy units have. A value was set on the data named beside it, which is blind no "
    "longer: check a change by `make blind` with a seed that nobody has used."
)


def pages() -> dict[str, str]:
    """File name and content."""
    head = "| name | value | separates | set on | too low | too high |\n| --- | --- | --- | --- | --- | --- |"
    rows = [
        f"| `{t.name}` | {t.value:g} {escape(t.unit)} | {escape(t.separates)} | {escape(t.set_on)} | "
        f"{escape(t.too_low)} | {escape(t.too_high)} |"
        for t in TABLE
    ]
    return {"gap-thresholds.md": page("Thresholds of the gap search", TEXT, "\n".join([head, *rows]))}
