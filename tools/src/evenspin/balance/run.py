"""`evenspin gap LOG.csv`: one log of any drive, in ampere equivalents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.balance.analysis import Analysis, analyse
from evenspin.balance.judge import judge
from evenspin.balance.log_reader import read_log
from evenspin.balance.model_file import model_text
from evenspin.balance.nominal_model import read_nominal
from evenspin.balance.other_columns import read_other_columns
from evenspin.balance.plausibility import check_against
from evenspin.balance.report import page_of, summary_of, tables_of
from evenspin.balance.verdict import Verdict
from evenspin.balance.verdict_file import verdict_json
from evenspin.log.case import write_json
from evenspin.log.csvfile import write_csv
from evenspin.report.page import write_page
from evenspin.sim.progress import Bar
from evenspin.tableview import TableView


@dataclass(frozen=True, slots=True)
class BalanceResult:
    """What was found. `verdict` is the content of verdict.json; `summary` and `tables` are for the terminal."""

    verdict: dict[str, Any]
    summary: Sequence[str]
    tables: Sequence[TableView]
    analysis: Analysis

    @property
    def warnings(self) -> Sequence[str]:
        return self.verdict["warnings"]


def run_balance(
    log_path: Path, model: str | Path | None, out_dir: Path | None, progress: Bar | None = None, command: str = ""
) -> BalanceResult:
    """Analyse a log and write verdict.json, balance.csv, model.toml and report.html into an existing, empty folder.

    Args:
        log_path: CSV or CSV.GZ with t_s, iq_a, and theta_m_rad or speed_rad_s.
        model: a model file or the name of a built-in one; None: everything in ampere equivalents.
        out_dir: None: nothing is written.
        progress: gets the share that is done, 0 to 1.
        command: noted in the report.
    """
    nominal = read_nominal(model) if model is not None else None
    log = read_log(log_path)
    remarks: tuple[str, ...] = ()
    if nominal is not None:
        names = ("t_s", "iq_a", "theta_m_rad", "speed_rad_s")
        remarks = check_against(log_path, {**{name: getattr(log, name) for name in names}, **log.beside}, nominal)
    other_columns = read_other_columns(log_path, nominal)
    analysis = analyse(log, nominal, progress, other_columns)
    verdict = judge(analysis)
    verdict.warnings += [*remarks, *other_columns.remarks]
    content = verdict_json(analysis, verdict)
    if out_dir is not None:
        _write(out_dir, analysis, verdict, content, command or f"evenspin gap {log_path}")
    if progress is not None:
        progress.update(1.0)
    return BalanceResult(content, summary_of(analysis, verdict), tables_of(analysis, verdict), analysis)


def _write(folder: Path, analysis: Analysis, verdict: Verdict, content: dict[str, Any], command: str) -> None:
    write_json(folder / "verdict.json", content)
    write_csv(folder / "balance.csv", *_traces(analysis))
    text = model_text(analysis, verdict)
    if text is not None:
        (folder / "model.toml").write_text(text, encoding="utf-8")
    write_page(folder, page_of(analysis, verdict, command))


def _traces(analysis: Analysis) -> tuple[list[str], Any]:
    """The balance over time, before and after; `half`: 0 not judged, 1 fits, 2 validates."""
    columns: dict[str, Any] = {"t_s": analysis.grid.t_s}
    for name, found in (("friction", analysis.friction), ("angle", analysis.angle)):
        if found is not None:
            columns |= {
                f"{name}_speed_rad_s": found.motion.speed_rad_s,
                f"{name}_accel_rad_s2": found.motion.accel_rad_s2,
                f"{name}_iq_a": found.motion.iq_a,
                f"{name}_before_a": found.before,
                f"{name}_after_a": found.after,
                f"{name}_half": found.fit_rows + 2.0 * found.validation_rows,
            }
    return list(columns), np.column_stack(list(columns.values()))
