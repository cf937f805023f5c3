"""Corrections as tables, on the terminal and in reports."""

from __future__ import annotations

import math

from evenspin.correct.proposal import Proposal
from evenspin.report.page import Chapter
from evenspin.tableview import TableView, number

TITLE = "What counteracts it in the drive?"


def proposal_tables(proposal: Proposal) -> list[TableView]:
    """What is proposed, and what is not with the reason."""
    tables = []
    if proposal.corrections:
        rows = []
        for each in proposal.corrections:
            p = each.predicted
            rows.append(
                (
                    each.name,
                    f"{each.spoils.what} [{each.spoils.unit}]",
                    number(p.log),
                    number(p.corrected),
                    f"{number(p.low)} .. {number(p.high)}",
                    number(p.healthy),
                )
            )
        text = (
            "Simulated with the firmware in the loop: the machine that was found, with the correction in its drive. "
            "between: what the intervals of the parameters allow. healthy: without the effect."
        )
        header = ("correction", "what the effect spoils", "log", "predicted", "between", "healthy")
        tables.append(TableView("Corrections", text, header, rows))
        changes = [(each.name, c.parameter, c.text) for each in proposal.corrections for c in each.changes]
        text = "=: set to; +: added; x: times. Intervals are 95 %. `evenspin bench apply` tries them on a drive."
        tables.append(
            TableView("Parameters of the drive", text, ("correction", "parameter", "change"), changes, left=3)
        )
    if proposal.left:
        left = [(each.effect, each.reason) for each in proposal.left]
        tables.append(
            TableView("Not corrected", "Named, and nothing in the drive is changed.", ("effect", "why"), left)
        )
    return tables


def summary(proposal: Proposal) -> str:
    """One sentence."""
    if not proposal.corrections:
        return "No correction is proposed" + (
            ": nothing is named." if not proposal.left else ", for the reasons given."
        )
    parts = [
        f"{each.name} ({each.spoils.what}: {number(each.predicted.without)} to {number(each.predicted.corrected)} "
        f"{each.spoils.unit} predicted)"
        for each in proposal.corrections
    ]
    rest = " What is unknown beside it stays." if proposal.unknown else ""
    return f"Corrected in the drive: {', '.join(parts)}.{rest}"


def proposal_chapter(proposal: Proposal) -> Chapter:
    return Chapter(TITLE, summary(proposal), proposal_tables(proposal))


def percent(share: float) -> str:
    return f"{100.0 * share:.0f}" if math.isfinite(share) else "-"
