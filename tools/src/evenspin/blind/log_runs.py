"""The command on every log of a set, as a user gives it, with its time."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from evenspin.blind.logs import MODEL, LogTruth

LIMIT_S = 600.0


def run_logs(
    truths: Mapping[str, LogTruth],
    logs: Path,
    results: Path,
    jobs: int,
    progress: Callable[[int], None] = lambda done: None,
) -> None:
    """results/LOG/verdict.json and results/LOG.run.json of each; one that is there already is not run again."""
    results.mkdir(parents=True, exist_ok=True)
    todo = [log for log in truths if not (results / f"{log}.run.json").is_file()]
    with ThreadPoolExecutor(max_workers=jobs) as pool:
        waiting = [pool.submit(_run, logs / truths[log].file, results / log) for log in todo]
        for done, _ in enumerate(as_completed(waiting), start=1):
            progress(done)


def _run(file: Path, out: Path) -> None:
    command = [
        sys.executable,
        "-c",
        "from evenspin.cli import main; main()",
        "gap",
        str(file),
        "--model",
        str(file.parent / MODEL),
        "--out",
        str(out),
    ]
    start_s = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, check=False)
        status, lines = done.returncode, done.stderr.strip().splitlines()
    except subprocess.TimeoutExpired:
        status, lines = -1, [f"stopped after {LIMIT_S:g} s"]
    content = {
        "seconds": time.monotonic() - start_s,
        "status": status,
        "message": (lines[-1] if lines else "").replace(str(file), file.name).replace(str(file.parent), ""),
    }
    (out.parent / f"{out.name}.run.json").write_text(json.dumps(content), encoding="utf-8")
