"""`evenspin gap blind make` and `evenspin gap blind score`."""

from __future__ import annotations

import itertools
import os
from pathlib import Path
from typing import Annotated, Any

import typer

from evenspin.cli import gap_blind_logs
from evenspin.cli.blind_truth import place_of_truth
from evenspin.cli.options import Force, JsonFlag
from evenspin.cli.origin import origin
from evenspin.cli.output import STDOUT, console, write_json

MADE = "<!-- Made by `make blind`. Do not edit. -->\n\n# Verdicts on blind cases\n\n"

app = typer.Typer(no_args_is_help=True, help="Blind cases: make them, and score the verdicts on them.")
gap_blind_logs.register(app)

NUMBERS = {2: "two", 3: "three"}


@app.command("make")
def make(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the cases: new or empty.")],
    count: Annotated[int | None, typer.Option(min=1, max=9999, help="Number of cases.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Another number, another set; the same number, the same set.")] = 1,
    effects: Annotated[str, typer.Option(metavar="A,B", help="Hide only these; all when left out.")] = "",
    kind: Annotated[
        str,
        typer.Option(
            help="single, pair, triple, none, outside, beside or mix, or how many of each: single=40,pair=10,outside=6."
        ),
    ] = "mix",
    simulator: Annotated[
        str,
        typer.Option(
            help="What makes the records: referee, or motulator (frictions, saturation, two masses, R, J, psi)."
        ),
    ] = "referee",
    truth: Annotated[
        Path | None, typer.Option("--truth", metavar="FILE", help="Where the truth goes; beside DIR when left out.")
    ] = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Processes; one per core when left out.")] = None,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Write cases in the measured-log format with hidden effects, simulated by a program of its own.

    Example: `evenspin gap blind make --out out/blind --count 40 --kind single`
    """
    from evenspin.blind.cases import make_set, plan_cases
    from evenspin.blind.truth import write_truth
    from evenspin.output import OutputFile
    from evenspin.sim.progress import progress_bar

    counts = _counts(kind, count)
    names = _of_simulator(simulator, _names(effects), counts)
    _check_choice(effects, names, counts)
    truth_file = place_of_truth(out, truth)
    apart = OutputFile(truth_file, origin(), option="--truth", force=force)
    out.mkdir(exist_ok=True)
    plans = plan_cases(counts, seed, names, simulator)
    with progress_bar("making blind cases", len(plans)) as bar:
        truths = make_set(plans, out, jobs or os.cpu_count() or 1, bar.update)
    with apart as place:
        write_truth(place, truths)
    if as_json:
        write_json({"cases": str(out), "truth": str(truth_file), "count": len(truths)}, STDOUT)
    else:
        console().print(f"{len(truths)} cases in {out}, truth in {truth_file}")


@app.command("score")
def score(
    truth: Annotated[Path, typer.Option("--truth", metavar="FILE", help="What `make` wrote beside the cases.")],
    results: Annotated[Path, typer.Option("--results", metavar="DIR", help="Holds CASE/verdict.json or CASE.json.")],
    cases: Annotated[
        Path | None, typer.Option("--cases", metavar="DIR", help="Score only the cases that lie in this folder.")
    ] = None,
    markdown: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the tables as Markdown.")] = None,
    check: Annotated[bool, typer.Option("--check", help="Exit status 1 when a goal is missed.")] = False,
    force: Force = False,
    as_json: JsonFlag = False,
) -> None:
    """Hold verdicts against the truth: who was right, how wrong parameters are, how far the gap closed.

    Example: `evenspin gap blind score --truth out/blind_truth.json --results out/verdicts`
    """
    from evenspin.blind import calibration as calibrating
    from evenspin.blind import misses
    from evenspin.blind import score as scoring
    from evenspin.blind.truth import read_truth
    from evenspin.errors import CheckFailedError, InputError
    from evenspin.output import OutputFile

    page = OutputFile(markdown, origin(truth, results), option="--markdown", force=force) if markdown else None
    truths = read_truth(truth)
    if cases is not None:
        truths = {case: what for case, what in truths.items() if (cases / case).is_dir()}
        if not truths:
            raise InputError("--cases", "folder", str(cases), "one with cases of the truth file", "see --truth")
    result = scoring.score_set(truths, results)
    calibration = calibrating.calibrate(truths, results)
    if page is not None:
        tables = scoring.markdown(result) + calibrating.markdown(calibration)
        page.write(MADE + tables + misses.markdown(result, truths, results))
    if as_json:
        write_json(_json(result), STDOUT)
    else:
        _print(result)
    missed = result.missed()
    if check and missed:
        raise CheckFailedError(f"blind score: goals missed: {', '.join(missed)}")


def _names(effects: str) -> list[str]:
    from evenspin.blind.vocabulary import EFFECTS, OUTSIDE
    from evenspin.errors import InputError, did_you_mean

    known = [*EFFECTS, *OUTSIDE]
    names = [name.strip() for name in effects.split(",") if name.strip()]
    for name in names:
        if name not in known:
            raise InputError("--effects", "name", name, "an effect", did_you_mean(name, known))
    return names


def _of_simulator(simulator: str, names: list[str], counts: dict[str, int]) -> list[str]:
    """The effects that this simulator can hide."""
    from importlib.util import find_spec

    from evenspin.blind.cases import MOTULATOR, SIMULATORS
    from evenspin.blind.motulator_drive import EFFECTS
    from evenspin.errors import InputError, did_you_mean

    if simulator not in SIMULATORS:
        raise InputError("--simulator", "name", simulator, " or ".join(SIMULATORS), did_you_mean(simulator, SIMULATORS))
    if simulator != MOTULATOR:
        return names
    if find_spec("motulator") is None:
        raise InputError("--simulator", "package", "motulator", "installed", "pip install 'evenspin[motulator]'")
    for name in names:
        if name not in EFFECTS:
            raise InputError(
                "--effects", "name", name, f"one that motulator has ({', '.join(EFFECTS)})", "leave it out"
            )
    if counts.get("outside") or counts.get("beside"):
        raise InputError("--kind", "kind", "outside, beside", "single, pair, triple or none", "motulator has no others")
    return names or list(EFFECTS)


def _check_choice(effects: str, names: list[str], counts: dict[str, int]) -> None:
    """Refuse a choice of names from which the wanted kinds cannot be drawn."""
    from evenspin.blind.cases import SEVERAL
    from evenspin.blind.vocabulary import EFFECTS, OUTSIDE, go_together
    from evenspin.errors import InputError

    if not names:
        return
    within = {name for name in names if name in EFFECTS}
    hint = "name others, or leave --effects out"
    if (counts.get("single") or counts.get("beside")) and not within:
        raise InputError("--effects", "names", effects, "of the vocabulary for that kind", hint)
    if (counts.get("outside") or counts.get("beside")) and not any(name in OUTSIDE for name in names):
        raise InputError("--effects", "names", effects, "outside of the vocabulary for that kind", hint)
    for several, number in SEVERAL.items():
        if counts.get(several) and not any(map(go_together, itertools.combinations(within, number))):
            must = f"{NUMBERS[number]} or more that go together for that kind"
            raise InputError("--effects", "names", effects, must, hint)


def _counts(kind: str, count: int | None) -> dict[str, int]:
    """How many of each kind."""
    from evenspin.blind.cases import MIX
    from evenspin.blind.vocabulary import KINDS
    from evenspin.errors import InputError

    if "=" in kind:
        counts = {}
        for word in kind.split(","):
            name, _, number = word.partition("=")
            if name.strip() not in KINDS or not number.strip().isdigit():
                raise InputError(
                    "--kind", "word", word, f"NAME=NUMBER, NAME of {', '.join(KINDS)}", "single=40,pair=10"
                )
            counts[name.strip()] = int(number)
        if count is not None and count != sum(counts.values()):
            raise InputError("--count", "number", count, f"{sum(counts.values())} as in --kind", "leave --count out")
        return counts
    total = 40 if count is None else count
    if kind in KINDS:
        return {kind: total}
    if kind != "mix":
        raise InputError("--kind", "word", kind, f"mix or one of {', '.join(KINDS)}", "or single=40,pair=10")
    counts = {name: int(share * total) for name, share in MIX.items()}
    return counts | {"single": counts["single"] + total - sum(counts.values())}


def _json(result: Any) -> dict[str, Any]:
    from evenspin.blind.score import parameter_table, size_table

    def number(value: float) -> float | None:
        return None if value != value else value

    return {
        "summary": {name: number(value) for name, value in result.summary.items()},
        "missed": result.missed(),
        "confusion": result.confusion,
        "parameters": [
            {"parameter": key, "cases": n, "median": mid, "largest": most}
            for key, n, mid, most in parameter_table(result)
        ],
        "sizes": [
            {"kind": what, "size": size, "cases": n, "exactly_right": share}
            for what, size, n, share in size_table(result)
        ],
        "cases": [
            {
                "case": case.case,
                "kind": case.what,
                "size": case.size,
                "hidden": list(case.hidden),
                "said": None if case.said is None else list(case.said),
                "right": case.right,
                "errors": dict(case.errors),
                "gap_closed": number(case.gap_closed),
            }
            for case in result.cases
        ],
    }


def _print(result: Any) -> None:
    from evenspin.blind.score import SAYS, goal_of, parameter_table, percent, size_table
    from evenspin.tableview import TableView, print_table

    screen = console()
    wrong = [case for case in result.cases if not case.right]
    rows = [
        (case.case, case.what, case.size, ", ".join(case.hidden) or "none", _said(case.said), percent(case.gap_closed))
        for case in wrong
    ]
    if rows:
        header = ("case", "kind", "size", "hidden", "said", "gap closed")
        print_table(TableView("Not exactly right", "", header, rows, left=5), screen)
    sizes = [(what, size, str(n), percent(share)) for what, size, n, share in size_table(result)]
    if sizes:
        print_table(TableView("By size", "", ("hidden", "size", "cases", "exactly right"), sizes, left=2), screen)
    errors = [(key, str(n), percent(mid), percent(most)) for key, n, mid, most in parameter_table(result)]
    if errors:
        print_table(
            TableView("Parameter errors", "", ("parameter", "cases", "median", "largest"), errors, left=1), screen
        )
    missed = result.missed()
    goals = [
        (
            SAYS[name],
            percent(value),
            goal_of(name),
            "missed" * (name in missed),
        )
        for name, value in result.summary.items()
    ]
    print_table(TableView("Score", "", ("", "found", "goal", ""), goals, left=1), screen)


def _said(names: tuple[str, ...] | None) -> str:
    return "(no result)" if names is None else ", ".join(names) or "none"
