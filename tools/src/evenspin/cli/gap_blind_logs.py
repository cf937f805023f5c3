"""`evenspin gap blind make-logs`, `run-logs` and `score-logs`: logs of other drives."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.blind_truth import place_of_truth
from evenspin.cli.options import Force, JsonFlag
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, write_json

Truth = Annotated[Path, typer.Option("--truth", metavar="FILE", help="What `make-logs` wrote beside the logs.")]
Jobs = Annotated[int | None, typer.Option(min=1, help="Processes; one per core when left out.")]


def register(app: typer.Typer) -> None:
    app.command("make-logs")(make_logs)
    app.command("run-logs")(run_logs)
    app.command("score-logs")(score_logs)
    app.command("score-foreign")(score_foreign)


def make_logs(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the logs: new or empty.")],
    count: Annotated[int, typer.Option(min=1, max=9999, help="Logs of each seed.")] = 60,
    seeds: Annotated[str, typer.Option(metavar="N,N", help="The same numbers, the same set.")] = "1",
    truth: Annotated[
        Path | None, typer.Option("--truth", metavar="FILE", help="Where the truth goes; beside DIR when left out.")
    ] = None,
    foreign: Annotated[
        bool, typer.Option("--foreign", help="Causes that no table lists, with voltages, some beside a known effect.")
    ] = False,
    jobs: Jobs = None,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Write logs of simulated drives of other makes, with hidden effects, as other programs write files.

    Example: `evenspin gap blind make-logs --out out/logs --count 40 --seeds 1,2`
    """
    from evenspin.blind.logs import make_logs as make
    from evenspin.blind.logs import plan_foreign_logs, plan_logs, write_log_truth
    from evenspin.output import OutputFile
    from evenspin.sim.progress import progress_bar

    numbers = _seeds(seeds)
    truth_file = place_of_truth(out, truth)
    apart = OutputFile(truth_file, origin(), option="--truth", force=force)
    out.mkdir(exist_ok=True)
    plan_of = plan_foreign_logs if foreign else plan_logs
    plans = [plan for number in numbers for plan in plan_of(count, number)]
    with progress_bar("making logs", len(plans)) as bar:
        truths = make(plans, out, jobs or os.cpu_count() or 1, bar.update)
    with apart as place:
        write_log_truth(place, truths)
    if as_json:
        write_json({"logs": str(out), "truth": str(truth_file), "count": len(truths)}, STDOUT)
    else:
        console().print(f"{len(truths)} logs in {out}, truth in {truth_file}")


def run_logs(
    logs: Annotated[Path, typer.Argument(metavar="DIR", help="What `make-logs` wrote.")],
    truth: Truth,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="One folder per log; what is there is kept.")],
    jobs: Jobs = None,
) -> None:
    """Give every log to `evenspin gap FILE --model M`, and keep the verdict and the time.

    Example: `evenspin gap blind run-logs out/logs --truth out/logs_truth.json --out out/verdicts`
    """
    from evenspin.blind.log_runs import run_logs as run
    from evenspin.blind.logs import read_log_truth
    from evenspin.sim.progress import progress_bar

    truths = read_log_truth(truth)
    with progress_bar("running gap", len(truths)) as bar:
        run(truths, logs, out, jobs or os.cpu_count() or 1, bar.update)


