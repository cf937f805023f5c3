"""What was recorded stays: a disk that fails at every write, a kill at every step, a lost link, a drive that trips.

A virtual drive sends the same octets in every run. So what is left of a raw recording must be the beginning of the
whole one, octet for octet. `make faults` tries every step.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evenspin.bench import Drive
from evenspin.bench.errors import LinkLostError
from evenspin.bench.raw import read_raw
from evenspin.bench.stream import Stream
from evenspin.cli import main
from evenspin.model.machine import builtin_models
from faulty_disk import Disk, faulty, killed_at, steps_of
from said import Said

PORT = "sim:guo2024"
RECORD = ("bench", "record", "--port", PORT, "--speed", 30, "--seconds", 0.5, "--out")
CAPTURE = ("bench", "capture", "--port", PORT, "--speed", 30, "--rows", 300, "--out")
LIST = """\
name = "short"
model = "servo"

[[experiment]]
name = "turn"
mode = "speed"
duration_s = 0.2
log_rate_hz = 1000.0
[experiment.speed_ref_rad_s]
t_s = [0.0, 0.1]
value = [0.0, 20.0]

[[experiment]]
name = "steps"
mode = "current"
duration_s = 0.05
log_rate_hz = 10000.0
rotor_locked = true
[experiment.id_ref_a]
t_s = [0.0, 0.01]
value = [0.0, 1.0]
"""
TRIPS = "over_speed_rad_s = 30.2"  # the overshoot goes beyond; the reference itself may not

Call = Callable[..., Said]


def hidden(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.name.startswith("."))


def visible(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if not path.name.startswith("."))


def fresh(tmp_path: Path) -> Path:
    place = tmp_path / "disk"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    return place


def chosen(steps: list[tuple[str, str]]) -> list[int]:
    """All steps of the raw recording, and every sixth of the others."""
    numbered = list(enumerate(steps, 1))
    others = numbered if os.environ.get("EVENSPIN_EVERY_STEP") else numbered[::6]
    return sorted({number for number, _ in others} | {number for number, (_, name) in numbered if ".raw" in name})


@pytest.fixture
def experiments(tmp_path: Path) -> Path:
    path = tmp_path / "list.toml"
    path.write_text(LIST)
    return path


@pytest.fixture
def tripping(tmp_path: Path) -> Path:
    """The built-in machine, whose drive trips on its way to 30 rad/s."""
    path = tmp_path / "tripping.toml"
    path.write_text(builtin_models()["guo2024"].read_text().replace("[drive]", f"[drive]\n{TRIPS}", 1))
    return path


# ---- the disk


def whole_recording(folder: Path) -> bool:
    names = {"manifest.json", "raw.mcap", "recording.csv"}
    return {path.name for path in folder.iterdir()} == names and read_raw(folder / "raw.mcap").whole


@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EIO], ids=["full", "broken"])
def test_a_recording_is_kept_whichever_write_fails(evenspin: Call, tmp_path: Path, error: int) -> None:
    root = fresh(tmp_path)
    steps = steps_of(root, lambda: evenspin(*RECORD, root / "rec"))
    assert whole_recording(root / "rec") and len(steps) > 15
    whole = (root / "rec" / "raw.mcap").read_bytes()

    for at in chosen(steps):
        root = fresh(tmp_path)
        with faulty(Disk(root, at, error)) as disk:
            said = evenspin(*RECORD, root / "rec")
        what = (at, *disk.steps[at - 1])
        raw = root / "rec.raw.mcap"
        if (root / "rec").exists():  # what stands under its name is whole, whatever went wrong afterwards
            assert whole_recording(root / "rec"), what
            assert said.status in (0, 2), what
        elif raw.exists():
            assert said.status == 2 and said.err.count("\n") == 1, (what, said)
            kept = read_raw(raw)
            ended = any(name == str(raw) for _, name in disk.steps[at - 1 :])  # it was still being written
            assert whole.startswith(raw.read_bytes()) and (whole == raw.read_bytes() or ended), what
            assert f"{len(kept.record)} rows in {raw}" in said.err, what
            assert f"evenspin bench convert {raw} --out {root / 'rec.csv'}" in said.err, what
        else:  # before the first row reached the disk
            assert said.status == 2, (what, said)
            assert disk.steps[at - 1][1] != str(raw) or disk.steps[at - 1][0] in ("open", "write"), what
        assert "Traceback" not in said.err and "Errno" not in said.err and "evenspin-" not in said.err, (what, said)
        assert set(visible(root)) <= {"rec", "rec.raw.mcap"}, what


def test_a_recording_is_kept_whenever_it_is_killed(evenspin: Call, tmp_path: Path) -> None:
    root = fresh(tmp_path)
    steps = steps_of(root, lambda: evenspin(*RECORD, root / "rec"))
    whole = (root / "rec" / "raw.mcap").read_bytes()
    raw_done = steps.index(("fsync", str(root / "rec.raw.mcap"))) + 1

    for at in chosen(steps):
        root = fresh(tmp_path)
        status = killed_at(root, at, lambda root=root: main([str(word) for word in (*RECORD, root / "rec")]))

        assert os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL, at
        held = [path for path in (root / "rec.raw.mcap", root / "rec" / "raw.mcap") if path.exists()]
        if at >= raw_done:  # from the sync at the end of the recording on
            assert held and held[0].read_bytes() == whole, (at, steps[at - 1])
        for raw in held:
            assert whole.startswith(raw.read_bytes()), (at, steps[at - 1])
        if (root / "rec").exists():
            assert whole_recording(root / "rec"), (at, steps[at - 1])


def test_the_disk_that_is_full_is_a_real_one(evenspin: Call, tmp_path: Path) -> None:
    """2 MB of memory as a disk: the raw recording of 20 s fits, its CSV does not."""
    place = tmp_path / "small"
    place.mkdir()
    if os.geteuid() != 0 or os.system(f"mount -t tmpfs -o size=2m tmpfs {place} 2>/dev/null") != 0:
        pytest.skip("a small disk can only be mounted by root")
    try:
        said = evenspin("bench", "record", "--port", PORT, "--seconds", 20, "--speed", 30, "--out", place / "rec")

        raw = place / "rec.raw.mcap"
        assert said.status == 2 and "No space left on device" in said.err
        assert str(raw) in said.err and visible(place) == ["rec.raw.mcap"] and hidden(place) == []
        assert len(read_raw(raw).record) >= 20_000 and read_raw(raw).whole
        again = evenspin("bench", "record", "--port", PORT, "--seconds", 1, "--out", place / "rec")
        assert again.status == 2 and f"evenspin bench convert {raw}" in again.err
        assert evenspin("bench", "convert", raw, "--out", tmp_path / "rescued.csv").status == 0
        assert len(np.genfromtxt(tmp_path / "rescued.csv", delimiter=",", skip_header=1)) >= 20_000
    finally:
        os.system(f"umount {place}")


def test_a_list_of_experiments_is_kept_whichever_write_fails(evenspin: Call, experiments: Path, tmp_path: Path) -> None:
    words = ("bench", "run", experiments, "--port", "sim:servo", "--yes", "--out")
    root = fresh(tmp_path)
    steps = steps_of(root, lambda: evenspin(*words, root / "case"))
    complete = {"manifest.json", "meta.json", "turn.csv", "steps.csv", "raw"}
    assert set(visible(root / "case")) == complete
    whole = {path.name: path.read_bytes() for path in (root / "case" / "raw").iterdir()}
    assert sorted(whole) == ["steps.mcap", "turn.mcap"]

    for at in chosen(steps):
        root = fresh(tmp_path)
        with faulty(Disk(root, at, errno.ENOSPC)) as disk:
            said = evenspin(*words, root / "case")
        what = (at, *disk.steps[at - 1])
        assert "Traceback" not in said.err and said.err.count("\n") <= 1, (what, said)
        if (root / "case").exists():
            assert set(visible(root / "case")) >= {"manifest.json", "meta.json", "raw"}, what
            continue
        assert said.status == 2, (what, said)
        held = sorted((root / "case.raw").glob("*.mcap")) if (root / "case.raw").is_dir() else []
        for raw in held:
            assert f"evenspin bench convert {root / 'case.raw'}" in said.err, (what, said)
            touched = any(name == str(raw) for _, name in disk.steps[at - 1 :])
            assert whole[raw.name].startswith(raw.read_bytes()), what
            assert whole[raw.name] == raw.read_bytes() or touched, what
        assert held or at < 12, (what, said)


def test_a_capture_is_kept_whichever_write_fails(evenspin: Call, tmp_path: Path) -> None:
    root = fresh(tmp_path)
    steps = steps_of(root, lambda: evenspin(*CAPTURE, root / "step.csv"))
    assert visible(root) == ["step.csv", "step.csv.json"] and hidden(root) == []
    taken = (root / "step.csv").read_text()

    for at in chosen(steps):
        root = fresh(tmp_path)
        with faulty(Disk(root, at, errno.ENOSPC)) as disk:
            said = evenspin(*CAPTURE, root / "step.csv")
        what = (at, *disk.steps[at - 1])
        assert said.status in (0, 2) and said.err.count("\n") <= 1 and "Errno" not in said.err, (what, said)
        if (root / "step.csv").exists():
            assert (root / "step.csv").read_text() == taken, what
            continue
        assert said.status == 2, what
        raw = root / "step.raw.mcap"
        if raw.exists() and read_raw(raw).whole:
            assert f"evenspin bench convert {raw}" in said.err, (what, said)
            again = evenspin("bench", "convert", raw, "--out", root / "again.csv")
            assert again.status == 0 and (root / "again.csv").read_text() == taken, what  # the time is from the trigger
        else:
            assert disk.steps[at - 1][1].startswith((str(raw), str(root / ".step"))), what


# ---- the link


@pytest.fixture
def link_that_breaks(monkeypatch: pytest.MonkeyPatch) -> None:
    """After 50 blocks the cable is pulled, and stays out."""
    read, count = Stream.read, 0

    def broken(self: Stream, timeout_s: float = 0.5) -> Any:
        nonlocal count
        count += 1
        if count > 50:
            raise LinkLostError("the link is lost (test); check the cable")
        return read(self, timeout_s)

    monkeypatch.setattr(Stream, "read", broken)


def test_a_lost_link_names_the_file_and_the_command(evenspin: Call, tmp_path: Path, link_that_breaks: None) -> None:
    out, raw = tmp_path / "rec", tmp_path / "rec.raw.mcap"
    said = evenspin("bench", "record", "--port", PORT, "--seconds", 100, "--out", out)

    assert said.status == 3 and said.err.count("\n") == 1
    assert "the link is lost" in said.err and f"{len(read_raw(raw).record)} rows in {raw}" in said.err
    assert f"`evenspin bench convert {raw} --out {tmp_path / 'rec.csv'}`" in said.err


def test_a_rescued_recording_is_not_written_over(
    evenspin: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, link_that_breaks: None
) -> None:
    words = ("bench", "record", "--port", PORT, "--seconds", 100, "--out", tmp_path / "rec")
    raw = tmp_path / "rec.raw.mcap"
    evenspin(*words)
    before = raw.read_bytes()

    again = evenspin(*words)

    assert again.status == 2 and raw.read_bytes() == before
    assert str(raw) in again.err and f"evenspin bench convert {raw}" in again.err and "--force" in again.err
    assert evenspin(*words, "--force").status == 3  # nothing new was recorded: what was there stays
    assert raw.read_bytes() == before
    monkeypatch.undo()
    forced = evenspin(*RECORD, tmp_path / "rec", "--force")
    assert forced.status == 0 and visible(tmp_path) == ["rec"] and hidden(tmp_path) == []


def test_a_recording_without_a_row_is_no_recording(
    evenspin: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nothing(self: Stream, timeout_s: float = 0.5) -> Any:
        raise LinkLostError("the link is lost (test)")

    with monkeypatch.context() as patch:
        patch.setattr(Stream, "read", nothing)
        assert evenspin(*RECORD, tmp_path / "rec").status == 3
    assert visible(tmp_path) == []
    assert evenspin(*RECORD, tmp_path / "rec").status == 0


def test_the_drive_holds_a_capture_that_did_not_come_through(evenspin: Call, tmp_path: Path) -> None:
    """`--fetch` reads what an earlier capture left in the drive: the same octets, and nothing moves."""
    with Drive.connect(PORT) as drive:
        first = drive.capture(("iq_a", "vq_v"), rows=100)
        second = drive.read_capture()
        np.testing.assert_array_equal(first.values, second.values)
    refused = evenspin("bench", "capture", "--port", PORT, "--fetch", "--speed", 3, "--out", tmp_path / "a.csv")
    assert refused.status == 2 and "--speed" in refused.err and "--fetch" in refused.err
    empty = evenspin("bench", "capture", "--port", PORT, "--fetch", "--seconds", 0, "--out", tmp_path / "a.csv")
    assert empty.status == 2 and visible(tmp_path) == []


# ---- the drive


def test_a_trip_is_in_the_headline_in_the_file_and_in_the_exit_status(
    evenspin: Call, tmp_path: Path, tripping: Path
) -> None:
    out = tmp_path / "rec"
    words = ("--speed", 30, "--seconds", 0.5, "--signal", "fault", "--signal", "speed_rad_s", "--out", out)
    said = evenspin("bench", "record", "--port", f"sim:{tripping}", *words)

    assert said.status == 1
    headline = next(line for line in said.out.splitlines() if " rows, " in line)
    assert "TRIPPED" in headline and "over_speed" in headline
    assert said.err.count("\n") == 1 and "over_speed" in said.err
    rows = np.genfromtxt(out / "recording.csv", delimiter=",", names=True)
    assert rows["t_s"][-1] >= 0.499  # it goes on to its end
    trip = json.loads((out / "manifest.json").read_text())["recorded"]["trip"]
    at_s = rows["t_s"][np.argmax(rows["fault"] != 0.0)]  # as the drive's own signal says, row by row
    # a row a millisecond; what the speed interrupt finds gets the time of the next current period, 0.1 ms later
    assert trip["fault"] == "over_speed" and at_s - 0.001 <= trip["t_s"] <= at_s + 1.5e-4
    (event,) = [event for event in read_raw(out / "raw.mcap").events if "fault" in event]
    assert event["fault"] == "over_speed" and event["t_s"] == pytest.approx(trip["t_s"])


def test_no_trip_no_word_of_one(evenspin: Call, tmp_path: Path) -> None:
    said = evenspin(*RECORD, tmp_path / "rec", "--json")

    assert said.status == 0 and "TRIP" not in said.err
    assert json.loads(said.out)["trip"] is None


def test_a_trip_while_it_captures_is_told_unless_it_was_waited_for(
    evenspin: Call, tmp_path: Path, tripping: Path
) -> None:
    words = ("bench", "capture", "--port", f"sim:{tripping}", "--speed", 30)
    unasked = evenspin(*words, "--out", tmp_path / "a.csv")
    waited = evenspin(*words, "--rows", 300, "--pre", 200, "--trigger", "fault", "--out", tmp_path / "b.csv")

    assert (unasked.status, waited.status) == (1, 0)
    for said, name in ((unasked, "a"), (waited, "b")):
        assert "TRIPPED" in said.out
        (event,) = [
            event
            for event in json.loads((tmp_path / f"{name}.csv.json").read_text())["recorded"]["events"]
            if "fault" in event
        ]
        assert event["fault"] == "over_speed"
    assert event["t_s"] == pytest.approx(0.0, abs=2e-4)  # the trigger was the trip


def test_the_experiment_that_tripped_is_named(evenspin: Call, tmp_path: Path) -> None:
    text = builtin_models()["servo"].read_text()
    model = tmp_path / "tripping.toml"
    model.write_text(text.replace("[drive]", "[drive]\nover_speed_rad_s = 50.2", 1))
    fast = LIST.split("[[experiment]]")[1].replace('"turn"', '"faster"').replace("20.0]", "50.0]").replace("0.2", "0.6")
    path = tmp_path / "list.toml"
    path.write_text(f"{LIST}\n[[experiment]]{fast}")
    out = tmp_path / "case"

    said = evenspin("bench", "run", path, "--port", f"sim:{model}", "--yes", "--out", out)

    assert said.status == 1
    assert "TRIPPED" in said.out and said.err.startswith("faster: the drive tripped at ") and "over_speed" in said.err
    meta = json.loads((out / "meta.json").read_text())
    assert meta["experiments"] == ["turn", "steps"]
    assert meta["tripped"]["experiment"] == "faster" and meta["tripped"]["fault"] == "over_speed"
    assert 0.1 < meta["tripped"]["t_s"] < 0.6
    partial = read_raw(out / "raw" / "faster.mcap")
    assert len(partial.record) > 50
