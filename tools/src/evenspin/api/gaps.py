"""Why a model does not match a log."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evenspin.errors import InputError

COMMAND = "evenspin.find_gap"
Place = str | os.PathLike[str]


@dataclass(frozen=True, slots=True)
class Gap:
    """`names`: effects that the model lacks, "unknown" among them where something is left. `verdict`: all of
    verdict.json. `summary`: sentences for a person."""

    names: tuple[str, ...]
    verdict: Mapping[str, Any]
    summary: Sequence[str]

    @property
    def parameters(self) -> Mapping[str, Mapping[str, float]]:
        """Of each named effect, by the names of `evenspin.list_effects()`."""
        return self.verdict.get("parameters", {})


def find_gap(
    log: Place | Sequence[Place],
    *,
    model: Place | None = None,
    tolerances: str | None = None,
    out: Place | None = None,
    workers: int | None = None,
    force: bool = False,
) -> Gap:
    """Where a log and a model disagree, and which effect is missing.

    Args:
        log: a case folder with meta.json, a log in the columns of docs/log-format.md, or several of one machine.
        model: of a log: a model file or a built-in model. With voltages in the log its equations are used, else a
            torque balance.
        tolerances: of a log with voltages: what a healthy unit may differ by, "bench" or "laboratory".
        out: a folder for what `evenspin gap --out` writes.
        workers: threads of a case folder, one per core when left out.
        force: as `Run.save` has it.

    Raises:
        EvenspinError: what cannot be read, or cannot be what its columns say.
    """
    from evenspin.output import OutputFolder
    from evenspin.output.origin import Origin, absolute

    paths = [Path(log)] if isinstance(log, str | os.PathLike) else [Path(each) for each in log]
    for path in paths:
        if not path.exists():
            raise InputError("find_gap", "log", path, "an existing folder or file", "check the name")
    made = Origin(COMMAND, tuple(absolute(path) for path in paths))
    output = OutputFolder(Path(out), made, option="out", force=force) if out is not None else None
    if len(paths) == 1 and paths[0].is_dir():
        for key, value in (("model", model), ("tolerances", tolerances)):
            if value is not None:
                raise InputError("find_gap", key, str(value), "left out for a case folder", "its meta.json says it")
        return _of_case(paths[0], output, workers)
    with output if output is not None else nullcontext() as folder:
        return _of_logs(paths, None if model is None else os.fspath(model), tolerances, folder)


def _of_case(path: Path, output: Any, workers: int | None) -> Gap:
    from evenspin.gap.check import checked_case
    from evenspin.gap.folder import write_result
    from evenspin.gap.headline import summary_of
    from evenspin.gap.result import investigate
    from evenspin.gap.verdict import verdict_json

    loaded, messages = checked_case(path)
    result = investigate(loaded, workers, lambda what, share: None, messages)
    if output is not None:
        with output as folder:
            write_result(folder, result, COMMAND)
    return Gap(tuple(result.verdict), verdict_json(result), summary_of(result))


def _of_logs(paths: list[Path], model: str | None, tolerances: str | None, folder: Path | None) -> Gap:
    from evenspin.balance import run_balance
    from evenspin.driven import run_driven, serves

    if model is not None and serves(paths, model):
        found = run_driven(paths, model, tolerances or "bench", folder, command=COMMAND)
        return Gap(tuple(found.verdict["verdict"]), found.verdict, found.summary)
    needs = "given with a model that states psi_wb, inertia_kgm2 and viscous_nms, or voltages in the log"
    if tolerances is not None:
        raise InputError("find_gap", "tolerances", tolerances, needs, "a torque balance has its own thresholds")
    if len(paths) > 1:
        raise InputError("find_gap", "log", f"{len(paths)} logs", needs, "give one log at a time")
    balance = run_balance(paths[0], model, folder, command=COMMAND)
    return Gap(tuple(balance.verdict["verdict"]), balance.verdict, balance.summary)
