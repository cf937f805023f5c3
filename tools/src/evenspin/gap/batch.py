"""Many cases at once: on a dask cluster, or with a process per core of this machine. One thread a case."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evenspin.errors import EvenspinError, InputError, one_line
from evenspin.log.case import META
from evenspin.output import Origin, OutputFolder
from evenspin.tableview import TableView

SUMMARY = "summary.json"
EXTRA = "pip install 'evenspin[batch]'"
BLAS_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")  # one a process: there is a process per core already
KEYS = ("verdict", "confidence", "gap_before", "gap_after", "gap_floor", "gap_closed", "warnings")


@dataclass(frozen=True, slots=True)
class Job:
    case: Path
    out: Path
    force: bool = False

    @property
    def origin(self) -> Origin:
        return Origin(f"evenspin gap batch, case {self.name}", (self.case,))

    @property
    def name(self) -> str:
        return self.out.name


def jobs_of(folders: Sequence[Path], out: Path, force: bool = False) -> list[Job]:
    """Each folder is a case or holds cases."""
    found: dict[str, Path] = {}
    for folder in folders:
        if not folder.is_dir():
            raise InputError("gap batch", "DIR", str(folder), "an existing folder", "check the name")
        cases = [folder] if (folder / META).is_file() else sorted(path.parent for path in folder.glob(f"*/{META}"))
        if not cases:
            raise InputError(
                "gap batch", "DIR", str(folder), f"a case (with {META}) or a folder of cases", "check the name"
            )
        for case in cases:
            name = case.resolve().name
            if name in found and found[name] != case:
                raise InputError("gap batch", "DIR", str(case), f"of another name than {found[name]}", "rename one")
            found[name] = case
    return [Job(case.absolute(), out.absolute() / name, force) for name, case in found.items()]


def check_places(jobs: Sequence[Job]) -> None:
    """Refuse what must not be replaced before the first case is begun."""
    for job in jobs:
        OutputFolder(job.out, job.origin, force=job.force).release()


def solve(job: Job) -> dict[str, Any]:
    """One case into its folder, completely or not at all; a line of the summary. Runs in a process of its own."""
    from evenspin.gap.check import checked_case
    from evenspin.gap.folder import write_result
    from evenspin.gap.result import investigate
    from evenspin.gap.verdict import verdict_json

    if _stopped:
        return {"case": job.name, "error": "interrupted"}
    try:
        output = OutputFolder(job.out, job.origin, force=job.force)
        case, messages = checked_case(job.case)
        result = investigate(case, 1, warnings=messages)
        content = verdict_json(result)
        with output as folder:
            write_result(folder, result, f"evenspin gap {job.case}")
    except EvenspinError as error:
        return {"case": job.name, "error": str(error)}
    except Exception as error:  # a case must not end the others; what happened is in its line
        return {"case": job.name, "error": one_line(f"{type(error).__name__}: {error}")}
    return {"case": job.name, **{key: content[key] for key in KEYS}, "seconds": content["details"]["seconds"]}


_stopped = False  # of a worker: an interrupt ends what it does, and it must not begin the next


def _mind_interrupts() -> None:
    def stop(signal_number: int, frame: object) -> None:
        global _stopped
        _stopped = True
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, stop)


def run_batch(
    jobs: Sequence[Job], scheduler: str | None, workers: int | None, done: Callable[[int], None]
) -> list[dict[str, Any]]:
    """Lines of the summary in the order of the jobs."""
    lines: dict[str, dict[str, Any]] = {}
    with _pool(scheduler, workers, len(jobs)) as results:
        for line in results(jobs):
            lines[line["case"]] = line
            done(len(lines))
    return [lines[job.name] for job in jobs]


def how(scheduler: str | None) -> str:
    """What will do the work, for people."""
    if scheduler is not None:
        return f"dask scheduler {scheduler}"
    if _distributed() is not None:
        return "dask on this machine"
    return f"a process pool on this machine (for dask: {EXTRA})"


def summary_table(lines: Sequence[dict[str, Any]]) -> TableView:
    rows, marks = [], []
    for line in lines:
        if "error" in line:
            rows.append((line["case"], line["error"], *["-"] * 5))
            marks.append("bad")
            continue
        verdict = ", ".join(line["verdict"]) or "nothing missing"
        gaps = (line["gap_before"], line["gap_after"], line["gap_floor"])
        sure = min(line["confidence"].values(), default=None)
        rows.append((line["case"], verdict, *map(_text, (sure, *gaps)), f"{line['seconds']:.0f}"))
        marks.append("")
    header = ("case", "verdict", "confidence", "gap before", "gap after", "noise floor", "s")
    return TableView("Gap", "Gap: on validation records.", header, rows, marks)


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


@contextmanager
def _pool(
    scheduler: str | None, workers: int | None, jobs: int
) -> Iterator[Callable[[Sequence[Job]], Iterator[dict[str, Any]]]]:
    distributed = _distributed()
    count = workers or min(os.cpu_count() or 1, jobs)
    if scheduler is None and distributed is None:
        # a fresh interpreter each: the threads of this one are not copied into them
        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(count, mp_context=context, initializer=_mind_interrupts)
        os.environ.update({name: os.environ.get(name, "1") for name in BLAS_THREADS})  # read when NumPy is loaded
        try:
            yield lambda todo: (future.result() for future in as_completed([pool.submit(solve, job) for job in todo]))
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
        return
    if distributed is None:
        raise InputError("gap batch", "--scheduler", scheduler, "used with dask installed", EXTRA)
    with _client(distributed, scheduler, count) as client:
        yield lambda todo: (future.result() for future in distributed.as_completed(client.map(solve, todo, pure=False)))


def _client(distributed: Any, scheduler: str | None, count: int) -> Any:
    if scheduler is None:
        return distributed.Client(n_workers=count, threads_per_worker=1, dashboard_address=None)
    try:
        return distributed.Client(scheduler, timeout="10s")
    except (OSError, ValueError, TimeoutError) as error:
        hint = one_line(str(error)) or "is it running?"
        raise InputError("gap batch", "--scheduler", scheduler, "the address of a dask scheduler", hint) from None


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        return None
    return distributed