def score_logs(
    truth: Truth,
    results: Annotated[Path, typer.Option("--results", metavar="DIR", help="What `run-logs` wrote.")],
    markdown: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the tables as Markdown.")] = None,
    check: Annotated[bool, typer.Option("--check", help="Exit status 1 when a goal is missed.")] = False,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Hold verdicts on logs against the truth.

    Example: `evenspin gap blind score-logs --truth out/logs_truth.json --results out/verdicts`
    """
    from evenspin.blind import log_score as scoring
    from evenspin.blind.log_page import page
    from evenspin.blind.logs import read_log_truth
    from evenspin.errors import CheckFailedError
    from evenspin.output import OutputFile
    from evenspin.tableview import TableView, print_table

    output = OutputFile(markdown, origin(truth, results), option="--markdown", force=force) if markdown else None
    truths = read_log_truth(truth)
    scores = scoring.score_logs(truths, results)
    summary = scoring.summary_of(scores)
    missed = scoring.missed(summary)
    seeds = ", ".join(dict.fromkeys(log.split("_")[1] for log in truths))
    if output is not None:
        output.write(page(scores, seeds))
    if as_json:
        write_json(
            {
                "summary": {name: None if value != value else value for name, value in summary.items()},
                "missed": missed,
                "logs": [
                    {
                        "log": s.log,
                        "kind": s.truth.kind,
                        "style": s.truth.style,
                        "hidden": list(s.hidden),
                        "said": None if s.said is None else list(s.said),
                        "exact": s.exact,
                        "undecided": s.undecided,
                        "wrong": list(s.wrong),
                        "errors": dict(s.errors),
                        "message": s.run.message if s.run is not None else None,
                    }
                    for s in scores
                ],
            },
            STDOUT,
        )
    else:
        screen = console()
        rows = [
            (
                s.log,
                s.truth.style,
                s.truth.voltage or "-",
                f"{s.truth.rate_hz:g}",
                ", ".join(s.hidden) or "none",
                _said(s),
            )
            for s in scores
            if not s.exact
        ]
        header = ("log", "style", "voltages", "Hz", "hidden", "said")
        if rows:
            print_table(TableView("Not exactly right", "", header, rows, left=6), screen)
        lines = [
            (scoring.SAYS[name], scoring.shown(name, value), scoring.goal_of(name), "missed" * (name in missed))
            for name, value in summary.items()
        ]
        print_table(TableView("Score", "", ("", "found", "goal", ""), lines, left=1), screen)
    if check and missed:
        raise CheckFailedError(f"blind logs: goals missed: {', '.join(missed)}")


def _said(score: object) -> str:
    from evenspin.blind.log_score import LogScore

    assert isinstance(score, LogScore)
    if score.said is None:
        return "(no verdict) " + (score.run.message[:70] if score.run is not None else "")
    return ", ".join(score.said) or "none"


def _seeds(text: str) -> list[int]:
    from evenspin.errors import InputError

    words = [word.strip() for word in text.split(",")]
    if not all(word.isdigit() for word in words) or len(set(words)) != len(words):
        raise InputError("--seeds", "numbers", text, "different whole numbers with commas between", "for example 1,2")
    return [int(word) for word in words]


def score_foreign(
    truth: Truth,
    results: Annotated[Path, typer.Option("--results", metavar="DIR", help="What `run-logs` wrote.")],
    markdown: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the tables as Markdown.")] = None,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Hold what was said of causes that no table lists against the truth.

    Example: `evenspin gap blind score-foreign --truth out/logs_truth.json --results out/verdicts`
    """
    from evenspin.blind.foreign_score import GOALS, page, summary_of
    from evenspin.blind.foreign_score import score_foreign as score
    from evenspin.blind.logs import read_log_truth
    from evenspin.output import OutputFile
    from evenspin.tableview import TableView, print_table

    output = OutputFile(markdown, origin(truth, results), option="--markdown", force=force) if markdown else None
    truths = read_log_truth(truth)
    scores = score(truths, results)
    summary = summary_of(scores)
    seeds = ", ".join(dict.fromkeys(log.split("_")[1] for log in truths))
    if output is not None:
        with output as place:
            place.write_text(page(scores, seeds), encoding="utf-8")
    if as_json:
        write_json(summary, STDOUT)
        return
    rows = [(GOALS[name][2], f"{100.0 * value:.0f} %") for name, value in summary.items()]
    print_table(
        TableView("Causes that nobody has listed", f"{len(scores)} logs.", ("", "found"), rows, left=1), console()
    )
