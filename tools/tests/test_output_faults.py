"""Results are there whole or not at all: every write of `run`, `gap` and `gap batch` fails once, and is killed once.

The work itself is done once and stands in for itself afterwards; what is tried is what comes after it.
`make faults` tries every step.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from evenspin.cli import main
from evenspin.gap import batch
from faulty_disk import Disk, faulty, killed_at, steps_of
from said import Said

Call = Callable[..., Said]
FILES = {"verdict.json": 300, "small.after.csv": 30_000, "figures/one.svg": 9_000, "report.html": 20_000}
VERDICT = {name: [] for name in batch.KEYS} | {"confidence": {}, "details": {"seconds": 1.0}}
VERDICT |= {name: 0.1 for name in batch.KEYS if name.startswith("gap")}


def chosen(steps: list[tuple[str, str]]) -> list[int]:
    """All changes of names, and every seventh of the other steps."""
    numbered = list(enumerate(steps, 1))
    others = numbered if os.environ.get("EVENSPIN_EVERY_STEP") else numbered[::7]
    named = [step for step in numbered if step[1][0] in ("rename", "exchange")]
    return sorted({number for number, _ in [*others, *named]})


def written(folder: Path, *_: Any) -> None:
    """Files of the sizes that a case leaves, written as the report and the log are."""
    for name, size in FILES.items():
        (folder / name).parent.mkdir(exist_ok=True)
        text = json.dumps(VERDICT) if name == "verdict.json" else "x" * size
        (folder / name).write_text(text, encoding="utf-8")


def corrected(folder: Path, *_: Any) -> None:
    for name in ("correction.toml", "experiments.toml", "nominal.toml"):
        (folder / name).write_text("x = 1\n", encoding="utf-8")


@pytest.fixture
def case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A case whose verdict is known without any work."""
    folder = tmp_path / "cases" / "small"
    folder.mkdir(parents=True)
    (folder / "meta.json").write_text("{}")
    result = SimpleNamespace(finding=SimpleNamespace(unknown=False), name="small", case=None, nominal=None)
    monkeypatch.setattr("evenspin.gap.check.checked_case", lambda path: (None, []))
    monkeypatch.setattr("evenspin.gap.result.investigate", lambda *a, **k: result)
    monkeypatch.setattr("evenspin.gap.verdict.verdict_json", lambda result: VERDICT)
    monkeypatch.setattr("evenspin.gap.folder.write_result", written)
    monkeypatch.setattr("evenspin.correct.proposal.proposal_of", lambda *a: None)
    monkeypatch.setattr("evenspin.correct.report.proposal_chapter", lambda *a: None)
    monkeypatch.setattr("evenspin.correct.file.write_correction", corrected)
    monkeypatch.setattr("evenspin.cli.gap._tell", lambda *a: None)
    monkeypatch.setattr(batch, "run_batch", lambda jobs, *a: [batch.solve(job) for job in jobs])
    return folder


def fresh(tmp_path: Path) -> Path:
    place = tmp_path / "disk"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    return place


def tree(folder: Path) -> dict[str, bytes]:
    """Without the manifest, which has the time."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != "manifest.json"
    }


def try_all(evenspin: Call, tmp_path: Path, words: Callable[[Path], tuple], earlier: bool) -> None:
    """`earlier`: an output of the same command stands there already; it stays until the new one takes its place."""

    def prepared() -> Path:
        root = fresh(tmp_path)
        if earlier:
            assert evenspin(*words(root / "out")).status == 0
        return root

    root = prepared()
    steps = steps_of(root, lambda: evenspin(*words(root / "out")))
    good = tree(root / "out")
    assert good and [path.name for path in root.iterdir() if path.name.endswith("lock")] == []

    for at in chosen(steps):
        for error in (errno.ENOSPC, errno.EIO):
            root = prepared()
            with faulty(Disk(root, at, error)):
                said = evenspin(*words(root / "out"))
            what = (at, *steps[at - 1], said)
            assert said.status != 0 or tree(root / "out") == good, what
            assert "Traceback" not in said.err and "Errno" not in said.err, what
            assert "evenspin-" not in said.err, what  # a name that is gone
            assert not (root / "out" / "report.html").exists() or tree(root / "out") == good, what
            if earlier:
                assert tree(root / "out") == good, what
        root = prepared()
        status = killed_at(root, at, lambda root=root: main([str(word) for word in words(root / "out")]))
        assert os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL, (at, steps[at - 1])
        assert not (root / "out" / "report.html").exists() or tree(root / "out") == good, (at, steps[at - 1])
        if earlier:
            assert tree(root / "out") == good, (at, steps[at - 1])
        again = evenspin(*words(root / "out"))  # what was left does not stand in the way
        assert again.status == 0, (at, steps[at - 1], again)
        assert tree(root / "out") == good, (at, steps[at - 1])


@pytest.mark.parametrize("earlier", [False, True], ids=["new", "again"])
def test_a_gap_is_there_whole_or_not_at_all(evenspin: Call, tmp_path: Path, case: Path, earlier: bool) -> None:
    try_all(evenspin, tmp_path, lambda out: ("gap", case, "--out", out), earlier)


def test_a_run_is_there_whole_or_not_at_all(
    evenspin: Call, tmp_path: Path, scenario: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("evenspin.run.write_run", written)
    scenario.write_text(scenario.read_text().replace("duration_s = 0.5", "duration_s = 0.26"))

    try_all(evenspin, tmp_path, lambda out: ("run", scenario, "--out", out), True)


def test_a_batch_keeps_the_cases_that_are_done(evenspin: Call, tmp_path: Path, case: Path) -> None:
    shutil.copytree(case, case.parent / "tiny")
    names = ("small", "tiny")
    root = fresh(tmp_path)
    words = ("gap", "batch", case.parent, "--out")
    steps = steps_of(root, lambda: evenspin(*words, root / "out"))
    good = {name: tree(root / "out" / name) for name in names}

    for at in chosen(steps):
        root = fresh(tmp_path)
        with faulty(Disk(root, at, errno.EIO)) as disk:
            said = evenspin(*words, root / "out")
        what = (at, *disk.steps[at - 1], said)
        there = [name for name in names if (root / "out" / name).exists()]
        assert all(tree(root / "out" / name) == good[name] for name in there), what
        assert said.status in (0, 1, 2) and "Traceback" not in said.err, what
        summary = root / "out" / "summary.json"
        if said.status == 0:
            assert there == list(names) and len(json.loads(summary.read_text())) == 2, what
        elif summary.exists():
            failed = [line["case"] for line in json.loads(summary.read_text()) if "error" in line]
            assert set(failed) == set(names) - set(there), what
            assert all(name in said.err for name in failed), what
