"""`evenspin gap LOG...` with voltages: the equations of the machine against logs of any drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evenspin.driven.fading import without_faded
from evenspin.driven.findable import advice, findable
from evenspin.driven.judge import judge
from evenspin.driven.model_file import estimates, model_text
from evenspin.driven.open_gap import name_backlash, open_gap
from evenspin.driven.read import nominal_of, read_logs
from evenspin.driven.report import page_of, summary_of, tables_of
from evenspin.driven.verdict_file import empirical_json, verdict_json
from evenspin.empirical.words import sentence
from evenspin.log.case import write_json
from evenspin.report.page import write_page
from evenspin.sim.progress import Bar
from evenspin.tableview import TableView
from evenspin.weakform.analysis import Explained, explain
from evenspin.weakform.beyond import look_beyond
from evenspin.weakform.beyond_search import Search
from evenspin.weakform.evidence import confirmed
from evenspin.weakform.tolerances import tolerances_of


@dataclass(frozen=True, slots=True)
class DrivenResult:
    """What was found. `verdict` is the content of verdict.json; `summary` and `tables` are for the terminal."""

    verdict: dict[str, Any]
    summary: Sequence[str]
    tables: Sequence[TableView]
    found: Explained


def run_driven(
    paths: Sequence[Path],
    model: str | Path,
    tolerances: str,
    out_dir: Path | None,
    progress: Bar | None = None,
    command: str = "",
) -> DrivenResult:
    """Hold logs of one machine against its model, and write verdict.json, model.toml and report.html.

    Args:
        paths: logs in SI units with voltages, currents and an angle or a speed.
        model: a model file or the name of a built-in one.
        tolerances: `laboratory` or `bench`.
        out_dir: an existing, empty folder; None: nothing is written.
        progress: gets the share that is done, 0 to 1.
        command: noted in the report.
    """

    def say(what: str, share: float) -> None:
        if progress is not None:
            progress.say(what)
            progress.update(share)

    allowed = tolerances_of(tolerances)
    logs = read_logs(paths, model)
    nominal = nominal_of(model, logs)
    say("fitting", 0.1)
    signals = [log.signals for log in logs]
    found = explain(signals, nominal.plant, nominal.base, nominal.scale, allowed, say, nominal.estimated)
    known_pwm = "pwm_hz" in nominal.machine.plant_from
    search = Search(found)
    beyond = confirmed(search, look_beyond(search, say))
    found = beyond.found
    opened = open_gap(found)
    verdict = judge(found, known_pwm, bool(beyond.terms), bounces=opened is not None)
    without_faded(found, verdict, beyond.evidence)
    if opened is not None:
        name_backlash(verdict, opened)
    verdict.unexplained += [sentence(term) for term in beyond.evidence]
    table = findable(found.model.terms, found.normal, found.model.logs, opened is not None)
    advised = advice(table, signals)
    name = logs[0].signals.name if len(logs) == 1 else f"{logs[0].signals.name} and {len(logs) - 1} more"
    content = verdict_json(name, found, verdict, nominal, logs, table, advised)
    content |= empirical_json(beyond, verdict)
    content["estimated"] = estimates(found, nominal)
    if out_dir is not None:
        write_json(out_dir / "verdict.json", content)
        (out_dir / "model.toml").write_text(
            model_text(nominal, verdict, estimates(found, nominal), beyond.evidence), encoding="utf-8"
        )
        write_page(out_dir, page_of(found, verdict, table, advised, nominal, logs, command, beyond.evidence))
    say("done", 1.0)
    return DrivenResult(
        content, summary_of(found, verdict, advised), tables_of(found, verdict, table, beyond.evidence), found
    )
