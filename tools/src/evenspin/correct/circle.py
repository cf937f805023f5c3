"""All of it on a virtual drive with something hidden in its machine: experiments, cause, correction, measured again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from evenspin.bench.client import Drive
from evenspin.bench.experiments import ExperimentList, experiments_toml, plan, read_experiments
from evenspin.bench.operator import Operator
from evenspin.bench.runner import perform
from evenspin.correct.file import EXPERIMENTS, write_correction
from evenspin.correct.outcome import trial_chapters, trial_summary, write_trial
from evenspin.correct.proposal import Proposal, proposal_of
from evenspin.correct.report import proposal_chapter, summary
from evenspin.correct.trial import Trial, run_trial
from evenspin.gap.check import checked_case
from evenspin.gap.folder import write_result
from evenspin.gap.headline import summary_of
from evenspin.gap.result import CaseResult, investigate
from evenspin.gap.story import tables_of
from evenspin.log.case import write_case
from evenspin.model import Machine
from evenspin.report.page import Chapter, Page, write_page

CASE, GAP, APPLIED = "case", "gap", "applied"
# How the time is divided: all of the search, little else.
PERFORMED, SEARCHED, PREDICTED = 0.1, 0.9, 0.93

Progress = Callable[[str, float], None]
Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Circle:
    result: CaseResult
    proposal: Proposal
    trial: Trial | None  # None: nothing was proposed

    @property
    def summary(self) -> str:
        tried = trial_summary(self.trial, False) if self.trial is not None else ""
        return " ".join(part for part in (*summary_of(self.result), summary(self.proposal), tried) if part)


def run_circle(
    drive: Drive,
    operator: Operator,
    machine: Machine,
    folder: Path,
    command: str,
    progress: Progress,
    say: Say,
    workers: int | None = None,
) -> Circle:
    """Writes case/, gap/ and applied/ into an existing folder, and report.html over them.

    Args:
        machine: the nominal one. What the machine of the drive has beside it is what has to be found.
    """
    for name in (CASE, GAP, APPLIED):
        (folder / name).mkdir()
    experiments = plan(machine)
    total_s = sum(each.duration_s for each in experiments)
    what = ExperimentList(machine.name, machine.name, machine, experiments)

    def performing(name: str, seconds: float) -> None:
        progress(name, PERFORMED * seconds / total_s)

    done = perform(drive, operator, what, performing, say)
    if done.ended_by is not None:
        raise done.ended_by
    write_case(folder / CASE, done.meta, done.records)
    (folder / CASE / EXPERIMENTS).write_text(experiments_toml(machine.name, machine.name, experiments), "utf-8")

    def searching(what: str, share: float) -> None:
        progress(what, PERFORMED + (SEARCHED - PERFORMED) * share)

    case, messages = checked_case(folder / CASE)
    result = investigate(case, workers, searching, messages)
    progress("simulating corrections", SEARCHED)
    proposal = proposal_of(result)
    write_result(folder / GAP, result, command, [proposal_chapter(proposal)])
    write_correction(folder / GAP, proposal, result.case, result.nominal)
    progress("before and after", PREDICTED)
    trial = None
    if proposal.corrections:
        tried = read_experiments(folder / GAP / EXPERIMENTS)
        trial = run_trial(drive, operator, proposal, tried, lambda name, seconds: None, say, lambda run: None)
        write_trial(folder / APPLIED, trial, proposal, command, False)
    else:
        (folder / APPLIED).rmdir()
    circle = Circle(result, proposal, trial)
    write_page(folder, _page(circle, command))
    return circle


def _page(circle: Circle, command: str) -> Page:
    found = Chapter("What is missing in the model?", "More in gap/report.html.", tables_of(circle.result))
    chapters = trial_chapters(circle.trial, circle.proposal) if circle.trial is not None else []
    rest = [] if circle.trial is not None else [proposal_chapter(circle.proposal)]
    return Page(
        title=f"From cause to correction: {circle.result.name}",
        summary=circle.summary,
        facts=[("folders", "case: the log; gap: verdict and correction.toml; applied: before and after")],
        tables=[],
        pictures=[],
        command=command,
        chapters=[found, *rest, *chapters],
    )
