"""What a case leaves behind in its folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from evenspin.gap.model_file import write_model
from evenspin.gap.outcome import write_traces
from evenspin.gap.result import CaseResult, Step
from evenspin.gap.story import page_of, summary_of
from evenspin.gap.verdict import VERDICT, verdict_json
from evenspin.log.case import write_json
from evenspin.log.tolerance import unit_of
from evenspin.report.page import Chapter, write_page


def write_result(folder: Path, result: CaseResult, command: str, more: Sequence[Chapter] = ()) -> None:
    """verdict.json, traces before and after, model.toml, scenario.toml, report.html; into an existing, empty folder.

    `more`: chapters at the end of the report.
    """
    write_json(folder / VERDICT, verdict_json(result))
    write_traces(folder, _file_name(result), {"before": result.before, "after": result.after})
    write_model(
        folder,
        result.case,
        result.nominal,
        {**result.effects, **result.rest.effects},
        result.delta,
        result.unit,
        summary_of(result),
    )
    page = page_of(result, command)
    write_page(folder, replace(page, chapters=[*page.chapters, *more]))


def write_steps(folder: Path, result: CaseResult) -> None:
    """step_1, step_2, ...: the model after each effect, and how far the gap was before and after it."""
    gap = result.before.gap
    previous = result.before
    for number, step in enumerate(result.steps[1:], 1):
        place = folder / f"step_{number}"
        place.mkdir()
        content = {
            "step": number,
            "added": [name for name in step.names if name not in result.steps[number - 1].names],
            "verdict": list(step.names),
            "parameters": {name: dict(params) for name, params in step.effects.items()},
            "cost_before": result.steps[number - 1].cost,
            "cost_after": step.cost,
            "gap_before": gap,
            "gap_after": step.outcome.gap,
        }
        write_json(place / VERDICT, content)
        write_traces(place, _file_name(result), {"before": previous, "after": step.outcome})
        _step_model(place, result, step)
        gap, previous = step.outcome.gap, step.outcome


def _file_name(result: CaseResult) -> str:
    """meta.json may call the case anything."""
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in result.name)


def _step_model(place: Path, result: CaseResult, step: Step) -> None:
    unit = unit_of(step.effects, step.delta)
    notes = [f"with {' and '.join(step.names)}: the gap on validation records is {step.outcome.gap:.4f}"]
    write_model(place, result.case, result.nominal, step.effects, step.delta, unit, notes)
